//! Clocks: UTC, UT1, TT and TDB as types that cannot be mixed up, and the ways between them.

mod civil;
mod delta_t;
mod iers;
mod instant;
mod leap_seconds;
mod spline_table;

pub use delta_t::{DeltaTModel, delta_t_s};
pub use iers::{PolarMotion, polar_motion};
pub use instant::Instant;

use crate::constants::{DAYS_PER_CENTURY, J2000_JD};
use crate::error::{AstroError, Result};

/// Dates beyond these are refused everywhere: 13,000 BC to AD 17,000 (the series end earlier).
pub(crate) const EARLIEST_JD: f64 = -3_027_000.0;
pub(crate) const LATEST_JD: f64 = 7_931_000.0;

macro_rules! julian_date {
    ($name:ident, $scale:literal) => {
        #[doc = concat!("A Julian date in ", $scale, ", in days.")]
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            /// A finite Julian date between 13,000 BC and AD 17,000.
            pub fn new(jd: f64) -> Result<Self> {
                if (EARLIEST_JD..=LATEST_JD).contains(&jd) {
                    Ok(Self(jd))
                } else {
                    Err(AstroError::DateOutOfSpan { jd, span: "13,000 BC to AD 17,000", theory: "all clocks here" })
                }
            }

            /// The date in days.
            pub fn jd(self) -> f64 {
                self.0
            }

            /// Julian centuries since J2000.0.
            pub fn centuries_since_j2000(self) -> f64 {
                (self.0 - J2000_JD) / DAYS_PER_CENTURY
            }

            // Not every clock needs it yet.
            #[allow(dead_code)]
            /// The date some seconds later. Leaves the range only by what the caller adds.
            pub(crate) fn plus_seconds(self, seconds: f64) -> Self {
                Self(self.0 + seconds / crate::constants::SECONDS_PER_DAY)
            }

            #[allow(dead_code)]
            pub(crate) fn unchecked(jd: f64) -> Self {
                Self(jd)
            }
        }
    };
}

julian_date!(JulianDateUtc, "UTC, a civil day with a leap second stretched");
julian_date!(JulianDateUt1, "UT1, the Earth's rotation");
julian_date!(JulianDateTt, "Terrestrial Time");
julian_date!(JulianDateTdb, "Barycentric Dynamical Time, the ephemerides' argument");

impl JulianDateTt {
    /// The same instant in TDB, to 10 µs.
    ///
    /// TDB − TT = 1.657 ms sin g + 0.022 ms sin(L − L_J),  g = 357.53° + 0.98560028° d   [almanac2006]
    pub fn to_tdb(self) -> JulianDateTdb {
        JulianDateTdb(self.0).plus_seconds(tdb_minus_tt_s(self.0))
    }
}

impl JulianDateTdb {
    /// The same instant in TT, to 10 µs.
    pub fn to_tt(self) -> JulianDateTt {
        JulianDateTt(self.0).plus_seconds(-tdb_minus_tt_s(self.0))
    }
}

fn tdb_minus_tt_s(jd: f64) -> f64 {
    let d = jd - J2000_JD;
    let g = (357.53 + 0.985_600_28 * d).to_radians();
    let l_lj = (246.11 + 0.902_517_92 * d).to_radians();
    0.001_657 * g.sin() + 0.000_022 * l_lj.sin()
}
