//! The medium as a renderer's tables need it: what scatters by altitude, and the aerosols' peaks by angle and depth.

use std::f64::consts::PI;

use crate::medium::Sampled;
use crate::profile::Profile;

use super::Quality;
use super::optics::{Optics, Scatterer};
use super::peak::Peaks;

/// All components that share a profile: their coefficients where the profile is 1, m⁻¹, at four wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// How it is spread over altitude.
    pub profile: Profile,
    /// Extinction σ_t.
    pub extinction_per_m: [f64; 4],
    /// Scattering into the aerosols' forward peaks, f σ_M.
    pub peak_per_m: [f64; 4],
    /// The scaled medium's Σσ_s′, Σσ_s′χ₁′, Σσ_s′χ₂′. Adding `peak_per_m` to each gives the unscaled sums.
    pub scaled_per_m: [[f64; 4]; 3],
    /// Molecules alone: σ_R and σ_R χ₂.
    pub molecules_per_m: [[f64; 4]; 2],
}

/// An aerosol as the march needs it beside [`Species`].
#[derive(Clone, Debug, PartialEq)]
pub struct Aerosol {
    /// Index of its species.
    pub species: usize,
    /// Scattering σ_M where the profile is 1, m⁻¹.
    pub scattering_per_m: [f64; 4],
    /// (1 − f) σ_M p′ as a polynomial: (1 − f) σ_M (1, χ₁′, χ₂′), m⁻¹.
    pub smooth_per_m: [[f64; 4]; 3],
    /// Phase function over scattering angle θ = π x², x even in 0..=1, sr⁻¹.
    pub phase_per_sr: Vec<[f64; 4]>,
    /// Corrections of the scaled (S) and the unscaled (U) form, `[angle][depth]` over the same angles, divided by
    /// (1 − e^(−τ)): see `peak.rs`. Depth: τ of the reference, x = √(τ/(6 + τ)); a wavelength's own is
    /// [`Prepared::peak_ratio`] times that.
    pub corrections_per_sr: [Vec<[f64; 4]>; 2],
}

/// A medium at four wavelengths, prepared.
///
/// The depth of the forward peaks along a path is carried as one number, a reference; each wavelength has its share of
/// it. That is exact for one aerosol, for several their mean by vertical column (as the peak's shape is, too).
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// One for each profile.
    pub species: Vec<Species>,
    /// One for each scattering component with a peak.
    pub aerosols: Vec<Aerosol>,
    /// Mean phase function of the aerosols by vertical column, over the same angles, sr⁻¹: the shape that tables divide
    /// peaks by. Even (1/4π) without aerosols.
    pub mean_phase_per_sr: Vec<[f64; 4]>,
    /// Depth of the peaks at each wavelength relative to the reference; the largest is 1. All 0 without aerosols.
    pub peak_ratio: [f64; 4],
    /// Of each species: scattering into peaks at the reference, m⁻¹ where the profile is 1.
    pub peak_reference_per_m: Vec<f64>,
    /// Angles of the tables.
    pub angles: usize,
    /// Depths of the tables.
    pub depths: usize,
}

