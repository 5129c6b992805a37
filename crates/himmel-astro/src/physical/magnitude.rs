use crate::body::Body;

/// What the brightness of a planet depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circumstances {
    /// From the Sun, au.
    pub sun_distance_au: f64,
    /// From the observer, au.
    pub distance_au: f64,
    /// Sun–body–observer, degrees.
    pub phase_angle_deg: f64,
    /// Latitude of the Sun above the body's equator, degrees (Saturn and Uranus).
    pub sun_latitude_deg: f64,
    /// Latitude of the observer above the body's equator, degrees (Saturn and Uranus).
    pub observer_latitude_deg: f64,
    /// Julian year (Neptune has brightened since 1980).
    pub year: f64,
}

fn polynomial(x: f64, c: &[f64]) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Visual magnitude of Sun, Moon, Earth (from elsewhere), planets.
///
/// Planets: [mallama2018, eqs. 2–17]; Mars without what its turning and seasons do (±0.1). Outside the phases that the paper covers
/// (Saturn above 6.5°, seen only from elsewhere than the Earth) the globe alone. Sun: −26.74 at 1 au. Pluto: −1.0 + 0.04 i at 1 au
/// [almanac2006]. Moon: −12.73 + 0.026 i + 4e-9 i⁴ at its mean distance [allen1973], brightened by [`moon_surge`].
pub fn planet_magnitude(body: Body, c: &Circumstances) -> f64 {
    let a = c.phase_angle_deg;
    let distances = 5.0 * (c.sun_distance_au * c.distance_au).log10();
    match body {
        Body::Sun => -26.74 + 5.0 * c.distance_au.log10(),
        Body::Moon => {
            const MEAN_DISTANCE_AU: f64 = 384_400e3 / crate::constants::AU_M;
            -12.73 + 0.026 * a + 4e-9 * a.powi(4) + distances
                - 5.0 * MEAN_DISTANCE_AU.log10()
                - 2.5 * moon_surge(a).log10()
        }
        Body::Earth => -3.99 + distances + polynomial(a, &[0.0, -1.060e-3, 2.054e-4]),
        Body::Mercury => {
            -0.613
                + distances
                + polynomial(a, &[0.0, 6.3280e-2, -1.6336e-3, 3.3644e-5, -3.4265e-7, 1.6893e-9, -3.0334e-12])
        }
        Body::Venus if a < 163.7 => {
            -4.384 + distances + polynomial(a, &[0.0, -1.044e-3, 3.687e-4, -2.814e-6, 8.938e-9])
        }
        Body::Venus => distances + polynomial(a, &[236.058_28, -2.819_14, 8.390_34e-3]),
        Body::Mars if a <= 50.0 => -1.601 + distances + polynomial(a, &[0.0, 2.267e-2, -1.302e-4]),
        Body::Mars => -0.367 + distances + polynomial(a, &[0.0, -0.025_73, 0.000_344_5]),
        Body::Jupiter if a <= 12.0 => -9.395 + distances + polynomial(a, &[0.0, -3.7e-4, 6.16e-4]),
        Body::Jupiter => {
            let light = polynomial(a / 180.0, &[1.0, -1.507, -0.363, -0.062, 2.809, -1.876]);
            -9.428 + distances - 2.5 * light.max(1e-6).log10()
        }
        Body::Saturn if a <= 6.5 => {
            let product = c.sun_latitude_deg * c.observer_latitude_deg;
            let tilt = product.max(0.0).sqrt().min(27.0).to_radians().sin();
            -8.914 + distances - 1.825 * tilt + 0.026 * a - 0.378 * tilt * (-2.25 * a).exp()
        }
        Body::Saturn => -8.94 + distances + polynomial(a, &[0.0, 2.446e-4, 2.672e-4, -1.505e-6, 4.767e-9]),
        Body::Uranus => {
            let latitude = 0.5 * (c.sun_latitude_deg.abs() + c.observer_latitude_deg.abs());
            let phase = if a > 3.1 { polynomial(a, &[0.0, 6.587e-3, 1.045e-4]) } else { 0.0 };
            -7.110 + distances - 0.000_84 * latitude + phase
        }
        Body::Neptune => {
            let base = (-6.89 - 0.0054 * (c.year - 1980.0)).clamp(-7.00, -6.89);
            let phase = if a > 1.9 { polynomial(a, &[0.0, 7.944e-3, 9.617e-5]) } else { 0.0 };
            base + distances + phase
        }
        Body::Pluto => -1.0 + distances + 0.04 * a,
    }
}

/// How much brighter the Moon is near full than the smooth law: shadows hide behind the grains that cast them.
///
/// S = 1 + 0.35 max(0, 1 − i/7°)   [krisciunas1991]; `phase_angle_deg` = i
///
/// Laws tested: S(0) = 1.35; continuous; 1 beyond 7°.
pub fn moon_surge(phase_angle_deg: f64) -> f64 {
    1.0 + 0.35 * (1.0 - phase_angle_deg.abs() / 7.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws() {
        assert_eq!(moon_surge(0.0), 1.35);
        assert!((moon_surge(7.0) - 1.0).abs() < 1e-12 && moon_surge(90.0) == 1.0);
    }

    /// Both branches of a planet meet: 0.02 mag, which is what the paper's own formulae leave (Mars 0.07).
    #[test]
    fn branches_meet() {
        for (body, at, tolerance) in [(Body::Venus, 163.7, 0.02), (Body::Mars, 50.0, 0.07), (Body::Jupiter, 12.0, 0.02)]
        {
            let m = |a: f64| {
                planet_magnitude(
                    body,
                    &Circumstances {
                        sun_distance_au: 1.0,
                        distance_au: 1.0,
                        phase_angle_deg: a,
                        sun_latitude_deg: 0.0,
                        observer_latitude_deg: 0.0,
                        year: 2000.0,
                    },
                )
            };
            assert!((m(at - 1e-9) - m(at + 1e-9)).abs() < tolerance, "{body}: {} {}", m(at - 1e-9), m(at + 1e-9));
        }
    }
}
