//! Light of stars at the four wavelengths of an atmosphere.

use crate::light::planck_w_m2_sr_nm;

/// Temperature that stands for the Sun among black bodies, K: that of its B − V of 0.653 [ballesteros2012].
pub const SUN_LIKE_K: f64 = 5770.0;

/// Turns a star's temperature and illuminance into four irradiances relative to the preset's star at 1 au, as all light
/// of a frame is carried.
///
/// E_k = s B(λ_k, T) / B(λ_k, 5770 K),   s so that the luminance of the four is the illuminance
///
/// Under a preset's star that is a black body itself its own spectrum stands below. Dividing by a black body instead of
/// the Sun's table keeps the Sun's absorption lines, which stars like it have too.
/// Laws tested: the illuminance is kept; a star like the Sun has the Sun's colour; cooler is redder; colours of black
/// bodies from 3,000 to 20,000 K within ΔE2000 of 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Starlight {
    pub(crate) wavelengths_nm: [f64; 4],
    /// What the four are divided by.
    pub(crate) reference: [f64; 4],
    /// Luminance of a unit at each wavelength.
    pub(crate) luminance: [f64; 4],
}

impl Starlight {
    /// The four wavelengths, nm.
    pub fn wavelengths_nm(&self) -> [f64; 4] {
        self.wavelengths_nm
    }

    /// A black body's light of an illuminance.
    ///
    /// `temperature_k`: 0 or what is no number is taken as a star like the Sun.
    pub fn of_black_body(&self, temperature_k: f64, illuminance_lx: f64) -> [f64; 4] {
        let known = temperature_k.is_finite() && temperature_k > 0.0;
        let temperature_k = if known { temperature_k.clamp(1000.0, 1e6) } else { SUN_LIKE_K };
        self.scaled(
            std::array::from_fn(|k| planck_w_m2_sr_nm(self.wavelengths_nm[k], temperature_k) / self.reference[k]),
            illuminance_lx,
        )
    }

    /// Light of the preset's star that something reflects, of an illuminance. `excess`: B − V above that of the star.
    ///
    /// The reflectance rises as 10^(0.4 excess (λ − 440 nm)/110 nm), B at 440 and V at 550 nm, and stays above 620 nm.
    pub fn reflected(&self, excess: f64, illuminance_lx: f64) -> [f64; 4] {
        self.scaled(
            self.wavelengths_nm.map(|nm| 10f64.powf(0.4 * excess * (nm.min(620.0) - 440.0) / 110.0)),
            illuminance_lx,
        )
    }

    fn scaled(&self, shape: [f64; 4], illuminance_lx: f64) -> [f64; 4] {
        let sum: f64 = (0..4).map(|k| self.luminance[k] * shape[k]).sum();
        let scale = if sum > 0.0 { illuminance_lx / sum } else { 0.0 };
        shape.map(|value| value * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AirParams, Atmosphere, GroundParams, Preset};
    use glam::DVec3;
    use himmel_core::colour::{Observer, delta_e_2000, lab_from_xyz, rec709_from_xyz};

    fn earth() -> Atmosphere {
        Atmosphere::new(&Preset::named("earth").unwrap(), &AirParams::default(), &GroundParams::default())
    }

    #[test]
    fn illuminance_is_kept_and_the_sun_is_the_sun() {
        let air = earth();
        for temperature_k in [0.0, 2500.0, 5770.0, 30_000.0] {
            let four = air.starlight().of_black_body(temperature_k, 2.54e-6);
            assert!((air.xyz(four).y / 2.54e-6 - 1.0).abs() < 1e-12);
        }
        let sun = air.starlight().of_black_body(SUN_LIKE_K, 1.0);
        assert!(sun.iter().all(|value| (value / sun[0] - 1.0).abs() < 1e-12), "{sun:?}");
        let red = air.starlight().reflected(0.7, 1.0);
        assert!(red[0] > red[1] && red[1] > red[2] && red[2] > red[3]);
    }

    /// Against the full spectrum of each black body. The matrix is fitted to skies and beams of sunlight, so cool stars
    /// are its extremes.
    #[test]
    fn black_bodies_have_their_colour() {
        let air = earth();
        let white = DVec3::new(0.95047, 1.0, 1.08883) * 100.0;
        for temperature_k in [3000.0, 3800.0, 5000.0, 7500.0, 10_000.0, 20_000.0] {
            let full = Observer::cie1931().xyz_of(|nm| planck_w_m2_sr_nm(nm, temperature_k));
            let ours = air.xyz(air.starlight().of_black_body(temperature_k, 50.0));
            let difference = delta_e_2000(lab_from_xyz(full * (50.0 / full.y), white), lab_from_xyz(ours, white));
            let rgb = rec709_from_xyz() * ours;
            println!("{temperature_k} K: ΔE2000 {difference:.2}, {rgb:.1}");
            assert!(difference < 3.0, "{temperature_k}: {difference}");
        }
    }
}
