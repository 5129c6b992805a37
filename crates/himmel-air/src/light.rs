//! Light above the air: the Sun, black bodies at any temperature, several stars.

use std::f64::consts::PI;

use himmel_core::constants::{ASTRONOMICAL_UNIT_M, BOLTZMANN_J_K, PLANCK_J_S, SPEED_OF_LIGHT_M_S, SUN_RADIUS_M};
use himmel_core::spectrum::Spectrum;

use crate::sun;

/// Spectral radiance of a black body, W m⁻² sr⁻¹ nm⁻¹: 2hc²/λ⁵ / (exp(hc/(λkT)) − 1)   [planck1901; klupiec2024, eq. 12]
///
/// Laws tested: ∫ over wavelength = σT⁴/π; peaks at 2.898e-3 m K / T.
pub fn planck_w_m2_sr_nm(wavelength_nm: f64, temperature_k: f64) -> f64 {
    let wavelength_m = wavelength_nm * 1e-9;
    let x = PLANCK_J_S * SPEED_OF_LIGHT_M_S / (wavelength_m * BOLTZMANN_J_K * temperature_k);
    2.0 * PLANCK_J_S * SPEED_OF_LIGHT_M_S.powi(2) / wavelength_m.powi(5) / x.exp_m1() * 1e-9
}

/// What a star's surface shines like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The Sun's measured spectrum.
    Sun,
    /// A black body.
    BlackBody {
        /// Its temperature, K.
        temperature_k: f64,
    },
}

/// A star that lights the planet.
#[derive(Clone, Debug, PartialEq)]
pub struct Star {
    /// What it is called.
    pub name: String,
    /// Its spectrum.
    pub surface: Surface,
    /// Radius in radii of the Sun.
    pub radius_suns: f64,
    /// Distance from the planet in au; `None`: from the ephemeris.
    pub distance_au: Option<f64>,
}

impl Star {
    /// The Sun as the Earth sees it.
    pub fn sun() -> Self {
        Self { name: "Sun".into(), surface: Surface::Sun, radius_suns: 1.0, distance_au: None }
    }

    /// Spectral irradiance at one astronomical unit, W m⁻² nm⁻¹, every 5 nm from 300 to 1000 nm; a distance d in au
    /// divides it by d².
    pub fn irradiance_at_1_au_w_m2_nm(&self) -> Spectrum {
        let area = (self.radius_suns * SUN_RADIUS_M / ASTRONOMICAL_UNIT_M).powi(2);
        let at = |nm: f64| match self.surface {
            Surface::Sun => sun::irradiance_w_m2_nm().at(nm) * self.radius_suns.powi(2),
            Surface::BlackBody { temperature_k } => PI * area * planck_w_m2_sr_nm(nm, temperature_k),
        };
        let wavelength_nm: Vec<f64> = (0..=140).map(|i| 300.0 + 5.0 * f64::from(i)).collect();
        let value = wavelength_nm.iter().map(|&nm| at(nm)).collect();
        Spectrum::Table { wavelength_nm, value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use himmel_core::colour::Observer;

    /// Stefan and Boltzmann: σT⁴/π with σ = 5.670374e-8 [si2019]; Wien: 2.897772e-3 m K.
    #[test]
    fn a_black_body_obeys_stefan_boltzmann_and_wien() {
        for temperature_k in [3000.0, 5772.0, 10_000.0] {
            let (mut sum, mut peak, mut nm) = (0.0, (0.0, 0.0), 20.0f64);
            while nm < 2e6 {
                let step = nm * 1e-3;
                let value = planck_w_m2_sr_nm(nm + 0.5 * step, temperature_k);
                sum += value * step;
                if value > peak.1 {
                    peak = (nm + 0.5 * step, value);
                }
                nm += step;
            }
            assert!((sum * PI / (5.670374e-8 * temperature_k.powi(4)) - 1.0).abs() < 1e-5);
            assert!((peak.0 * 1e-9 * temperature_k / 2.897772e-3 - 1.0).abs() < 2e-3);
        }
        assert_eq!(planck_w_m2_sr_nm(400.0, 1.0), 0.0);
    }

    /// A black body of the Sun's effective temperature has its illuminance within 8 %: the Sun lacks ultraviolet and
    /// shines the more in the visible.
    #[test]
    fn a_black_body_like_the_sun_is_about_as_bright() {
        let star = Star { surface: Surface::BlackBody { temperature_k: 5772.0 }, ..Star::sun() };
        let lux = |star: &Star| {
            let light = star.irradiance_at_1_au_w_m2_nm();
            Observer::cie1931().xyz_of(|nm| light.at(nm)).y
        };
        assert!((lux(&star) / lux(&Star::sun()) - 1.0).abs() < 0.08, "{}", lux(&star));
    }
}
