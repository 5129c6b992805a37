//! What the aerosols' forward peaks do to the beam: sunlight that they scatter by small angles is not lost, it arrives
//! from around the Sun.

use std::f64::consts::PI;

use crate::medium::Component;
use crate::phase::for_each_legendre;

use super::optics::{Optics, Scatterer};

/// Corrections B_S and B_U of one component over scattering angle and optical depth of the peak.
///
/// ```text
/// B_S = e^(−τ) (p − (1−f) p′) + Σ (2l+1)/4π r_l ((e^(−τ(1−χ_l^F)) − e^(−τ))/(τ χ_l^F) − e^(−τ)) P_l
/// B_U = e^(−τ) p             + Σ (2l+1)/4π χ_l (e^(−τ(1−χ_l^F)) − e^(−τ)) P_l
/// ```
///
/// p: the component's phase function, exact, evaluated by the reader.  r_l: moments of p − (1−f) p′ (f up to l = 3,
/// χ_l above).  χ_l^F: moments of the peak that the beam meets on its way, 1 up to l = 3: the peaks of all components,
/// weighted by their vertical columns of peak scattering.  τ: optical depth of the peaks, f σ_s.
///
/// For one aerosol (r_l = f χ_l^F) these are the sums of `moment-tables.md`. Written as what is added to the exact
/// phase function they converge as χ_l² and not as χ_l, and vanish in thin air. The table holds the sums divided by
/// (1 − e^(−τ)), which makes them smooth at τ = 0.
#[derive(Clone, Debug)]
struct Corrections<const N: usize> {
    /// `[angle][depth]`: scaled (S) and unscaled (U), sr⁻¹.
    nodes: Vec<[[f64; N]; 2]>,
}

/// The corrections of all components.
#[derive(Clone, Debug)]
pub(super) struct Peaks<const N: usize> {
    angles: usize,
    depths: usize,
    components: Vec<Corrections<N>>,
    /// Largest share of Σ (2l+1) |χ_l χ_l^F| that the last tenth of the terms holds.
    pub remainder: f64,
}

/// The corrections of all components at one scattering angle.
#[derive(Clone, Debug)]
pub(super) struct AtAngle<const N: usize> {
    /// `[component][depth]`.
    components: Vec<Vec<[[f64; N]; 2]>>,
}

/// Optical depth of a node: x = √(τ/(6 + τ)). The last stands for everything beyond.
pub(super) fn depth_of(node: usize, nodes: usize) -> f64 {
    let x = node as f64 / (nodes - 1) as f64;
    // 1e4: thicker than any light gets through.
    (6.0 * x * x / (1.0 - x * x).max(1e-9)).min(1e4)
}

/// (e^y − 1)/y − 1, without cancellation.
fn excess_ratio(y: f64) -> f64 {
    if y.abs() < 1e-3 { y / 2.0 + y * y / 6.0 } else { y.exp_m1() / y - 1.0 }
}

/// The two factors of a term at a depth: S and U, divided by (1 − e^(−τ)).
fn factors(chi: f64, tau: f64) -> [f64; 2] {
    if tau < 1e-9 {
        return [chi / 2.0, chi];
    }
    let y = tau * chi;
    let norm = -(-tau).exp_m1();
    let unscaled = ((y - tau).exp() - (-tau).exp()) / norm;
    // e^(−τ) ((e^y − 1)/y − 1), with the large exponents taken together.
    let scaled =
        if y > 1.0 { ((y - tau).exp() - (-tau).exp()) / y - (-tau).exp() } else { (-tau).exp() * excess_ratio(y) };
    [scaled / norm, unscaled]
}

/// Moments of the peak that the beam meets: Σ σ_s N r_l / Σ f σ_s N over the components that have one, N the vertical
/// column.
fn beam_moments<const N: usize>(components: &[Component], optics: &Optics<N>, top_m: f64) -> Vec<[f64; N]> {
    let terms = optics.scatterers.iter().map(|s| s.rest.len()).max().unwrap_or(0);
    let mut chi = vec![[0.0; N]; terms];
    let mut weight = [0.0; N];
    for (component, s) in components.iter().zip(&optics.scatterers) {
        if !s.is_aerosol() {
            continue;
        }
        let column_m = component.profile.column_m(0.0, top_m);
        for k in 0..N {
            if s.peak_per_m[k] > 0.0 {
                weight[k] += column_m * s.peak_per_m[k];
                for (chi, rest) in chi.iter_mut().zip(&s.rest) {
                    chi[k] += column_m * s.scattering_per_m[k] * rest[k];
                }
            }
        }
    }
    for chi in &mut chi {
        for k in 0..N {
            // A peak wider than itself is none: |χ| ≤ 1 (phase functions with χ₃ below a later moment).
            chi[k] = if weight[k] > 0.0 { (chi[k] / weight[k]).clamp(-1.0, 1.0) } else { 0.0 };
        }
    }
    chi
}

