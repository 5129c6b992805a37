//! The Sun: its spectrum above the air and the brightness across its disc.

use std::sync::OnceLock;

use himmel_core::interpolate;
use himmel_core::spectrum::{Spectrum, read_columns};

/// Spectral irradiance of the Sun above the air at 1 au, W m⁻² nm⁻¹, in averages over 5 nm [astmg173].
pub fn irradiance_w_m2_nm() -> &'static Spectrum {
    static SPECTRUM: OnceLock<Spectrum> = OnceLock::new();
    SPECTRUM.get_or_init(|| {
        let (wavelength_nm, value) = read_columns(include_str!("../../../assets/light/sun_astm_g173.csv"), 0, 1);
        Spectrum::Table { wavelength_nm, value }
    })
}

/// Coefficients of the Sun's limb darkening at a wavelength: I(µ) / mean = Σ c_k µ^k, k = 0..5   [neckel1994]
///
/// I(µ)/I(1) = Σ a_k µ^k as tabulated between 303 and 1099 nm, interpolated and divided by its mean over the disc,
/// Σ 2 a_k / (k + 2); µ is the cosine of the angle to the surface's normal.
///
/// `wavelength_nm`: vacuum wavelength, clamped to the table.
/// Laws tested: the mean over the disc is 1; blue darkens more than red; the table's own means.
pub fn limb_darkening(wavelength_nm: f64) -> [f64; 6] {
    static TABLE: OnceLock<[(Vec<f64>, Vec<f64>); 6]> = OnceLock::new();
    let csv = include_str!("../../../assets/light/sun_limb_darkening.csv");
    let table = TABLE.get_or_init(|| [1, 2, 3, 4, 5, 6].map(|column| read_columns(csv, 0, column)));
    let a: [f64; 6] = std::array::from_fn(|k| interpolate::linear(&table[k].0, &table[k].1, wavelength_nm));
    let mean: f64 = a.iter().enumerate().map(|(k, a)| 2.0 * a / (k as f64 + 2.0)).sum();
    a.map(|a| a / mean)
}

/// Brightness of the disc relative to its mean.
///
/// `radius_fraction`: distance from the disc's centre in radii, 0..=1; outside it is 0. `coefficients`: of
/// [`limb_darkening`].
pub fn relative_disc_brightness(radius_fraction: f64, coefficients: &[f64; 6]) -> f64 {
    if !(0.0..=1.0).contains(&radius_fraction) {
        return 0.0;
    }
    let mu = (1.0 - radius_fraction * radius_fraction).sqrt();
    coefficients.iter().rev().fold(0.0, |sum, c| sum * mu + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use himmel_core::colour::Observer;
    use himmel_core::quadrature::gauss_legendre_unit;

    #[test]
    fn illuminance_above_the_air() {
        let spectrum = irradiance_w_m2_nm();
        let lux = Observer::cie1931().xyz_of(|wavelength_nm| spectrum.at(wavelength_nm)).y;
        // 1.27–1.34e5 lx in the literature; ASTM G-173's spectrum gives 1.33e5 (atmosphere.md §6).
        assert!((1.325e5..1.345e5).contains(&lux), "{lux}");
    }

    #[test]
    fn limb_darkening_conserves_the_disc() {
        for wavelength_nm in [430.0, 550.0, 680.0] {
            let coefficients = limb_darkening(wavelength_nm);
            let mean: f64 = gauss_legendre_unit(64)
                .iter()
                .map(|(x, w)| w * 2.0 * x * relative_disc_brightness(*x, &coefficients))
                .sum();
            assert!((mean - 1.0).abs() < 1e-5, "{mean}");
        }
        let limb = |wavelength_nm| relative_disc_brightness(0.95, &limb_darkening(wavelength_nm));
        assert!(limb(430.0) < limb(550.0) && limb(550.0) < limb(680.0));
    }

    /// The table prints the mean over the disc relative to its centre: 0.7596 at 445.125 nm and 0.8061 at 559.95 nm.
    #[test]
    fn means_are_those_printed() {
        for (wavelength_nm, printed) in [(445.125, 0.7596), (559.950, 0.8061)] {
            let centre = relative_disc_brightness(0.0, &limb_darkening(wavelength_nm));
            assert!((1.0 / centre - printed).abs() < 1e-4, "{wavelength_nm}: {}", 1.0 / centre);
        }
    }
}
