//! Sixteen wavelengths and what each adds to colour.

use glam::DVec3;
use himmel_core::colour::Observer;
use himmel_core::spectrum::Spectrum;

/// Wavelengths that a reference picture carries.
pub const WAVELENGTHS: usize = 16;

/// They stand in the middles of sixteen equal parts of this band, nm.
const BAND_NM: [f64; 2] = [390.0, 730.0];

/// The wavelengths: 400.625, 421.875 … 719.375 nm.
pub fn wavelengths_nm() -> [f64; WAVELENGTHS] {
    let step_nm = (BAND_NM[1] - BAND_NM[0]) / WAVELENGTHS as f64;
    std::array::from_fn(|k| BAND_NM[0] + step_nm * (k as f64 + 0.5))
}

/// What each wavelength adds to XYZ under a light.
///
/// XYZ = 683 lm/W · ∫ r(λ) E(λ) (x̄, ȳ, z̄) dλ, where r, the radiance per unit irradiance, is smooth and the light E is not: r is
/// interpolated by cubics through the four nearest wavelengths (and held beyond the ends), so that XYZ = Σ r_k w_k with
/// w_k = 683 lm/W · ∫ b_k(λ) E(λ) (x̄, ȳ, z̄) dλ on the observer's own grid of 5 nm. (Tried: Gauss–Legendre nodes with one
/// polynomial, straight lines between nodes, plain sums at the nodes; on low beams and twilights they err by 0.6 to 14 % of X, Y or Z where this errs by 0.1 to 0.3 %.)
///
/// `light_w_m2_nm`: spectral irradiance above the air. The answer's Y is cd m⁻² for r in sr⁻¹, lx for transmittances.
/// Laws tested: exact for an even spectrum; X, Y and Z within 0.3 % (of the largest of them) of 5 nm sums for skies and beams
/// down to the horizon of the Earth, Mars and a planet of an M dwarf; within 1 % under Titan's methane bands.
pub fn xyz_weights(light_w_m2_nm: &Spectrum) -> [DVec3; WAVELENGTHS] {
    let nodes = wavelengths_nm();
    std::array::from_fn(|k| {
        Observer::cie1931().xyz_of(|wavelength_nm| light_w_m2_nm.at(wavelength_nm) * basis(&nodes, k, wavelength_nm))
    })
}

/// The cubic that is 1 at node `k` and 0 at the others of the four nearest; 0 where `k` is none of these.
fn basis(nodes: &[f64; WAVELENGTHS], k: usize, wavelength_nm: f64) -> f64 {
    let x = wavelength_nm.clamp(nodes[0], nodes[WAVELENGTHS - 1]);
    let above = nodes.iter().filter(|node| **node < x).count();
    let first = above.saturating_sub(2).min(WAVELENGTHS - 4);
    if !(first..first + 4).contains(&k) {
        return 0.0;
    }
    (first..first + 4).filter(|m| *m != k).map(|m| (x - nodes[m]) / (nodes[k] - nodes[m])).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use himmel_air::{AirParams, Columns, GroundParams, Preset};

    /// Sixteen wavelengths against the observer's 5 nm sums, for spectra of skies and beams of the Earth and Mars under the
    /// Sun and under an M dwarf.
    #[test]
    fn sixteen_wavelengths_hold_every_sky() {
        for name in ["earth", "mars", "m-dwarf-ocean", "titan"] {
            let preset = Preset::named(name).unwrap();
            let atmosphere = himmel_air::Atmosphere::new(&preset, &AirParams::default(), &GroundParams::default());
            let medium = atmosphere.medium();
            let columns = Columns::new(medium);
            let light = preset.light_at_1_au_w_m2_nm();
            let weights = xyz_weights(&light);
            // Titan's haze has an optical depth of 60 towards the horizon: nobody sees that Sun.
            let low_sun = if name == "titan" { 0.5 } else { 0.0 };
            let spectra: [(&str, &dyn Fn(f64) -> f64); 5] = [
                ("even", &|_| 1.0),
                ("λ⁻⁴", &|nm| (nm / 550.0).powi(-4)),
                ("high beam", &|nm| (-columns.optical_depth(&medium.sampled(&[nm]), 0.0, 0.7)[0]).exp()),
                ("low beam", &|nm| (-columns.optical_depth(&medium.sampled(&[nm]), 0.0, low_sun)[0]).exp()),
                ("sky opposite to a low Sun", &|nm| {
                    let ray = himmel_air::single::Ray { altitude_m: 0.0, mu: 0.1, mu_s: low_sun, nu: -0.9 };
                    himmel_air::single::march(&medium.sampled(&[nm]), &columns, &ray, 32).radiance_per_sr[0]
                }),
            ];
            for (what, spectrum) in spectra {
                let fine = Observer::cie1931().xyz_of(|nm| light.at(nm) * spectrum(nm));
                let nodes = wavelengths_nm();
                let ours: DVec3 = (0..WAVELENGTHS).map(|k| weights[k] * spectrum(nodes[k])).sum();
                // By the largest of X, Y, Z: nobody sees that a deep red beam's Z of 1e-9 is 2e-9.
                let error = (ours - fine).abs().max_element() / fine.max_element();
                println!("{name}, {what}: {:.3} %", 100.0 * error);
                // Titan's methane has bands that are narrower than the steps.
                let bound = if what == "even" {
                    1e-12
                } else if name == "titan" {
                    1e-2
                } else {
                    3e-3
                };
                assert!(error < bound, "{name}, {what}: {error}");
            }
        }
    }
}
