//! Aerosols: spheres of many sizes, by exact Lorenz–Mie, and by the harmonic mean of thesis B beside it.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::error::AirError;
use crate::mie::{Index, Mie, SIZE_PARAMETERS};

/// A log-normal mode: n(r) dr = n / (√(2π) ln S) exp(−½ (ln(r/r_g) / ln S)²) d ln r   [klupiec2024, eq. 19, with
/// ln S for its S].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Median radius r_g, µm.
    pub median_radius_um: f64,
    /// Geometric standard deviation S, ≥ 1; 1 is a single size.
    pub geometric_deviation: f64,
    /// Particles per cm³ (only its share among the modes matters for means).
    pub number_per_cm3: f64,
}

impl Mode {
    /// Checks r_g in 1e-5..=1e4 µm, S in 1..=10, n positive and finite.
    pub fn new(median_radius_um: f64, geometric_deviation: f64, number_per_cm3: f64) -> Result<Self, AirError> {
        let wrong = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
        if !(1e-5..=1e4).contains(&median_radius_um) {
            return wrong("median radius", "lie in 1e-5..=1e4 µm", median_radius_um);
        }
        if !(1.0..=10.0).contains(&geometric_deviation) {
            return wrong(
                "geometric standard deviation",
                "lie in 1..=10 (its logarithm stands in the exponent)",
                geometric_deviation,
            );
        }
        if !(number_per_cm3 > 0.0 && number_per_cm3 <= 1e30) {
            return wrong("number of particles", "be positive and at most 1e30 per cm³", number_per_cm3);
        }
        Ok(Self { median_radius_um, geometric_deviation, number_per_cm3 })
    }

    /// Radii in µm and the number of particles that each stands for.
    ///
    /// The trapezoidal rule in ln r, which converges faster than any power for a bell. From −6 ln S below the median
    /// to 6 ln S above the peak of the weight r⁸ (g of small spheres), or 7.5 ln S above that of r² (large ones).
    fn nodes(&self, wavelength_nm: f64, count: usize) -> Vec<(f64, f64)> {
        let s = self.geometric_deviation.ln();
        if s < 1e-9 {
            return vec![(self.median_radius_um, self.number_per_cm3)];
        }
        let large = (3.0 * wavelength_nm / 1e3 / (2.0 * PI * self.median_radius_um)).ln();
        let (low, high) = (-6.0 * s, (8.0 * s * s + 6.0 * s).min((2.0 * s * s + 7.5 * s).max(large + 1.5)));
        let step = (high - low) / (count - 1) as f64;
        let norm = self.number_per_cm3 * step / ((2.0 * PI).sqrt() * s);
        (0..count)
            .map(|i| low + step * i as f64)
            .map(|t| (self.median_radius_um * t.exp(), norm * (-0.5 * (t / s).powi(2)).exp()))
            .collect()
    }
}

/// What a mean particle of an ensemble does.
#[derive(Clone, Debug, PartialEq)]
pub struct Optics {
    /// Extinction cross section per particle, m².
    pub extinction_m2: f64,
    /// Scattering cross section per particle, m².
    pub scattering_m2: f64,
    /// Mean cosine of the scattering angle.
    pub g: f64,
}

impl Optics {
    /// Scattering over extinction; 1 where nothing happens.
    pub fn single_scattering_albedo(&self) -> f64 {
        if self.extinction_m2 > 0.0 { (self.scattering_m2 / self.extinction_m2).clamp(0.0, 1.0) } else { 1.0 }
    }
}

fn check(modes: &[Mode], wavelength_nm: f64) -> Result<(), AirError> {
    if modes.is_empty() {
        return Err(AirError::Optics { what: "number of modes".into(), law: "be at least 1", got: 0.0 });
    }
    for mode in modes {
        Mode::new(mode.median_radius_um, mode.geometric_deviation, mode.number_per_cm3)?;
    }
    if !(1.0..=1e6).contains(&wavelength_nm) {
        return Err(AirError::Optics { what: "wavelength".into(), law: "lie in 1..=1e6 nm", got: wavelength_nm });
    }
    Ok(())
}

/// Radii per mode that leave the quadrature within 1e-8 for absorbing particles (index 1.57 − 0.02i, S = 2.15).
pub const FINE: usize = 2500;

/// The spheres of an ensemble with the share of each: number times πr² in m².
fn spheres(modes: &[Mode], index: Index, wavelength_nm: f64, nodes: usize) -> Result<(Vec<(Mie, f64)>, f64), AirError> {
    check(modes, wavelength_nm)?;
    let (mut spheres, mut number) = (Vec::new(), 0.0);
    for mode in modes {
        number += mode.number_per_cm3;
        for (radius_um, share) in mode.nodes(wavelength_nm, nodes.max(2)) {
            let x = 2.0 * PI * radius_um / (wavelength_nm / 1e3);
            // Smaller spheres than the formula knows add nothing; larger ones are an error of the caller's.
            if x < *SIZE_PARAMETERS.start() {
                continue;
            }
            spheres.push((Mie::new(x, index)?, share * PI * (radius_um * 1e-6).powi(2)));
        }
    }
    Ok((spheres, number))
}

