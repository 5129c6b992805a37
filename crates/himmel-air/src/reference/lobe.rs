//! Phase functions at N wavelengths: evaluated together, sampled exactly.

use std::f64::consts::PI;

use glam::DVec3;
use himmel_core::quadrature::gauss_legendre_unit;

use super::random::Random;
use crate::phase::{Phase, Tabulated, draine_phase, rayleigh_phase};

/// A phase function at N wavelengths.
pub(super) struct Lobe<const N: usize> {
    shape: Shape<N>,
    /// Mean cosine of the scattering angle.
    pub mean_cosine: [f64; N],
}

enum Shape<const N: usize> {
    Rayleigh {
        gamma: f64,
    },
    /// Draine's function: Henyey–Greenstein for α = 0, Cornette–Shanks for α = 1.
    Draine {
        g: [f64; N],
        alpha: f64,
        grey: bool,
    },
    Table {
        table: Tabulated,
        at: [(usize, f64); N],
        angle: Vec<Vec<f64>>,
    },
}

impl<const N: usize> Lobe<N> {
    pub fn new(phase: &Phase, wavelengths_nm: &[f64; N]) -> Self {
        let draine = |g: [f64; N], alpha| Shape::Draine { g, alpha, grey: g.iter().all(|value| *value == g[0]) };
        let shape = match phase {
            Phase::Rayleigh { gamma } => Shape::Rayleigh { gamma: *gamma },
            Phase::HenyeyGreenstein { g } => draine(g.sample(wavelengths_nm), 0.0),
            Phase::CornetteShanks { g } => draine(g.sample(wavelengths_nm), 1.0),
            Phase::Draine { g, alpha } => draine(g.sample(wavelengths_nm), *alpha),
            Phase::Tabulated(table) => Shape::Table {
                at: wavelengths_nm.map(|nm| table.locate(nm)),
                angle: (0..table.tables()).map(|index| cumulative(table, index)).collect(),
                table: table.clone(),
            },
        };
        Self { shape, mean_cosine: wavelengths_nm.map(|nm| phase.mean_cosine(nm)) }
    }

    /// Whether it has a forward peak worth aiming at.
    pub fn peaked(&self) -> bool {
        !matches!(self.shape, Shape::Rayleigh { .. }) && self.mean_cosine.iter().any(|g| *g > 0.2)
    }

    /// The phase function, sr⁻¹.
    pub fn at(&self, cos_theta: f64) -> [f64; N] {
        match &self.shape {
            Shape::Rayleigh { gamma } => [rayleigh_phase(cos_theta, *gamma); N],
            Shape::Draine { g, alpha, grey: true } => [draine_phase(cos_theta, g[0], *alpha); N],
            Shape::Draine { g, alpha, grey: false } => g.map(|g| draine_phase(cos_theta, g, *alpha)),
            Shape::Table { table, at, .. } => at.map(|(index, t)| match t {
                0.0 => table.one(index, cos_theta),
                t => table.one(index, cos_theta) * (1.0 - t) + table.one(index + 1, cos_theta) * t,
            }),
        }
    }

