//! The Sun: its spectrum above the air and the brightness across its disc.

use std::sync::OnceLock;

use himmel_core::spectrum::{Spectrum, read_columns};

/// Spectral irradiance of the Sun above the air at 1 au, W m⁻² nm⁻¹, in averages over 5 nm [astmg173].
pub fn irradiance_w_m2_nm() -> &'static Spectrum {
    static SPECTRUM: OnceLock<Spectrum> = OnceLock::new();
    SPECTRUM.get_or_init(|| {
        let (wavelength_nm, value) = read_columns(include_str!("../../../assets/light/sun_astm_g173.csv"), 0, 1);
        Spectrum::Table { wavelength_nm, value }
    })
}

/// Exponent α of the Sun's limb darkening I(µ)/I(1) = µ^α.
///
/// α(λ) = −0.023 + 0.292 / λ   [hestroffer1998], λ in µm, fitted for 416–1100 nm
///
/// `wavelength_nm`: vacuum wavelength.
/// Laws tested: the mean over the disc is 2/(α + 2); blue darkens more than red.
pub fn limb_darkening_exponent(wavelength_nm: f64) -> f64 {
    -0.023 + 292.0 / wavelength_nm
}

/// Brightness of the disc relative to its mean: (α + 2)/2 · µ^α.
///
/// `radius_fraction`: distance from the disc's centre in radii, 0..=1; outside it is 0.
pub fn relative_disc_brightness(radius_fraction: f64, exponent: f64) -> f64 {
    if !(0.0..=1.0).contains(&radius_fraction) {
        return 0.0;
    }
    let mu = (1.0 - radius_fraction * radius_fraction).sqrt();
    0.5 * (exponent + 2.0) * mu.powf(exponent)
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
            let exponent = limb_darkening_exponent(wavelength_nm);
            let mean: f64 = gauss_legendre_unit(64)
                .iter()
                .map(|(x, w)| w * 2.0 * x * relative_disc_brightness(*x, exponent))
                .sum();
            assert!((mean - 1.0).abs() < 1e-4, "{mean}");
        }
        assert!(limb_darkening_exponent(430.0) > limb_darkening_exponent(680.0));
    }

    /// Centre-to-limb ratios of Pierce and Slaughter 1977 at µ = 0.5: about 0.72 at 550 nm; within 0.03, the
    /// spread of one-parameter fits.
    #[test]
    fn limb_darkening_at_half() {
        let ratio = 0.5f64.powf(limb_darkening_exponent(550.0));
        assert!((ratio - 0.72).abs() < 0.03, "{ratio}");
    }
}
