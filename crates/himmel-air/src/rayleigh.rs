//! Molecular scattering: from a gas's refractive index to its cross section.

use std::f64::consts::PI;

use himmel_core::constants::BOLTZMANN_J_K;
use himmel_core::spectrum::Spectrum;

use crate::phase::Phase;

/// Rayleigh scattering cross section of dry air with 360 ppm CO₂ per molecule, m², for 250–850 nm.
///
/// σ = 1e-28 cm² · (1.0455996 − 341.29061 λ⁻² − 0.90230850 λ²) / (1 + 0.0027059889 λ⁻² − 85.968563 λ²)
/// [bodhaine1999, eq. 29], λ in µm: a fit to what [`Gas::cross_section_m2`] computes from its sources.
///
/// Laws tested: Bodhaine's own table; falls monotonically; within 0.3 % of Lorentz–Lorenz and King.
pub fn air_cross_section_m2(wavelength_nm: f64) -> f64 {
    let squared = (wavelength_nm / 1000.0).powi(2);
    let numerator = 1.0455996 - 341.29061 / squared - 0.90230850 * squared;
    let denominator = 1.0 + 0.0027059889 / squared - 85.968563 * squared;
    1e-32 * numerator / denominator
}

/// γ = δ/(2 − δ) of dry air, from the depolarisation factor δ = 0.0279 at visible wavelengths, which is the King
/// factor (6 + 3δ)/(6 − 7δ) = 1.048 of 550 nm [bodhaine1999].
pub const AIR_GAMMA: f64 = 0.0279 / (2.0 - 0.0279);

/// Molecules in a cubic metre at 288.15 K and 1013.25 hPa: p/(kT), where the formulas for n hold.
pub fn standard_density_per_m3() -> f64 {
    number_density_per_m3(101_325.0, 288.15)
}

/// Particles in a cubic metre of an ideal gas, p/(kT).
pub fn number_density_per_m3(pressure_pa: f64, temperature_k: f64) -> f64 {
    pressure_pa / (BOLTZMANN_J_K * temperature_k)
}

/// Height over which the density of an isothermal gas falls to 1/e, kT/(mg), in metres.
///
/// `molar_mass_g_mol`: grams per mole; `gravity_m_s2`: at the ground.
pub fn scale_height_m(temperature_k: f64, molar_mass_g_mol: f64, gravity_m_s2: f64) -> f64 {
    /// The molar gas constant, J/(mol K), exact by definition [si2019].
    const GAS_CONSTANT: f64 = 8.314_462_618_153_24;
    GAS_CONSTANT * temperature_k / (molar_mass_g_mol * 1e-3 * gravity_m_s2)
}

/// Polarisability by Lorentz and Lorenz: α = 3/(4πN) (n² − 1)/(n² + 2), m³   [klupiec2024, eq. 16].
///
/// `index`: refractive index at `density_per_m3` molecules per m³.
pub fn polarisability_m3(index: f64, density_per_m3: f64) -> f64 {
    let squared = index * index;
    3.0 / (4.0 * PI * density_per_m3) * (squared - 1.0) / (squared + 2.0)
}

/// Cross section of a molecule: 128/3 π⁵ λ⁻⁴ α² F, m²   [klupiec2024, eq. 17], with King's factor F.
pub fn cross_section_m2(wavelength_nm: f64, polarisability_m3: f64, king_factor: f64) -> f64 {
    128.0 / 3.0 * PI.powi(5) * (wavelength_nm * 1e-9).powi(-4) * polarisability_m3.powi(2) * king_factor
}

/// A gas whose refractive index and King factor are known in the visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gas {
    /// Dry air.
    Air,
    /// Nitrogen.
    Nitrogen,
    /// Carbon dioxide.
    CarbonDioxide,
    /// Methane.
    Methane,
}

