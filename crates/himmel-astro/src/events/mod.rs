//! When things happen: rise, set, transit, twilights, the Moon's phases, eclipses.

mod lunar_eclipse;
mod phases;
mod rise_set;
mod search;
mod solar_eclipse;

pub use lunar_eclipse::{LunarEclipse, LunarEclipseKind, ShadowConvention, lunar_eclipses};
pub use phases::{MoonPhase, PhaseEvent, moon_phases};
pub use rise_set::{Crossing, CrossingKind, Horizon, Transit, crossings, transits};
pub(crate) use solar_eclipse::covered_part;
pub use solar_eclipse::{SolarEclipse, SolarEclipseKind, SolarMoment, solar_eclipses};

use crate::ephemeris::Ephemeris;
use crate::error::{AstroError, Result};
use crate::time::JulianDateTt;

/// Longest span that one call searches: 10,000 years of eclipses take minutes, more takes the caller by surprise.
const LONGEST_SPAN_DAYS: f64 = 3_653_000.0;

/// Refuses spans that run backwards or too far, and those that the ephemeris does not reach to the end.
fn check_span(ephemeris: &dyn Ephemeris, from: JulianDateTt, to: JulianDateTt) -> Result<()> {
    let days = to.jd() - from.jd();
    if !(0.0..=LONGEST_SPAN_DAYS).contains(&days) {
        return Err(AstroError::OutOfRange {
            quantity: "the span from start to end",
            range: "0..=3653000 days",
            value: days,
            hint: " (does it end before it begins?)",
        });
    }
    ephemeris.earth_and_moon(from.to_tdb())?;
    ephemeris.earth_and_moon(to.to_tdb())?;
    Ok(())
}