impl<const N: usize> Peaks<N> {
    /// Sums the series. `angles`, `depths`: size of the tables, at least 2.
    pub fn new(components: &[Component], optics: &Optics<N>, top_m: f64, angles: usize, depths: usize) -> Self {
        Self::with_ratio(components, optics, top_m, angles, depths, [1.0; N])
    }

    /// The same with nodes whose depth at each wavelength is `ratio` times the node's.
    pub fn with_ratio(
        components: &[Component],
        optics: &Optics<N>,
        top_m: f64,
        angles: usize,
        depths: usize,
        ratio: [f64; N],
    ) -> Self {
        let (angles, depths) = (angles.max(2), depths.max(2));
        let beam = beam_moments(components, optics, top_m);
        let terms = beam.len();
        // factors[depth][l][k]
        let factors: Vec<Vec<[[f64; 2]; N]>> = (0..depths)
            .map(|d| depth_of(d, depths))
            .map(|tau| beam.iter().map(|chi| std::array::from_fn(|k| factors(chi[k], ratio[k] * tau))).collect())
            .collect();
        let one = |s: &Scatterer<N>| {
            let mut nodes = vec![[[0.0; N]; 2]; angles * depths];
            if !s.is_aerosol() {
                return Corrections { nodes };
            }
            let mut legendre = vec![0.0; terms];
            for (angle, row) in nodes.chunks_mut(depths).enumerate() {
                let x = angle as f64 / (angles - 1) as f64;
                for_each_legendre((PI * x * x).cos(), terms, |l, p| legendre[l] = (2 * l + 1) as f64 * p / (4.0 * PI));
                for (node, factors) in row.iter_mut().zip(&factors) {
                    for (l, factor) in factors.iter().enumerate() {
                        for k in 0..N {
                            node[0][k] += legendre[l] * s.rest[l][k] * factor[k][0];
                            node[1][k] += legendre[l] * s.all_chi[l][k] * factor[k][1];
                        }
                    }
                }
            }
            Corrections { nodes }
        };
        let mut remainder: f64 = 0.0;
        for s in optics.scatterers.iter().filter(|s| s.is_aerosol()) {
            for k in 0..N {
                let term = |l: usize| (2 * l + 1) as f64 * (s.all_chi[l][k] * beam[l][k]).abs();
                let all: f64 = (0..terms).map(term).sum();
                let last: f64 = (terms - terms / 10..terms).map(term).sum();
                remainder = remainder.max(if all > 0.0 { last / all } else { 0.0 });
            }
        }
        Self { angles, depths, components: optics.scatterers.iter().map(one).collect(), remainder }
    }

    /// The nodes of a component, `[angle][depth]`, of S and of U.
    pub fn nodes(&self, component: usize) -> [Vec<[f64; N]>; 2] {
        let Some(corrections) = self.components.get(component) else { return [Vec::new(), Vec::new()] };
        [0, 1].map(|which| corrections.nodes.iter().map(|node| node[which]).collect())
    }

    /// The corrections at one scattering angle: constant along a ray.
    pub fn at_angle(&self, cos_theta: f64) -> AtAngle<N> {
        let x = (cos_theta.clamp(-1.0, 1.0).acos() / PI).sqrt() * (self.angles - 1) as f64;
        let i = (x as usize).min(self.angles - 2);
        let x = x - i as f64;
        let row = |corrections: &Corrections<N>| {
            let (a, b) = (&corrections.nodes[i * self.depths..], &corrections.nodes[(i + 1) * self.depths..]);
            let mix = |(a, b): (&[[f64; N]; 2], &[[f64; N]; 2])| -> [[f64; N]; 2] {
                std::array::from_fn(|s| std::array::from_fn(|k| a[s][k] + (b[s][k] - a[s][k]) * x))
            };
            a.iter().zip(b).take(self.depths).map(mix).collect()
        };
        AtAngle { components: self.components.iter().map(row).collect() }
    }
}

impl<const N: usize> AtAngle<N> {
    /// The S (0) or U (1) correction of a component at wavelength `k` and depth τ, sr⁻¹.
    pub fn at(&self, component: usize, which: usize, k: usize, tau: f64) -> f64 {
        let Some(row) = self.components.get(component).filter(|row| row.len() > 1) else { return 0.0 };
        let x = (tau / (6.0 + tau)).sqrt().min(1.0) * (row.len() - 1) as f64;
        let i = (x as usize).min(row.len() - 2);
        let value = himmel_core::interpolate::lerp(row[i][which][k], row[i + 1][which][k], x - i as f64);
        value * -(-tau).exp_m1()
    }
}
