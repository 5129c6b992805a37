//! The Moon by ELP/MPP02, fitted to JPL's DE405, truncated   [chapront2003].

use super::elp_tables::{DISTANCE, LATITUDE, LONGITUDE, MEAN_LONGITUDE};
use super::waves::sin_cos;
use crate::constants::{ARCSECOND_RAD, DAYS_PER_CENTURY, SECONDS_PER_DAY};
use crate::earth::{axes_turned_x, axes_turned_z};
use crate::ephemeris::State;
use crate::error::{AstroError, Result};
use crate::time::JulianDateTdb;
use glam::{DMat3, DVec3};

/// A sin(φ₀ + φ₁ T + … + φ₄ T⁴): amplitude in arcseconds or km.
pub(super) type Wave = [f64; 6];

/// Beyond this the polynomial of the mean longitude loses its meaning.
const SPAN_CENTURIES: f64 = 40.0;

fn polynomial(c: &[f64], t: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// Σ Tⁿ Σ A sin φ and its derivative by T.
fn power_sum(powers: &[&[Wave]], t: f64) -> (f64, f64) {
    let (mut value, mut rate, mut t_n, mut t_n_rate) = (0.0, 0.0, 1.0, 0.0);
    for (n, waves) in powers.iter().enumerate() {
        let (mut v, mut r) = ([0.0; 4], [0.0; 4]);
        let mut fours = waves.chunks_exact(4);
        let term = |w: &Wave| {
            let [a, p0, p1, p2, p3, p4] = *w;
            let (sin, cos) = sin_cos(p0 + t * (p1 + t * (p2 + t * (p3 + t * p4))));
            (a * sin, a * (p1 + 2.0 * t * p2) * cos)
        };
        for four in &mut fours {
            for k in 0..4 {
                let (value, rate) = term(&four[k]);
                v[k] += value;
                r[k] += rate;
            }
        }
        for w in fours.remainder() {
            let (value, rate) = term(w);
            v[0] += value;
            r[0] += rate;
        }
        let (v, r): (f64, f64) = (v.iter().sum(), r.iter().sum());
        value += t_n * v;
        rate += t_n * r + t_n_rate * v;
        t_n_rate = (n + 1) as f64 * t_n;
        t_n *= t;
    }
    (value, rate)
}

/// The inertial mean ecliptic and equinox of J2000 from the theory's mean ecliptic of date and departure point   [laskar1986].
fn j2000_from_date(t: f64) -> DMat3 {
    let p = t * polynomial(&[0.101_803_91e-4, 0.470_204_39e-6, -0.541_736_7e-9, -0.250_794_8e-11, 0.463_486e-14], t);
    let q = t * polynomial(&[-0.113_469_002e-3, 0.123_726_74e-6, 0.126_541_70e-8, -0.137_180_8e-11, -0.320_334e-14], t);
    let root = (1.0 - p * p - q * q).sqrt();
    DMat3::from_cols(
        DVec3::new(1.0 - 2.0 * p * p, 2.0 * p * q, -2.0 * p * root),
        DVec3::new(2.0 * p * q, 1.0 - 2.0 * q * q, 2.0 * q * root),
        DVec3::new(2.0 * p * root, -2.0 * q * root, 1.0 - 2.0 * p * p - 2.0 * q * q),
    )
}

/// The Moon from the Earth's centre, geometric, along GCRS axes.
///
/// The ecliptic's obliquity is 84,381.406″ and its equinox 0.05″ off the GCRS' axis, which leaves 0.05″ (largest) against DE440
/// with all of the theory's 35,901 terms.
pub(crate) fn geocentric_moon(tdb: JulianDateTdb) -> Result<State> {
    let t = tdb.centuries_since_j2000();
    if t.abs() > SPAN_CENTURIES {
        return Err(AstroError::DateOutOfSpan { jd: tdb.jd(), span: "2000 BC to AD 6000", theory: "ELP/MPP02" });
    }
    let (l, l_rate) = power_sum(LONGITUDE, t);
    let (b, b_rate) = power_sum(LATITUDE, t);
    let (r, r_rate) = power_sum(DISTANCE, t);
    let l = polynomial(&MEAN_LONGITUDE, t) + l * ARCSECOND_RAD;
    let l_rate = MEAN_LONGITUDE[1] + 2.0 * t * MEAN_LONGITUDE[2] + l_rate * ARCSECOND_RAD;
    let (sin_l, cos_l) = l.sin_cos();
    let (sin_b, cos_b) = (b * ARCSECOND_RAD).sin_cos();
    let outward = DVec3::new(cos_b * cos_l, cos_b * sin_l, sin_b);
    let eastward = DVec3::new(-cos_b * sin_l, cos_b * cos_l, 0.0);
    let northward = DVec3::new(-sin_b * cos_l, -sin_b * sin_l, cos_b);
    let velocity = outward * r_rate + eastward * (r * l_rate) + northward * (r * b_rate * ARCSECOND_RAD);
    let gcrs_from_ecliptic =
        (axes_turned_x(84_381.406 * ARCSECOND_RAD) * axes_turned_z(-0.05 * ARCSECOND_RAD)).transpose();
    let turn = gcrs_from_ecliptic * j2000_from_date(t);
    Ok(State {
        position_m: turn * outward * (r * 1e3),
        velocity_m_s: turn * velocity * (1e3 / (DAYS_PER_CENTURY * SECONDS_PER_DAY)),
    })
}
