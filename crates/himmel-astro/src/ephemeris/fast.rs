use super::{Ephemeris, State};
use crate::body::Body;
use crate::error::Result;
use crate::series::{elp, pluto, vsop87};
use crate::time::JulianDateTdb;

/// Analytic series only: no data file; any date from 2000 BC to AD 6000 (Pluto: 1885–2099).
#[derive(Debug, Clone, Copy, Default)]
pub struct Fast;

impl Ephemeris for Fast {
    fn name(&self) -> &'static str {
        "fast"
    }

    fn state(&self, body: Body, tdb: JulianDateTdb) -> Result<State> {
        match body {
            Body::Sun => Ok(State::default()),
            Body::Moon => self.earth_and_moon(tdb).map(|(earth, moon)| earth + moon),
            Body::Pluto => pluto::heliocentric(tdb),
            _ => vsop87::heliocentric(body, tdb),
        }
    }

    fn earth_and_moon(&self, tdb: JulianDateTdb) -> Result<(State, State)> {
        Ok((vsop87::heliocentric(Body::Earth, tdb)?, elp::geocentric_moon(tdb)?))
    }
}
