//! Phase functions: where scattered light goes. All integrate to 1 over the sphere (unit sr⁻¹).

use std::f64::consts::PI;

use himmel_core::spectrum::Spectrum;

/// A phase function whose shape may depend on the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Molecules [chandrasekhar1960, §17].
    Rayleigh {
        /// γ = δ / (2 − δ) from the depolarisation factor δ; 0 for isotropic molecules.
        gamma: f64,
    },
    /// Henyey–Greenstein [henyey1941].
    HenyeyGreenstein {
        /// Mean cosine of the scattering angle, −1..1.
        g: Spectrum,
    },
    /// Cornette–Shanks [cornette1992].
    CornetteShanks {
        /// Its parameter; the mean cosine is 3g(4 + g²)/(5(2 + g²)).
        g: Spectrum,
    },
}

/// p(θ) = 3 / (16π (1 + 2γ)) · ((1 + 3γ) + (1 − γ) cos²θ)   [chandrasekhar1960, §17]
///
/// `cos_theta`: cosine of the scattering angle.  `gamma`: δ / (2 − δ).
/// Laws tested: integrates to 1; symmetric; γ = 0 gives 3/(16π)(1 + cos²θ).
pub fn rayleigh_phase(cos_theta: f64, gamma: f64) -> f64 {
    3.0 / (16.0 * PI * (1.0 + 2.0 * gamma)) * ((1.0 + 3.0 * gamma) + (1.0 - gamma) * cos_theta * cos_theta)
}

/// p(θ) = (1 − g²) / (4π (1 + g² − 2g cos θ)^(3/2))   [henyey1941]
///
/// Laws tested: integrates to 1; mean cosine g.
pub fn henyey_greenstein_phase(cos_theta: f64, g: f64) -> f64 {
    let base = (1.0 + g * g - 2.0 * g * cos_theta).max(1e-12); // zero only at |g| = 1, where it is a delta
    (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
}

/// p(θ) = 3/(8π) · (1 − g²)/(2 + g²) · (1 + cos²θ) / (1 + g² − 2g cos θ)^(3/2)   [cornette1992]
///
/// Laws tested: integrates to 1; mean cosine 3g(4 + g²)/(5(2 + g²)).
pub fn cornette_shanks_phase(cos_theta: f64, g: f64) -> f64 {
    1.5 * (1.0 + cos_theta * cos_theta) / (2.0 + g * g) * henyey_greenstein_phase(cos_theta, g)
}

/// Calls `f` with l and P_l(x) for l = 0 … `count` − 1.
pub fn for_each_legendre(x: f64, count: usize, mut f: impl FnMut(usize, f64)) {
    let (mut p, mut before) = (1.0, 0.0);
    for l in 0..count {
        f(l, p);
        let next = ((2 * l + 1) as f64 * x * p - l as f64 * before) / (l + 1) as f64;
        (before, p) = (p, next);
    }
}

impl Phase {
    /// The phase function at a wavelength, sr⁻¹.
    pub fn at(&self, cos_theta: f64, wavelength_nm: f64) -> f64 {
        match self {
            Self::Rayleigh { gamma } => rayleigh_phase(cos_theta, *gamma),
            Self::HenyeyGreenstein { g } => henyey_greenstein_phase(cos_theta, g.at(wavelength_nm)),
            Self::CornetteShanks { g } => cornette_shanks_phase(cos_theta, g.at(wavelength_nm)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use himmel_core::quadrature::gauss_legendre_unit;

    /// ∫ p dω and ∫ p cos θ dω, with nodes crowded towards the forward peak.
    fn moments(phase: &Phase) -> (f64, f64) {
        gauss_legendre_unit(200).iter().fold((0.0, 0.0), |(sum, mean), (x, w)| {
            let cos_theta = 1.0 - 2.0 * x * x;
            let weight = w * 4.0 * x * 2.0 * PI * phase.at(cos_theta, 550.0);
            (sum + weight, mean + weight * cos_theta)
        })
    }

    #[test]
    fn phases_integrate_to_one_and_have_their_stated_mean_cosine() {
        for g in [-0.5, 0.0, 0.3, 0.76, 0.8, 0.9] {
            let spectrum = Spectrum::Constant(g);
            let (sum, mean) = moments(&Phase::HenyeyGreenstein { g: spectrum.clone() });
            assert!((sum - 1.0).abs() < 1e-10 && (mean - g).abs() < 1e-10, "HG {g}: {sum} {mean}");
            let (sum, mean) = moments(&Phase::CornetteShanks { g: spectrum });
            let stated = 3.0 * g * (4.0 + g * g) / (5.0 * (2.0 + g * g));
            assert!((sum - 1.0).abs() < 1e-10 && (mean - stated).abs() < 1e-10, "CS {g}: {sum} {mean}");
        }
        for gamma in [0.0, 0.0143, 0.1] {
            let (sum, mean) = moments(&Phase::Rayleigh { gamma });
            assert!((sum - 1.0).abs() < 1e-12 && mean.abs() < 1e-12);
        }
        assert!((rayleigh_phase(0.5, 0.0) - 3.0 / (16.0 * PI) * 1.25).abs() < 1e-15);
    }
}