/// Cross sections and g of a mean particle by exact Lorenz–Mie.
///
/// `nodes`: radii per mode; [`FINE`] unless speed matters.
/// Laws tested: a mode of one size is its sphere; shares add; thesis B's three modes by `miepython` (tests/truth).
pub fn lorenz_mie(modes: &[Mode], index: Index, wavelength_nm: f64, nodes: usize) -> Result<Optics, AirError> {
    let (spheres, number) = spheres(modes, index, wavelength_nm, nodes)?;
    let (mut extinction, mut scattering, mut asymmetry) = (0.0, 0.0, 0.0);
    for (mie, area) in &spheres {
        extinction += area * mie.q_ext;
        scattering += area * mie.q_sca;
        asymmetry += area * mie.q_sca * mie.g;
    }
    let g = if scattering > 0.0 { asymmetry / scattering } else { 0.0 };
    Ok(Optics { extinction_m2: extinction / number, scattering_m2: scattering / number, g })
}

/// The phase function of a mean particle at cosines of the scattering angle, sr⁻¹.
pub fn phase_function(
    modes: &[Mode],
    index: Index,
    wavelength_nm: f64,
    nodes: usize,
    cosines: &[f64],
) -> Result<Vec<f64>, AirError> {
    let (spheres, _) = spheres(modes, index, wavelength_nm, nodes)?;
    let (mut sum, mut scattering) = (vec![0.0; cosines.len()], 0.0);
    let largest = spheres.iter().map(|(mie, area)| area * mie.q_sca).fold(0.0, f64::max);
    for (mie, area) in &spheres {
        let share = area * mie.q_sca;
        // A millionth of the largest share changes no digit that a phase function is used with.
        if share < 1e-6 * largest {
            continue;
        }
        scattering += share;
        for (sum, &cosine) in sum.iter_mut().zip(cosines) {
            *sum += share * mie.phase(cosine);
        }
    }
    Ok(sum.into_iter().map(|p| if scattering > 0.0 { p / scattering } else { 0.25 / PI }).collect())
}

/// Extinction of one sphere by thesis B: half the harmonic mean of a small sphere's and a large sphere's, m².
///
/// σ_R = 128π⁵r⁶/(3λ⁴) Re(((m²−1)/(m²+2))²) − 8π²r³/λ Im((m²−1)/(m²+2)),  σ_G = 2πr² (1 + (2πr/λ)^(−2/3)),
/// σ = σ_R σ_G / (σ_R + σ_G)   [klupiec2024, eq. 20–22], m = n − ik.
///
/// Difference: the real part of the square, as printed; the exact small-sphere law has the square of the modulus.
pub fn harmonic_extinction_m2(radius_um: f64, index: Index, wavelength_nm: f64) -> f64 {
    let (r, wavelength) = (radius_um * 1e-6, wavelength_nm * 1e-9);
    let m2 = Complex64::new(index.n, -index.k).powi(2);
    let ratio = (m2 - 1.0) / (m2 + 2.0);
    let small = 128.0 * PI.powi(5) * r.powi(6) / (3.0 * wavelength.powi(4)) * (ratio * ratio).re
        - 8.0 * PI * PI * r.powi(3) / wavelength * ratio.im;
    let large = 2.0 * PI * r * r * (1.0 + (2.0 * PI * r / wavelength).powf(-2.0 / 3.0));
    if small > 0.0 { small * large / (small + large) } else { 0.0 }
}

