//! Light scattered by one sphere: the exact solution of Lorenz and Mie.
//!
//! Own implementation: stable for size parameters 1e-6 to 1e5 and any absorbing index, because every quantity is
//! recurred in the direction in which errors shrink. Checked against published tables and PyPI `miepython` to 1e-6.

use std::f64::consts::PI;

use himmel_core::quadrature::gauss_legendre_unit;
use num_complex::Complex64;

use crate::error::AirError;

/// A complex refractive index m = n − ik.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Index {
    /// Real part: how much slower light is within.
    pub n: f64,
    /// Imaginary part, zero or positive: how much it absorbs.
    pub k: f64,
}

impl Index {
    /// Checks 0 < n ≤ 100 and 0 ≤ k ≤ 100.
    pub fn new(n: f64, k: f64) -> Result<Self, AirError> {
        let value = |what: &str, law, got| AirError::Optics { what: what.into(), law, got };
        if !(n > 0.0 && n <= 100.0) {
            return Err(value("real part of the refractive index", "lie in 0..=100 and not be 0", n));
        }
        if !(0.0..=100.0).contains(&k) {
            return Err(value(
                "imaginary part k of the refractive index n - ik",
                "lie in 0..=100 (positive absorbs)",
                k,
            ));
        }
        Ok(Self { n, k })
    }
}

/// What a sphere does to light.
#[derive(Clone, Debug)]
pub struct Mie {
    /// 2πr/λ.
    pub size_parameter: f64,
    /// Extinction cross section over πr².
    pub q_ext: f64,
    /// Scattering cross section over πr².
    pub q_sca: f64,
    /// Mean cosine of the scattering angle.
    pub g: f64,
    /// Coefficients a_n and b_n, n = 1, 2, …
    coefficients: Vec<(Complex64, Complex64)>,
}

/// Size parameters for which [`Mie::new`] answers: below, χ_n overflows; above, nobody needs it.
pub const SIZE_PARAMETERS: std::ops::RangeInclusive<f64> = 1e-6..=1e5;

impl Mie {
    /// Solves for a sphere.
    ///
    /// a_n = ψ_n (D_n(mx)/m − D_n(x)) / (ξ_n (D_n(mx)/m + n/x) − ξ_{n−1}), b_n with m D_n(mx) for D_n(mx)/m
    /// [bohren1983, eq. 4.88]; ψ_n and χ_n are Riccati–Bessel functions, ξ_n = ψ_n − iχ_n, D_n = ψ_n′/ψ_n.
    /// Q_ext = 2/x² Σ (2n+1) Re(a_n + b_n), Q_sca = 2/x² Σ (2n+1)(|a_n|² + |b_n|²) [bohren1983, eq. 4.61–62];
    /// g Q_sca = 4/x² Σ [n(n+2)/(n+1) Re(a_n a*_{n+1} + b_n b*_{n+1}) + (2n+1)/(n(n+1)) Re(a_n b*_n)].
    ///
    /// D_n is recurred downwards; ψ_n upwards to n = x, where both directions are neutral, and from there by its ratio
    /// 1/(n/x + D_n(x)); χ_n upwards. The series ends at x + 4.05 x^⅓ + 8, a few terms after [wiscombe1980].
    ///
    /// Difference: D_n(x) stands for the ψ_{n−1} of the source where n > x, so that nothing cancels for small spheres.
    /// Laws tested: Q_ext = Q_sca without absorption; Q_ext → 2 for large spheres; Rayleigh's limit; an index of 1 is
    /// invisible; ∫ p dω = 1 with mean cosine g.
    pub fn new(size_parameter: f64, index: Index) -> Result<Self, AirError> {
        let x = size_parameter;
        if !SIZE_PARAMETERS.contains(&x) {
            return Err(AirError::Optics { what: "size parameter 2πr/λ".into(), law: "lie in 1e-6..=1e5", got: x });
        }
        let Index { n, k } = Index::new(index.n, index.k)?;
        let m = Complex64::new(n, k); // conjugate of n − ik: the source's sign of time
        let terms = (x + 4.05 * x.cbrt() + 8.0) as usize;
        let inside = log_derivatives(m * x, terms);
        let outside = log_derivatives(Complex64::new(x, 0.0), terms);
        let (mut psi, mut psi_before) = (x.sin(), x.cos());
        let (mut chi, mut chi_before) = (x.cos(), -x.sin());
        let mut coefficients = Vec::with_capacity(terms);
        for order in 1..=terms {
            let over = order as f64 / x;
            let d_outside = outside[order].re;
            let psi_next =
                if (order as f64) < x { (2.0 * over - 1.0 / x) * psi - psi_before } else { psi / (over + d_outside) };
            let chi_next = (2.0 * over - 1.0 / x) * chi - chi_before;
            (psi_before, psi) = (psi, psi_next);
            (chi_before, chi) = (chi, chi_next);
            let (xi, xi_before) = (Complex64::new(psi, -chi), Complex64::new(psi_before, -chi_before));
            let coefficient = |d: Complex64| {
                let numerator = if (order as f64) < x { (d + over) * psi - psi_before } else { (d - d_outside) * psi };
                numerator / ((d + over) * xi - xi_before)
            };
            coefficients.push((coefficient(inside[order] / m), coefficient(inside[order] * m)));
        }
        let (mut ext, mut sca, mut asymmetry) = (0.0, 0.0, 0.0);
        // From the small terms to the large ones.
        for (i, (a, b)) in coefficients.iter().enumerate().rev() {
            let order = (i + 1) as f64;
            ext += (2.0 * order + 1.0) * (a.re + b.re);
            sca += (2.0 * order + 1.0) * (a.norm_sqr() + b.norm_sqr());
            asymmetry += (2.0 * order + 1.0) / (order * (order + 1.0)) * (a * b.conj()).re;
            if let Some((a_next, b_next)) = coefficients.get(i + 1) {
                asymmetry += order * (order + 2.0) / (order + 1.0) * (a * a_next.conj() + b * b_next.conj()).re;
            }
        }
        let scale = 2.0 / (x * x);
        let g = if sca > 0.0 { 2.0 * asymmetry / sca } else { 0.0 };
        Ok(Self { size_parameter, q_ext: scale * ext, q_sca: scale * sca, g, coefficients })
    }