impl Gas {
    /// n − 1 at 288.15 K and 1013.25 hPa. σ is the wavenumber, µm⁻¹ or (with a tilde) cm⁻¹.
    ///
    /// Air: 1e8 (n−1) = 8060.51 + 2480990/(132.274 − σ²) + 17455.7/(39.32957 − σ²) [peck1972], times
    /// 1 + 0.54 (360 − 300)e-6 for its CO₂ [bodhaine1999, eq. 19].
    /// N₂: 1e8 (n−1) = 6498.2 + 307.43305e12/(14.4e9 − σ̃²) below 21360 cm⁻¹, 5677.465 + 318.81874e12/(14.4e9 − σ̃²)
    /// above; CO₂: five resonances [sneep2005]. CH₄: 42.6e-5 (1 + 0.01441 σ²) at 273.15 K [allen1973, §36], because the form
    /// usually quoted from the former source is 13 % above what methane's polarisability of 2.6e-30 m³ allows.
    pub fn refractivity(self, wavelength_nm: f64) -> f64 {
        let micron = 1e6 / (wavelength_nm * wavelength_nm);
        let per_cm = 1e14 / (wavelength_nm * wavelength_nm);
        match self {
            Self::Air => {
                let n = 8060.51 + 2_480_990.0 / (132.274 - micron) + 17_455.7 / (39.32957 - micron);
                n * 1e-8 * (1.0 + 0.54 * 60e-6)
            }
            Self::Nitrogen if per_cm < 21360.0 * 21360.0 => (6498.2 + 307.43305e12 / (14.4e9 - per_cm)) * 1e-8,
            Self::Nitrogen => (5677.465 + 318.81874e12 / (14.4e9 - per_cm)) * 1e-8,
            Self::CarbonDioxide => {
                let resonances = [
                    (5799.25, 128_908.9),
                    (120.05, 89_223.8),
                    (5.3334, 75_037.5),
                    (4.3244, 67_837.7),
                    (0.1218145e-4, 2418.136),
                ];
                1.1427e3 * resonances.iter().map(|(a, b): &(f64, f64)| a / (b * b - per_cm)).sum::<f64>()
            }
            Self::Methane => 42.6e-5 * (1.0 + 0.01441 * micron) * 273.15 / 288.15,
        }
    }

    /// King's factor: how much more a gas scatters because its molecules are not round.
    ///
    /// N₂ 1.034 + 3.17e-4 σ², O₂ 1.096 + 1.385e-3 σ² + 1.448e-4 σ⁴, Ar 1, CO₂ 1.15, weighted by parts in dry air
    /// [bodhaine1999, eq. 5–6, 23]; CO₂ alone 1.1364 + 2.53e-3 σ², CH₄ 1 [sneep2005].
    pub fn king_factor(self, wavelength_nm: f64) -> f64 {
        let s = 1e6 / (wavelength_nm * wavelength_nm);
        let nitrogen = 1.034 + 3.17e-4 * s;
        match self {
            Self::Air => {
                let oxygen = 1.096 + 1.385e-3 * s + 1.448e-4 * s * s;
                (78.084 * nitrogen + 20.946 * oxygen + 0.934 + 0.036 * 1.15) / (78.084 + 20.946 + 0.934 + 0.036)
            }
            Self::Nitrogen => nitrogen,
            Self::CarbonDioxide => 1.1364 + 2.53e-3 * s,
            Self::Methane => 1.0,
        }
    }

    /// Rayleigh cross section of a molecule by Lorentz–Lorenz and King, m².
    pub fn cross_section_m2(self, wavelength_nm: f64) -> f64 {
        let alpha = polarisability_m3(1.0 + self.refractivity(wavelength_nm), standard_density_per_m3());
        cross_section_m2(wavelength_nm, alpha, self.king_factor(wavelength_nm))
    }

