use super::{Ephemeris, State};
use crate::body::Body;
use crate::error::{AstroError, Result};
use crate::series::vsop87;
use crate::time::JulianDateTdb;

/// Analytic series only: no data file, any date within 4000 years of J2000.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fast;

impl Ephemeris for Fast {
    fn name(&self) -> &'static str {
        "fast"
    }

    fn state(&self, body: Body, tdb: JulianDateTdb) -> Result<State> {
        match body {
            Body::Sun => Ok(State::default()),
            Body::Earth => vsop87::heliocentric(Body::Earth, tdb),
            _ => Err(AstroError::Unsupported {
                ephemeris: "fast",
                body: body.to_string(),
                hint: "not yet",
            }),
        }
    }

    fn earth_and_moon(&self, tdb: JulianDateTdb) -> Result<(State, State)> {
        Ok((self.state(Body::Earth, tdb)?, State::default()))
    }
}