    /// A cosine of the scattering angle with the density of wavelength `k`.
    pub fn sample(&self, k: usize, random: &mut Random) -> f64 {
        match &self.shape {
            Shape::Rayleigh { gamma } => loop {
                let mu = 2.0 * random.unit() - 1.0;
                let (even, square) = (1.0 + 3.0 * gamma, 1.0 - gamma);
                if random.unit() * (even + square) <= even + square * mu * mu {
                    return mu;
                }
            },
            Shape::Draine { g, alpha, .. } => loop {
                let (g, u) = (g[k], random.unit());
                let mu = if g.abs() < 1e-4 {
                    // The inversion of Henyey–Greenstein loses its digits here; first order in g.
                    let even = 2.0 * u - 1.0;
                    even + 1.5 * g * (1.0 - even * even)
                } else {
                    let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
                    (1.0 + g * g - ratio * ratio) / (2.0 * g)
                };
                let mu = mu.clamp(-1.0, 1.0);
                if *alpha == 0.0 || random.unit() * (1.0 + alpha) <= 1.0 + alpha * mu * mu {
                    return mu;
                }
            },
            Shape::Table { table, at, angle } => {
                let (index, t) = at[k];
                let index = if t > 0.0 && random.unit() < t { index + 1 } else { index };
                let u = random.unit();
                let bin = angle[index].partition_point(|sum| *sum <= u).clamp(1, Tabulated::ANGLES - 1);
                let cosine = |i: usize| (PI * (i as f64 / (Tabulated::ANGLES - 1) as f64).powi(2)).cos();
                let (near, far) = (cosine(bin - 1), cosine(bin));
                // The logarithm is straight within a bin: its ends are its extremes.
                let largest = table.one(index, near).max(table.one(index, far));
                loop {
                    let mu = far + random.unit() * (near - far);
                    if random.unit() * largest <= table.one(index, mu) {
                        return mu;
                    }
                }
            }
        }
    }
}

/// Share of the light within each angle of a table.
fn cumulative(table: &Tabulated, index: usize) -> Vec<f64> {
    let rule = gauss_legendre_unit(8);
    let mut sum = 0.0;
    let mut sums = vec![0.0];
    for bin in 1..Tabulated::ANGLES {
        let last = (Tabulated::ANGLES - 1) as f64;
        let (from, to) = ((bin - 1) as f64 / last, bin as f64 / last);
        for (x, w) in &rule {
            let s = from + x * (to - from);
            let theta = PI * s * s;
            sum += w * (to - from) * 2.0 * PI * s * theta.sin() * table.one(index, theta.cos()) * 2.0 * PI;
        }
        sums.push(sum);
    }
    sums.iter_mut().for_each(|value| *value /= sum);
    sums
}

/// A unit vector at an angle to an axis, at an even azimuth.
pub(super) fn around(axis: DVec3, cos_theta: f64, random: &mut Random) -> DVec3 {
    let (sin_phi, cos_phi) = (2.0 * PI * random.unit()).sin_cos();
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (x, y) = axis.any_orthonormal_pair();
    (x * (sin_theta * cos_phi) + y * (sin_theta * sin_phi) + axis * cos_theta).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use himmel_core::spectrum::Spectrum;

    /// Legendre moments of 400,000 samples against those of the function, 5 standard errors (about 0.004) each.
    #[test]
    fn samples_follow_their_function() {
        let droplets = Preset::named("venus").unwrap().medium.components[1].phase.clone().unwrap();
        for phase in [
            Phase::Rayleigh { gamma: 0.0143 },
            Phase::HenyeyGreenstein { g: Spectrum::Constant(0.76) },
            Phase::HenyeyGreenstein { g: Spectrum::Constant(5e-5) },
            Phase::HenyeyGreenstein { g: Spectrum::Constant(-0.4) },
            Phase::CornetteShanks { g: Spectrum::Constant(0.8) },
            Phase::Draine { g: Spectrum::Constant(0.5), alpha: 0.4 },
            droplets,
        ] {
            let lobe = Lobe::new(&phase, &[550.0]);
            let mut random = Random::new(7, 0, 0);
            let count = 400_000;
            let mut sums = [0.0; 6];
            for _ in 0..count {
                let mu = lobe.sample(0, &mut random);
                crate::phase::for_each_legendre(mu, 6, |l, p| sums[l] += p / f64::from(count));
            }
            for (l, stated) in phase.legendre_moments(6, 550.0).iter().enumerate() {
                assert!((sums[l] - stated).abs() < 0.004, "{phase:?} {l}: {} {stated}", sums[l]);
            }
            for mu in [-1.0, -0.3, 0.4, 0.99, 1.0] {
                assert!((lobe.at(mu)[0] / phase.at(mu, 550.0) - 1.0).abs() < 1e-12);
            }
        }
    }
}