impl Prepared {
    /// Sums the series of the peaks; some tens of milliseconds with aerosols, nothing without.
    pub fn new(air: &Sampled<'_, 4>, quality: &Quality) -> Self {
        let quality = quality.sane();
        let (angles, depths) = (quality.peak_angles, quality.peak_depths);
        let medium = air.medium;
        let optics = Optics::new(air, quality.legendre_terms);
        let mut peak_column = [0.0; 4];
        for (component, s) in medium.components.iter().zip(&optics.scatterers) {
            let column_m = component.profile.column_m(0.0, medium.top_altitude_m);
            for k in 0..4 {
                peak_column[k] += column_m * s.peak_per_m[k];
            }
        }
        let largest = peak_column.iter().copied().fold(0.0, f64::max);
        let peak_ratio = if largest > 0.0 { peak_column.map(|peak| peak / largest) } else { [0.0; 4] };
        let mut species: Vec<Species> = Vec::new();
        let mut aerosols = Vec::new();
        let peaks = Peaks::with_ratio(&medium.components, &optics, medium.top_altitude_m, angles, depths, peak_ratio);
        for (index, (component, s)) in medium.components.iter().zip(&optics.scatterers).enumerate() {
            let known = species.iter().position(|known| known.profile == component.profile);
            let at = known.unwrap_or_else(|| {
                species.push(Species::nothing(component.profile.clone()));
                species.len() - 1
            });
            species[at].add(s);
            if !s.is_aerosol() || s.scattering_per_m.iter().all(|&scattering| scattering <= 0.0) {
                continue;
            }
            let Some(phase) = &component.phase else { continue };
            let phase_at = |x: usize| {
                let cosine = (PI * (x as f64 / (angles - 1) as f64).powi(2)).cos();
                air.wavelengths_nm.map(|wavelength_nm| phase.at(cosine, wavelength_nm))
            };
            let smoothed: [f64; 4] = std::array::from_fn(|k| s.scattering_per_m[k] - s.peak_per_m[k]);
            aerosols.push(Aerosol {
                species: at,
                scattering_per_m: s.scattering_per_m,
                smooth_per_m: [
                    smoothed,
                    std::array::from_fn(|k| smoothed[k] * s.scaled_chi[0][k]),
                    std::array::from_fn(|k| smoothed[k] * s.scaled_chi[1][k]),
                ],
                phase_per_sr: (0..angles).map(phase_at).collect(),
                corrections_per_sr: peaks.nodes(index),
            });
        }
        let column = |aerosol: &Aerosol, k: usize| {
            let column_m = species[aerosol.species].profile.column_m(0.0, medium.top_altitude_m);
            column_m * aerosol.scattering_per_m[k]
        };
        let weights: Vec<[f64; 4]> =
            aerosols.iter().map(|aerosol| std::array::from_fn(|k| column(aerosol, k).max(0.0))).collect();
        let mean_at = |angle: usize| {
            std::array::from_fn(|k| {
                let sum: f64 = weights.iter().map(|weight| weight[k]).sum();
                let phases = aerosols.iter().zip(&weights).map(|(a, weight)| weight[k] * a.phase_per_sr[angle][k]);
                if sum > 0.0 { phases.sum::<f64>() / sum } else { 0.25 / PI }
            })
        };
        let mean_phase_per_sr = (0..angles).map(mean_at).collect();
        let squares: f64 = peak_ratio.iter().map(|ratio| ratio * ratio).sum();
        let reference = |species: &Species| {
            let projected: f64 = species.peak_per_m.iter().zip(peak_ratio).map(|(peak, ratio)| peak * ratio).sum();
            if squares > 0.0 { projected / squares } else { 0.0 }
        };
        let peak_reference_per_m = species.iter().map(reference).collect();
        Self { species, aerosols, mean_phase_per_sr, peak_ratio, peak_reference_per_m, angles, depths }
    }
}

impl Species {
    fn nothing(profile: Profile) -> Self {
        Self {
            profile,
            extinction_per_m: [0.0; 4],
            peak_per_m: [0.0; 4],
            scaled_per_m: [[0.0; 4]; 3],
            molecules_per_m: [[0.0; 4]; 2],
        }
    }

    fn add(&mut self, s: &Scatterer<4>) {
        for k in 0..4 {
            let smoothed = s.scattering_per_m[k] - s.peak_per_m[k];
            self.extinction_per_m[k] += s.extinction_per_m[k];
            self.peak_per_m[k] += s.peak_per_m[k];
            self.scaled_per_m[0][k] += smoothed;
            self.scaled_per_m[1][k] += smoothed * s.scaled_chi[0][k];
            self.scaled_per_m[2][k] += smoothed * s.scaled_chi[1][k];
            if !s.is_aerosol() {
                self.molecules_per_m[0][k] += s.scattering_per_m[k];
                self.molecules_per_m[1][k] += s.scattering_per_m[k] * s.chi[1][k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    const FOUR_NM: [f64; 4] = [630.0, 560.0, 490.0, 430.0];

    #[test]
    fn the_sums_are_those_of_the_components() {
        let medium = Preset::named("earth").unwrap().medium;
        let air = medium.sampled(&FOUR_NM);
        let prepared = Prepared::new(&air, &Quality::default());
        let optics = Optics::new(&air, Quality::default().legendre_terms);
        for h in [0.0, 500.0, 5e3, 2e4, 4e4] {
            let (extinction, local) = (air.extinction_per_m(h), optics.local(&medium.components, h));
            for k in 0..4 {
                let sum = |f: &dyn Fn(&Species) -> f64| -> f64 {
                    prepared.species.iter().map(|s| s.profile.at(h) * f(s)).sum()
                };
                assert!((sum(&|s| s.extinction_per_m[k]) / extinction[k] - 1.0).abs() < 1e-12);
                let scaled = sum(&|s| s.extinction_per_m[k] - s.peak_per_m[k]);
                assert!((scaled / local.scaled_extinction_per_m[k] - 1.0).abs() < 1e-12);
                for m in 0..3 {
                    let difference = sum(&|s| s.scaled_per_m[m][k]) - local.scaled[m][k];
                    assert!(difference.abs() < 1e-12 * local.scaled[0][k]);
                }
            }
        }
        assert_eq!(prepared.aerosols.len(), 2, "boundary layer and stratosphere");
        assert!(prepared.peak_ratio.iter().copied().fold(0.0, f64::max) == 1.0);
    }

    #[test]
    fn without_aerosols_there_are_no_peaks() {
        let mut medium = Preset::named("bruneton2017").unwrap().medium;
        medium.components.retain(|component| component.class() != crate::medium::Class::Aerosols);
        let prepared = Prepared::new(&medium.sampled(&FOUR_NM), &Quality::default());
        assert!(prepared.aerosols.is_empty() && prepared.peak_ratio == [0.0; 4]);
    }
}
