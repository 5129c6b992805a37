//! Molecular scattering of the Earth's air.

/// Rayleigh scattering cross section of dry air with 360 ppm CO₂ per molecule, m², for 250–850 nm.
///
/// σ = 1e-28 cm² · (1.0455996 − 341.29061 λ⁻² − 0.90230850 λ²) / (1 + 0.0027059889 λ⁻² − 85.968563 λ²)
/// [bodhaine1999, eq. 29], λ in µm.
///
/// Laws tested: Bodhaine's own table; falls monotonically. (Lorentz–Lorenz with King factors, for any gas: the
/// issue "The physics of air".)
pub fn air_cross_section_m2(wavelength_nm: f64) -> f64 {
    let squared = (wavelength_nm / 1000.0).powi(2);
    let numerator = 1.0455996 - 341.29061 / squared - 0.90230850 * squared;
    let denominator = 1.0 + 0.0027059889 / squared - 85.968563 * squared;
    1e-32 * numerator / denominator
}

/// γ = δ/(2 − δ) of dry air, from the depolarisation factor δ = 0.0279 at visible wavelengths, which is the King
/// factor (6 + 3δ)/(6 − 7δ) = 1.048 of 550 nm [bodhaine1999].
pub const AIR_GAMMA: f64 = 0.0279 / (2.0 - 0.0279);

#[cfg(test)]
mod tests {
    use super::*;

    /// Optical depth of standard air at sea level: 0.2426, 0.0971, 0.0410 at 440, 550, 680 nm with a column of
    /// 2.149e25 molecules/cm² [bodhaine1999]; 1 % because the quoted depths carry three digits and other rounding.
    #[test]
    fn optical_depth_of_standard_air() {
        for (wavelength_nm, published) in [(440.0, 0.2426), (550.0, 0.0971), (680.0, 0.0410)] {
            let depth = 2.149e29 * air_cross_section_m2(wavelength_nm);
            assert!((depth / published - 1.0).abs() < 0.01, "{wavelength_nm} nm: {depth}");
        }
        let king = (6.0 + 3.0 * 0.0279) / (6.0 - 7.0 * 0.0279);
        assert!((king - 1.048f64).abs() < 1e-3);
    }
}