    /// (|S₁|² + |S₂|²)/2 at a cosine of the scattering angle, for unpolarised light [bohren1983, eq. 4.74, 4.77].
    pub fn intensity(&self, cos_theta: f64) -> f64 {
        let (mut pi, mut pi_before) = (1.0, 0.0);
        let (mut s1, mut s2) = (Complex64::default(), Complex64::default());
        for (i, (a, b)) in self.coefficients.iter().enumerate() {
            let order = (i + 1) as f64;
            let tau = order * cos_theta * pi - (order + 1.0) * pi_before;
            let weight = (2.0 * order + 1.0) / (order * (order + 1.0));
            s1 += (a * pi + b * tau) * weight;
            s2 += (a * tau + b * pi) * weight;
            let next = ((2.0 * order + 1.0) * cos_theta * pi - (order + 1.0) * pi_before) / order;
            (pi_before, pi) = (pi, next);
        }
        0.5 * (s1.norm_sqr() + s2.norm_sqr())
    }

    /// The phase function, sr⁻¹: intensity / (π x² Q_sca).
    pub fn phase(&self, cos_theta: f64) -> f64 {
        let norm = PI * self.size_parameter * self.size_parameter * self.q_sca;
        if norm > 0.0 { self.intensity(cos_theta) / norm } else { 0.25 / PI }
    }

    /// Legendre moments χ_l = ∫ p P_l dω, l = 0 … `count` − 1: exact, because the intensity is a polynomial in cos θ.
    pub fn legendre_moments(&self, count: usize) -> Vec<f64> {
        let nodes = self.coefficients.len() + count / 2 + 1;
        let mut moments = vec![0.0; count];
        for (x, w) in gauss_legendre_unit(nodes) {
            let cos_theta = 2.0 * x - 1.0;
            let weight = 4.0 * PI * w * self.phase(cos_theta);
            crate::phase::for_each_legendre(cos_theta, count, |l, p| moments[l] += weight * p);
        }
        moments
    }
}

