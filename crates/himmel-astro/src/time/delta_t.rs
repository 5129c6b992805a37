//! Delta T = TT − UT1: how far the Earth's uneven rotation has fallen behind.

use super::spline_table::SPLINE;
use super::{JulianDateTt, iers};
use crate::constants::{DAYS_PER_YEAR, J2000_JD};
use crate::error::{Result, in_range};

/// Where Delta T comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DeltaTModel {
    /// IERS observations and predictions since 1962; before, the spline of Stephenson, Morrison and Hohenkerk (2016, in its
    /// issue of 2020) from 720 BC; far from both, their parabola −320 + 32.5 ((year − 1825)/100)². Between the last IERS
    /// value and the parabola a cubic over 800 years: in 2050 that gives 75 s, and models differ by 22 s there.
    #[default]
    Standard,
    /// The caller's own value in seconds.
    Fixed(f64),
}

impl DeltaTModel {
    /// A fixed Delta T in −100,000..=1,000,000 s.
    pub fn fixed(seconds: f64) -> Result<Self> {
        in_range("Delta T", "-100000..=1000000 s", seconds, -1e5, 1e6, "").map(Self::Fixed)
    }

    /// TT − UT1 in seconds.
    pub fn seconds(self, tt: JulianDateTt) -> f64 {
        match self {
            Self::Fixed(seconds) => seconds,
            Self::Standard => delta_t_s(tt),
        }
    }
}

/// Years over which the curve runs from data to the parabola.
const PATCH_YEARS: f64 = 800.0;
/// Years before 1962 in which the spline is led to the IERS series (they differ there by 0.05 s).
const JOIN_YEARS: f64 = 8.0;

/// TT − UT1 in seconds by the standard model ([`DeltaTModel::Standard`]).
///
/// Laws tested: continuous over its whole range; IERS values reproduced.
pub fn delta_t_s(tt: JulianDateTt) -> f64 {
    let mjd = tt.jd() - 2_400_000.5;
    // The table's argument is UTC; Delta T moves by 2 ms a day at most, so its own size does not matter.
    if let Some(seconds) = iers::delta_t_s(mjd - 69.0 / 86_400.0) {
        return seconds;
    }
    let year = 2000.0 + (tt.jd() - J2000_JD) / DAYS_PER_YEAR;
    let (first_mjd, last_mjd) = iers::span_mjd();
    if mjd < last_mjd {
        let first_year = year_of_mjd(first_mjd);
        let offset = iers::delta_t_s(first_mjd).unwrap_or(0.0) - spline(first_year);
        let fade = (1.0 - (first_year - year) / JOIN_YEARS).clamp(0.0, 1.0);
        return spline(year) + offset * fade * fade * (3.0 - 2.0 * fade);
    }
    let x0 = year_of_mjd(last_mjd);
    let y0 = iers::delta_t_s(last_mjd).unwrap_or(0.0);
    let slope0 = (y0 - iers::delta_t_s(last_mjd - DAYS_PER_YEAR).unwrap_or(y0)).max(0.0);
    let x1 = ((x0 + PATCH_YEARS) / 100.0).floor() * 100.0;
    if year < x1 { hermite(year, x0, y0, slope0, x1, parabola(x1), parabola_slope(x1)) } else { parabola(year) }
}

fn year_of_mjd(mjd: f64) -> f64 {
    2000.0 + (mjd + 2_400_000.5 - J2000_JD) / DAYS_PER_YEAR
}

/// −320 + 32.5 ((year − 1825)/100)² s   [stephenson2016]
fn parabola(year: f64) -> f64 {
    let u = (year - 1825.0) / 100.0;
    -320.0 + 32.5 * u * u
}

fn parabola_slope(year: f64) -> f64 {
    0.65 * (year - 1825.0) / 100.0
}

fn spline(year: f64) -> f64 {
    let cubic = |[x0, x1, a3, a2, a1, a0]: [f64; 6], at: f64| {
        let t = (at - x0) / (x1 - x0);
        ((a3 * t + a2) * t + a1) * t + a0
    };
    let start = SPLINE[0][0];
    if year >= start {
        let i = SPLINE.partition_point(|row| row[0] <= year).saturating_sub(1);
        return cubic(SPLINE[i], year);
    }
    let before = start - PATCH_YEARS;
    if year < before {
        return parabola(year);
    }
    let row = SPLINE[0];
    let slope = row[4] / (row[1] - row[0]);
    hermite(year, before, parabola(before), parabola_slope(before), start, row[5], slope)
}

fn hermite(x: f64, x0: f64, y0: f64, slope0: f64, x1: f64, y1: f64, slope1: f64) -> f64 {
    let w = x1 - x0;
    let t = (x - x0) / w;
    let (t2, t3) = (t * t, t * t * t);
    y0 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + slope0 * w * (t3 - 2.0 * t2 + t)
        + y1 * (3.0 * t2 - 2.0 * t3)
        + slope1 * w * (t3 - t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_year(year: f64) -> f64 {
        delta_t_s(JulianDateTt::new(J2000_JD + (year - 2000.0) * DAYS_PER_YEAR).unwrap())
    }

    #[test]
    fn published_values() {
        // IERS: 63.8285 s at 2000-01-01 0h; 67.6439 at 2015-01-01.
        assert!((delta_t_s(JulianDateTt::new(2_451_544.5).unwrap()) - 63.8285).abs() < 5e-4);
        assert!((delta_t_s(JulianDateTt::new(2_457_023.5).unwrap()) - 67.6439).abs() < 5e-4);
        // Skyfield 1.55 with the same spline: 9.3389 s in 1850, 28.9320 s in 1950.
        assert!((at_year(1850.0) - 9.3389).abs() < 0.01 && (at_year(1950.0) - 28.932).abs() < 0.01);
        // In 2050 as the documentation says.
        assert!((at_year(2050.0) - 75.3).abs() < 0.1, "{}", at_year(2050.0));
        // [stephenson2016]: −2.1 s around 1900, about 17,200 s in 500 BC, 7.3 to 7.6 around 1850.
        assert!((at_year(1900.0) + 2.1).abs() < 0.5, "{}", at_year(1900.0));
        assert!((at_year(-500.0) - 17_100.0).abs() < 300.0, "{}", at_year(-500.0));
    }

    #[test]
    fn continuous_everywhere() {
        let mut last = at_year(-3000.0);
        let mut year = -3000.0;
        while year < 4000.0 {
            year += 0.02;
            let now = at_year(year);
            assert!((now - last).abs() < 0.8, "{year}: {last} to {now}");
            if year > 1700.0 && year < 2100.0 {
                assert!((now - last).abs() < 0.07, "{year}: {last} to {now}");
            }
            last = now;
        }
    }
}