/// A mean particle by thesis B: harmonic-mean extinction, a given albedo and a given g [klupiec2024, eq. 19–24].
pub fn harmonic_mean(
    modes: &[Mode],
    index: Index,
    wavelength_nm: f64,
    albedo: f64,
    g: f64,
) -> Result<Optics, AirError> {
    check(modes, wavelength_nm)?;
    let index = Index::new(index.n, index.k)?;
    if !(0.0..=1.0).contains(&albedo) {
        return Err(AirError::Optics { what: "single-scattering albedo".into(), law: "lie in 0..=1", got: albedo });
    }
    if !(-1.0..=1.0).contains(&g) {
        return Err(AirError::Optics { what: "mean cosine g".into(), law: "lie in -1..=1", got: g });
    }
    let number: f64 = modes.iter().map(|mode| mode.number_per_cm3).sum();
    let sum: f64 = modes
        .iter()
        .flat_map(|mode| mode.nodes(wavelength_nm, 800))
        .map(|(radius_um, share)| share * harmonic_extinction_m2(radius_um, index, wavelength_nm))
        .sum();
    Ok(Optics { extinction_m2: sum / number, scattering_m2: albedo * sum / number, g })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOOTY: Index = Index { n: 1.57, k: 0.02 };

    #[test]
    fn a_mode_of_one_size_is_its_sphere() {
        let mode = Mode::new(0.5, 1.0, 3.0).unwrap();
        let optics = lorenz_mie(&[mode], SOOTY, 550.0, FINE).unwrap();
        let mie = Mie::new(2.0 * PI * 0.5 / 0.55, SOOTY).unwrap();
        assert!((optics.extinction_m2 / (mie.q_ext * PI * 0.25e-12) - 1.0).abs() < 1e-12);
        assert!((optics.g - mie.g).abs() < 1e-12);
        let narrow = lorenz_mie(&[Mode::new(0.5, 1.0001, 1.0).unwrap()], SOOTY, 550.0, FINE).unwrap();
        assert!((narrow.extinction_m2 / optics.extinction_m2 - 1.0).abs() < 1e-4);
    }

    /// What a preset's 160 radii cost for its droplets that absorb nothing and ring: 1 % (0.6 % measured).
    #[test]
    fn few_radii_do_for_presets() {
        for (rg, sg, n) in [(0.887, 1.297, 1.44), (0.288, 1.6, 1.43)] {
            let modes = [Mode::new(rg, sg, 1.0).unwrap()];
            for nm in [360.0, 550.0, 830.0] {
                let at = |nodes| lorenz_mie(&modes, Index { n, k: 0.0 }, nm, nodes).unwrap();
                let (few, many) = (at(160), at(FINE));
                let (size, g) = (few.extinction_m2 / many.extinction_m2 - 1.0, few.g - many.g);
                println!("{rg} {nm} nm: extinction {size:+.1e}, g {g:+.1e}");
                assert!(size.abs() < 1e-2 && g.abs() < 1e-2);
            }
        }
    }

    #[test]
    fn modes_add_by_their_numbers() {
        let (a, b) = (Mode::new(0.013, 1.7, 3.0).unwrap(), Mode::new(0.3, 1.4, 1.0).unwrap());
        let one = |modes: &[Mode]| lorenz_mie(modes, SOOTY, 550.0, 400).unwrap().extinction_m2;
        assert!(((3.0 * one(&[a]) + one(&[b])) / 4.0 / one(&[a, b]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_phase_function_of_an_ensemble_is_normalised() {
        let mode = Mode::new(0.2, 1.5, 1.0).unwrap();
        let rule = himmel_core::quadrature::gauss_legendre_unit(200);
        let cosines: Vec<f64> = rule.iter().map(|(x, _)| 2.0 * x - 1.0).collect();
        let p = phase_function(&[mode], SOOTY, 550.0, 200, &cosines).unwrap();
        let sum: f64 = rule.iter().zip(&p).map(|((_, w), p)| 4.0 * PI * w * p).sum();
        let mean: f64 = rule.iter().zip(&p).map(|((x, w), p)| 4.0 * PI * w * p * (2.0 * x - 1.0)).sum();
        let optics = lorenz_mie(&[mode], SOOTY, 550.0, 200).unwrap();
        assert!((sum - 1.0).abs() < 1e-7 && (mean - optics.g).abs() < 1e-5, "{sum} {mean} {}", optics.g);
    }

    /// The harmonic mean is meant for the whole range: right for small absorbing spheres, and half as much again in
    /// between. (For large spheres it tends to the same 2πr².)
    #[test]
    fn the_harmonic_mean_has_the_right_ends() {
        for (radius_um, tolerance) in [(1e-4, 0.02), (100.0, 0.03)] {
            let exact =
                Mie::new(2.0 * PI * radius_um / 0.55, SOOTY).unwrap().q_ext * PI * (radius_um * 1e-6_f64).powi(2);
            let harmonic = harmonic_extinction_m2(radius_um, SOOTY, 550.0);
            assert!((harmonic / exact - 1.0).abs() < tolerance, "{radius_um}: {}", harmonic / exact);
        }
    }

    #[test]
    fn nonsense_is_an_error() {
        assert!(
            Mode::new(0.1, 0.9, 1.0).is_err()
                && Mode::new(f64::NAN, 1.5, 1.0).is_err()
                && Mode::new(0.1, 1.5, -1.0).is_err()
        );
        assert!(lorenz_mie(&[], SOOTY, 550.0, FINE).is_err());
        assert!(lorenz_mie(&[Mode::new(1e4, 9.0, 1.0).unwrap()], SOOTY, 550.0, 10).is_err());
        assert!(harmonic_mean(&[Mode::new(0.1, 1.5, 1.0).unwrap()], SOOTY, 550.0, 1.5, 0.7).is_err());
    }
}
