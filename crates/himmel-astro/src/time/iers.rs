//! What the IERS observed of the Earth's rotation since 1962, every two days (`assets/astro/time`).

use crate::constants::ARCSECOND_RAD;

static DATA: &[u8] = include_bytes!("../../../../assets/astro/time/iers.bin");
const HEADER_BYTES: usize = 12;
const ROW_BYTES: usize = 8;

fn i32_at(at: usize) -> i32 {
    DATA.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, i32::from_le_bytes)
}

fn i16_at(at: usize) -> i16 {
    DATA.get(at..at + 2).and_then(|b| b.try_into().ok()).map_or(0, i16::from_le_bytes)
}

/// Delta T (s) and the pole's place (arcseconds) in one row.
fn row(index: usize) -> [f64; 3] {
    let at = HEADER_BYTES + index * ROW_BYTES;
    [f64::from(i32_at(at)) * 1e-5, f64::from(i16_at(at + 4)) * 1e-4, f64::from(i16_at(at + 6)) * 1e-4]
}

/// First and last MJD (UTC) of the table.
pub(super) fn span_mjd() -> (f64, f64) {
    let (first, step, rows) = (i32_at(0), i32_at(4), i32_at(8));
    (f64::from(first), f64::from(first + step * (rows - 1)))
}

/// Cubic through the four neighbouring rows; Delta T has no leaps, so nothing needs care at leap seconds.
fn interpolate(mjd_utc: f64) -> Option<[f64; 3]> {
    let (first, last) = span_mjd();
    if !(mjd_utc >= first && mjd_utc <= last) {
        return None;
    }
    let rows = i32_at(8) as usize;
    let x = (mjd_utc - first) / f64::from(i32_at(4));
    let i = (x as usize).clamp(1, rows - 3);
    let t = x - i as f64;
    let w = [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ];
    let mut sum = [0.0; 3];
    for (k, weight) in w.iter().enumerate() {
        for (s, v) in sum.iter_mut().zip(row(i + k - 1)) {
            *s += weight * v;
        }
    }
    Some(sum)
}

/// TT − UT1 in seconds where it was observed or is predicted by the IERS.
pub(super) fn delta_t_s(mjd_utc: f64) -> Option<f64> {
    interpolate(mjd_utc).map(|v| v[0])
}

/// Where the Earth's pole of rotation leaves its crust.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PolarMotion {
    /// Towards Greenwich.
    pub x_rad: f64,
    /// Towards 90° west.
    pub y_rad: f64,
}

/// The IERS value at a Julian date (UTC or TT: a minute does not matter), since 1962; `None` outside.
pub fn polar_motion(jd: f64) -> Option<PolarMotion> {
    interpolate(jd - 2_400_000.5).map(|v| PolarMotion { x_rad: v[1] * ARCSECOND_RAD, y_rad: v[2] * ARCSECOND_RAD })
}