/// D_n(z) = ψ_n′(z)/ψ_n(z) for n = 0 … `terms`, downwards: D_{n−1} = n/z − 1/(D_n + n/z).
///
/// Started beyond the turning point |z| by five of its widths |z|^⅓, where the error of any start has died out.
fn log_derivatives(z: Complex64, terms: usize) -> Vec<Complex64> {
    let size = z.norm();
    let start = terms.max(size as usize) + 16 + (5.0 * size.cbrt()) as usize;
    let mut d = Complex64::default();
    let mut all = vec![d; terms + 1];
    let inverse = z.inv();
    for order in (1..=start).rev() {
        let over = inverse * order as f64;
        d = over - (d + over).inv();
        if order <= terms + 1 {
            all[order - 1] = d;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere(x: f64, n: f64, k: f64) -> Mie {
        Mie::new(x, Index { n, k }).unwrap()
    }

    /// Bohren and Huffman's own example: x = 2π·0.525/0.6328, m = 1.55: Q_sca 3.10543, Q_ext 3.10543 [bohren1983, app. A].
    #[test]
    fn the_books_example() {
        let mie = sphere(2.0 * PI * 0.525 / 0.6328, 1.55, 0.0);
        assert!((mie.q_sca - 3.10543).abs() < 5e-6 && (mie.q_ext - 3.10543).abs() < 5e-6, "{mie:?}");
    }

    /// Test cases 9–11, 13–18 of MIEV0 as printed, six decimals of Q_sca and g [wiscombe1979].
    #[test]
    fn wiscombes_cases() {
        for (x, n, k, q_sca, g) in [
            (1.0, 1.33, 1e-5, 0.093923, 0.184517),
            (100.0, 1.33, 1e-5, 2.096594, 0.868959),
            (1e4, 1.33, 1e-5, 1.723857, 0.907840),
            (1.0, 1.5, 1.0, 0.663454, 0.192136),
            (100.0, 1.5, 1.0, 1.283697, 0.850252),
            (1e4, 1.5, 1.0, 1.236575, 0.846310),
            (1.0, 10.0, 10.0, 2.049405, -0.110664),
            (100.0, 10.0, 10.0, 1.836785, 0.556215),
        ] {
            let mie = sphere(x, n, k);
            assert!(
                (mie.q_sca - q_sca).abs() < 1e-6 && (mie.g - g).abs() < 1e-6,
                "{x} {n} {k}: {} {}",
                mie.q_sca,
                mie.g
            );
        }
    }

    #[test]
    fn without_absorption_nothing_is_lost() {
        for x in [1e-4, 1e-3, 0.03, 0.5, 1.0, 7.3, 55.0, 300.0, 1e4] {
            for n in [0.75, 1.33, 1.5, 2.4] {
                let mie = sphere(x, n, 0.0);
                assert!((mie.q_ext / mie.q_sca - 1.0).abs() < 1e-9, "{x} {n}: {} {}", mie.q_ext, mie.q_sca);
            }
        }
    }

    /// Q_ext → 2 + 1.9924 x^(−2/3) for large opaque spheres [nussenzveig1980]; 1e-3: the next terms of the series.
    #[test]
    fn large_spheres_take_twice_their_shadow() {
        for x in [1e3, 1e4] {
            let mie = sphere(x, 1.5, 0.5);
            assert!((mie.q_ext - 2.0 - 1.9924 * f64::powf(x, -2.0 / 3.0)).abs() < 1e-3, "{}", mie.q_ext);
        }
    }

    /// Q_sca = 8/3 x⁴ |(m²−1)/(m²+2)|², Q_abs = 4x Im… [bohren1983, eq. 5.7–5.8]; the next order is x² smaller.
    #[test]
    fn small_spheres_scatter_as_rayleigh_says() {
        for (n, k) in [(1.33, 0.0), (1.57, 0.02), (1.75, 0.44)] {
            for x in [1e-6, 1e-4, 1e-3] {
                let m2 = Complex64::new(n, k).powi(2);
                let ratio = (m2 - 1.0) / (m2 + 2.0);
                let mie = sphere(x, n, k);
                assert!((mie.q_sca / (8.0 / 3.0 * x.powi(4) * ratio.norm_sqr()) - 1.0).abs() < 5e-6);
                let absorbed = 4.0 * x * ratio.im;
                assert!(k == 0.0 || ((mie.q_ext - mie.q_sca) / absorbed - 1.0).abs() < 5e-6, "{x} {k}");
                assert!(mie.g.abs() < x);
            }
        }
    }

    #[test]
    fn an_index_of_one_is_invisible() {
        let mie = sphere(5.0, 1.0, 0.0);
        assert!(mie.q_ext.abs() < 1e-12 && mie.q_sca < 1e-12);
    }

    #[test]
    fn the_phase_function_integrates_to_one_and_has_its_mean_cosine() {
        for (x, n, k) in
            [(1e-3, 1.5, 0.0), (0.5, 1.33, 0.0), (12.0, 1.44, 0.0), (80.0, 1.57, 0.02), (500.0, 1.33, 1e-6)]
        {
            let mie = sphere(x, n, k);
            let moments = mie.legendre_moments(3);
            assert!((moments[0] - 1.0).abs() < 1e-9 && (moments[1] - mie.g).abs() < 1e-9, "{x}: {moments:?} {}", mie.g);
        }
    }

    #[test]
    fn nonsense_is_an_error() {
        for (x, n, k) in [
            (0.0, 1.5, 0.0),
            (-1.0, 1.5, 0.0),
            (f64::NAN, 1.5, 0.0),
            (1e9, 1.5, 0.0),
            (1.0, 0.0, 0.0),
            (1.0, 1.5, -0.1),
            (1.0, f64::INFINITY, 0.0),
        ] {
            assert!(Mie::new(x, Index { n, k }).is_err());
        }
    }
}
