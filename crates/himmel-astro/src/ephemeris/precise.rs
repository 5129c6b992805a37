use super::pack::Pack;
use super::{Ephemeris, Fast, State};
use crate::body::Body;
use crate::constants::EARTH_MOON_MASS_RATIO;
use crate::error::{AstroError, Result};
use crate::time::JulianDateTdb;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

static EMBEDDED: &[u8] = include_bytes!("../../../../assets/astro/de440/de440.pack");

/// JPL's DE440 within 0.004″ as seen from the Earth, 1850–2150; outside, the series of [`Fast`] take over.
#[derive(Debug, Clone)]
pub struct Precise {
    pack: Arc<Pack>,
}

impl Precise {
    /// The pack that is built in.
    pub fn embedded() -> Result<Self> {
        static PACK: OnceLock<Result<Arc<Pack>>> = OnceLock::new();
        let pack = PACK.get_or_init(|| Pack::parse(Cow::Borrowed(EMBEDDED)).map(Arc::new)).clone()?;
        Ok(Self { pack })
    }

    /// A pack of the caller's, for example of another span (`xtask/astro/make_pack.py` makes them).
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self> {
        Pack::parse(Cow::Owned(bytes)).map(|p| Self { pack: Arc::new(p) })
    }

    /// Whether the pack itself answers at this date, rather than the series.
    pub fn covers(&self, tdb: JulianDateTdb) -> bool {
        self.pack.covers(tdb.jd())
    }

    fn track(&self, ident: usize, body: Body, tdb: JulianDateTdb) -> Result<State> {
        self.pack.state(ident, tdb.jd()).ok_or_else(|| AstroError::Unsupported {
            ephemeris: "this ephemeris pack",
            body: body.to_string(),
            hint: "use a pack that holds it",
        })
    }
}

impl Ephemeris for Precise {
    fn name(&self) -> &'static str {
        "precise"
    }

    fn state(&self, body: Body, tdb: JulianDateTdb) -> Result<State> {
        if !self.covers(tdb) {
            return Fast.state(body, tdb);
        }
        let ident = match body {
            Body::Earth => return self.earth_and_moon(tdb).map(|(earth, _)| earth),
            Body::Moon => return self.earth_and_moon(tdb).map(|(earth, moon)| earth + moon),
            Body::Sun => 0,
            Body::Mercury => 3,
            Body::Venus => 4,
            Body::Mars => 5,
            Body::Jupiter => 6,
            Body::Saturn => 7,
            Body::Uranus => 8,
            Body::Neptune => 9,
            Body::Pluto => 10,
        };
        self.track(ident, body, tdb)
    }

    fn earth_and_moon(&self, tdb: JulianDateTdb) -> Result<(State, State)> {
        if !self.covers(tdb) {
            return Fast.earth_and_moon(tdb);
        }
        let moon = self.track(1, Body::Moon, tdb)?;
        let barycentre = self.track(2, Body::Earth, tdb)?;
        let share = 1.0 / (1.0 + EARTH_MOON_MASS_RATIO);
        let earth = State {
            position_m: barycentre.position_m - moon.position_m * share,
            velocity_m_s: barycentre.velocity_m_s - moon.velocity_m_s * share,
        };
        Ok((earth, moon))
    }
}
