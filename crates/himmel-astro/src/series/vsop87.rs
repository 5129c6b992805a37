//! The planets by VSOP87B, truncated   [bretagnon1988].

use super::vsop87_tables as tables;
use super::waves::{Wave, power_sum};
use crate::body::Body;
use crate::constants::{AU_M, J2000_JD, SECONDS_PER_DAY};
use crate::ephemeris::State;
use crate::error::{AstroError, Result};
use crate::time::JulianDateTdb;
use glam::{DMat3, DVec3};

/// Longitude, latitude (rad) and distance (au), each a list of powers of t.
pub(super) struct Planet {
    pub longitude: &'static [&'static [Wave]],
    pub latitude: &'static [&'static [Wave]],
    pub radius: &'static [&'static [Wave]],
}

/// Days in a Julian millennium, the theory's unit of time.
const DAYS_PER_MILLENNIUM: f64 = 365_250.0;
/// The theory's span: 4000 years about J2000 for the inner planets.
const SPAN_DAYS: f64 = 4.0 * DAYS_PER_MILLENNIUM;

/// Equator and equinox of FK5 from VSOP87's dynamical ecliptic   [bretagnon1988, `vsop87.txt`].
fn equator_from_ecliptic() -> DMat3 {
    DMat3::from_cols(
        DVec3::new(1.0, -0.000_000_479_966, 0.0),
        DVec3::new(0.000_000_440_360, 0.917_482_137_087, 0.397_776_982_902),
        DVec3::new(-0.000_000_190_919, -0.397_776_982_902, 0.917_482_137_087),
    )
}

fn planet(body: Body) -> Option<&'static Planet> {
    Some(match body {
        Body::Mercury => &tables::MERCURY,
        Body::Venus => &tables::VENUS,
        Body::Earth => &tables::EARTH,
        Body::Mars => &tables::MARS,
        Body::Jupiter => &tables::JUPITER,
        Body::Saturn => &tables::SATURN,
        Body::Uranus => &tables::URANUS,
        Body::Neptune => &tables::NEPTUNE,
        _ => return None,
    })
}

/// A planet from the Sun, geometric.
pub(crate) fn heliocentric(body: Body, tdb: JulianDateTdb) -> Result<State> {
    let series = planet(body).ok_or_else(|| AstroError::Unsupported {
        ephemeris: "VSOP87",
        body: body.to_string(),
        hint: "it knows Mercury to Neptune and the Earth",
    })?;
    let days = tdb.jd() - J2000_JD;
    if days.abs() > SPAN_DAYS {
        return Err(AstroError::DateOutOfSpan { jd: tdb.jd(), span: "2000 BC to AD 6000", theory: "VSOP87" });
    }
    let t = days / DAYS_PER_MILLENNIUM;
    let (l, l_rate) = power_sum(series.longitude, t);
    let (b, b_rate) = power_sum(series.latitude, t);
    let (r, r_rate) = power_sum(series.radius, t);
    let (sin_l, cos_l) = l.sin_cos();
    let (sin_b, cos_b) = b.sin_cos();
    let outward = DVec3::new(cos_b * cos_l, cos_b * sin_l, sin_b);
    let eastward = DVec3::new(-cos_b * sin_l, cos_b * cos_l, 0.0);
    let northward = DVec3::new(-sin_b * cos_l, -sin_b * sin_l, cos_b);
    let per_second = AU_M / (DAYS_PER_MILLENNIUM * SECONDS_PER_DAY);
    let to_equator = equator_from_ecliptic();
    Ok(State {
        position_m: to_equator * outward * (r * AU_M),
        velocity_m_s: to_equator * (outward * r_rate + eastward * (r * l_rate) + northward * (r * b_rate)) * per_second,
    })
}