    /// n − 1 at a density, m⁻³: Lorentz–Lorenz keeps (n² − 1)/(n² + 2) proportional to it.
    pub fn refractivity_at(self, wavelength_nm: f64, density_per_m3: f64) -> f64 {
        let n = 1.0 + self.refractivity(wavelength_nm);
        let l = (n * n - 1.0) / (n * n + 2.0) * density_per_m3 / standard_density_per_m3();
        // n² = (1 + 2l)/(1 − l); beyond l = 1 the law has no gas left to speak of.
        let squared_minus_one = 3.0 * l / (1.0 - l.min(0.9));
        squared_minus_one / (1.0 + (1.0 + squared_minus_one).sqrt())
    }

    /// Its phase function: δ from King's factor at 550 nm, F = (6 + 3δ)/(6 − 7δ).
    pub fn phase(self) -> Phase {
        if self == Self::Air {
            return Phase::Rayleigh { gamma: AIR_GAMMA };
        }
        let king = self.king_factor(550.0);
        let delta = 6.0 * (king - 1.0) / (3.0 + 7.0 * king);
        Phase::Rayleigh { gamma: delta / (2.0 - delta) }
    }

    /// A function of the wavelength as a table every 10 nm from 250 to 900 nm.
    pub fn table(f: impl Fn(f64) -> f64) -> Spectrum {
        let wavelength_nm: Vec<f64> = (25..=90).map(|i| f64::from(i) * 10.0).collect();
        let value = wavelength_nm.iter().map(|&nm| f(nm)).collect();
        Spectrum::Table { wavelength_nm, value }
    }
}

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
            let computed = 2.149e29 * Gas::Air.cross_section_m2(wavelength_nm);
            println!(
                "{wavelength_nm} nm: fit {depth:.5}, Lorentz–Lorenz and King {computed:.5}, published {published}"
            );
            assert!((computed / published - 1.0).abs() < 0.01, "{wavelength_nm} nm: {computed}");
        }
        let king = (6.0 + 3.0 * 0.0279) / (6.0 - 7.0 * 0.0279);
        assert!((king - 1.048f64).abs() < 1e-3 && (Gas::Air.king_factor(550.0) - 1.048).abs() < 1e-3);
    }

    #[test]
    fn the_fit_is_what_lorentz_lorenz_says() {
        let mut before = f64::INFINITY;
        for i in 0..=50 {
            let nm = 350.0 + 10.0 * f64::from(i);
            let computed = Gas::Air.cross_section_m2(nm);
            assert!((computed / air_cross_section_m2(nm) - 1.0).abs() < 3e-3, "{nm}");
            assert!(computed < before);
            before = computed;
        }
    }

    /// n − 1 at 589.3 nm and 273.15 K: N₂ 2.98e-4, CO₂ 4.49e-4, CH₄ 4.44e-4 [kayelaby1995, §2.5.7]; 0.5 %: three digits.
    #[test]
    fn other_gases_bend_as_measured() {
        for (gas, published) in [(Gas::Nitrogen, 2.98e-4), (Gas::CarbonDioxide, 4.49e-4), (Gas::Methane, 4.44e-4)] {
            let ours = gas.refractivity(589.3) * 288.15 / 273.15;
            assert!((ours / published - 1.0).abs() < 5e-3, "{gas:?}: {ours:e}");
        }
    }

    /// Standard air: 2.5469e25 m⁻³; kT/(mg) of 288.15 K, 28.964 g/mol, 9.80665 m/s²: 8434.5 m.
    #[test]
    fn measured_quantities_become_densities_and_heights() {
        assert!((standard_density_per_m3() / 2.546_9e25 - 1.0).abs() < 1e-4);
        assert!((scale_height_m(288.15, 28.9644, 9.80665) - 8434.5).abs() < 0.5);
        let standard = Gas::Air.refractivity(550.0);
        assert!((Gas::Air.refractivity_at(550.0, standard_density_per_m3()) / standard - 1.0).abs() < 1e-12);
        assert!((Gas::Air.refractivity_at(550.0, 0.5 * standard_density_per_m3()) / standard - 0.5).abs() < 1e-4);
    }
}
