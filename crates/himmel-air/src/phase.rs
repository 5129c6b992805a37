//! Phase functions: where scattered light goes. All integrate to 1 over the sphere (unit sr⁻¹).

use std::f64::consts::PI;

use himmel_core::interpolate;
use himmel_core::quadrature::gauss_legendre_unit;
use himmel_core::spectrum::Spectrum;

use crate::error::AirError;

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
    /// Draine [draine2003, eq. 4].
    Draine {
        /// Its parameter g.
        g: Spectrum,
        /// Weight of the Rayleigh-like part, 0..=1: 0 is Henyey–Greenstein, 1 is Cornette–Shanks.
        alpha: f64,
    },
    /// Computed or measured, at several wavelengths.
    Tabulated(Tabulated),
}

/// A phase function in tables, one for each wavelength: the logarithm is linear between the angles, the value
/// between the wavelengths (which keeps the integral); beyond the last wavelengths it stays what it is there.
#[derive(Clone, Debug, PartialEq)]
pub struct Tabulated {
    wavelength_nm: Vec<f64>,
    /// ln p at θ = π (i/(n − 1))², for each wavelength.
    log_p: Vec<Vec<f64>>,
}

impl Tabulated {
    /// Angles of a table: crowded in the forward peak, where the renderer's own table has them.
    pub const ANGLES: usize = 256;

    /// Cosines of the angles at which [`Tabulated::new`] wants its values.
    pub fn cosines() -> Vec<f64> {
        (0..Self::ANGLES).map(|i| (PI * (i as f64 / (Self::ANGLES - 1) as f64).powi(2)).cos()).collect()
    }

    /// From values at [`Tabulated::cosines`] for each of the ascending wavelengths; scaled so that each table integrates to 1.
    pub fn new(wavelength_nm: Vec<f64>, values: Vec<Vec<f64>>) -> Result<Self, AirError> {
        let ascending = wavelength_nm.windows(2).all(|pair| pair[0] < pair[1]);
        if wavelength_nm.is_empty() || values.len() != wavelength_nm.len() || !ascending {
            let what = "number of phase tables".into();
            return Err(AirError::Optics {
                what,
                law: "be that of its ascending wavelengths, and at least 1",
                got: values.len() as f64,
            });
        }
        let mut log_p = Vec::new();
        for table in values {
            if table.len() != Self::ANGLES || table.iter().any(|p| !(p.is_finite() && *p >= 0.0)) {
                let what = "values of a phase table".into();
                return Err(AirError::Optics {
                    what,
                    law: "be 256 numbers, zero or positive",
                    got: table.len() as f64,
                });
            }
            // 1e-12 per steradian is darker than any scattered light that shows; keeps the logarithm finite.
            log_p.push(table.iter().map(|p| p.max(1e-12).ln()).collect::<Vec<f64>>());
        }
        let mut tabulated = Self { wavelength_nm, log_p };
        for i in 0..tabulated.log_p.len() {
            let norm = integrate(|cos_theta| tabulated.one(i, cos_theta)).ln();
            tabulated.log_p[i].iter_mut().for_each(|value| *value -= norm);
        }
        Ok(tabulated)
    }

    /// The table below a wavelength and the weight of the next one.
    pub(crate) fn locate(&self, wavelength_nm: f64) -> (usize, f64) {
        interpolate::locate(&self.wavelength_nm, wavelength_nm)
    }

    /// How many wavelengths it holds.
    pub(crate) fn tables(&self) -> usize {
        self.wavelength_nm.len()
    }

    fn log_one(&self, table: usize, cos_theta: f64) -> f64 {
        let x = (cos_theta.clamp(-1.0, 1.0).acos() / PI).sqrt() * (Self::ANGLES - 1) as f64;
        let i = (x as usize).min(Self::ANGLES - 2);
        interpolate::lerp(self.log_p[table][i], self.log_p[table][i + 1], x - i as f64)
    }

    /// The phase function of one of its wavelengths, sr⁻¹.
    pub(crate) fn one(&self, table: usize, cos_theta: f64) -> f64 {
        self.log_one(table, cos_theta).exp()
    }

    fn at(&self, cos_theta: f64, wavelength_nm: f64) -> f64 {
        let (i, t) = self.locate(wavelength_nm);
        if t == 0.0 {
            return self.one(i, cos_theta);
        }
        interpolate::lerp(self.one(i, cos_theta), self.one(i + 1, cos_theta), t)
    }
}

/// Calls `f` with cos θ and the solid angle (sr) of each node of a Gauss–Legendre rule over the sphere, in pieces that
/// crowd towards the forward peak.
fn for_each_node(mut f: impl FnMut(f64, f64)) {
    let rule = gauss_legendre_unit(16);
    // θ = π s²; 48 pieces in s resolve a peak of 0.1°.
    for piece in 0..48 {
        for (x, w) in &rule {
            let s = (f64::from(piece) + x) / 48.0;
            let theta = PI * s * s;
            f(theta.cos(), 2.0 * PI * w / 48.0 * 2.0 * PI * s * theta.sin());
        }
    }
}

/// ∫ f(cos θ) dω.
fn integrate(f: impl Fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for_each_node(|cos_theta, weight| sum += weight * f(cos_theta));
    sum
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

/// p(θ) = (1 + α cos²θ) / (1 + α (1 + 2g²)/3) · Henyey–Greenstein   [draine2003, eq. 4]
///
/// Laws tested: integrates to 1; α = 0 is Henyey–Greenstein, α = 1 Cornette–Shanks;
/// mean cosine g (1 + α (3 + 2g²)/5) / (1 + α (1 + 2g²)/3).
pub fn draine_phase(cos_theta: f64, g: f64, alpha: f64) -> f64 {
    (1.0 + alpha * cos_theta * cos_theta) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0)
        * henyey_greenstein_phase(cos_theta, g)
}

/// Cornette and Shanks' parameter g of thesis C's haze parameter u, which is the mean cosine of the phase function:
/// the root of g³ − 5/3 u g² + 4g − 10/3 u = 0   [collienne2013, eq. 3.6–3.7]
///
/// `u`: 0.7 (hazy) to 0.85 (dusty) for the Earth; any −1..1.
/// Laws tested: u is the mean cosine; u = 0.8436 is g = 0.8; odd.
pub fn cornette_shanks_g_of_haze(u: f64) -> f64 {
    if u < 0.0 {
        return -cornette_shanks_g_of_haze(-u);
    }
    let squared = u * u;
    let k = 5.0 / 9.0 * u
        + 125.0 / 729.0 * squared * u
        + (64.0 / 27.0 - 325.0 / 243.0 * squared + 1250.0 / 2187.0 * squared * squared).max(0.0).sqrt();
    5.0 / 9.0 * u - (4.0 / 3.0 - 25.0 / 81.0 * squared) / k.cbrt() + k.cbrt()
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
            Self::Draine { g, alpha } => draine_phase(cos_theta, g.at(wavelength_nm), *alpha),
            Self::Tabulated(table) => table.at(cos_theta, wavelength_nm),
        }
    }

    /// Legendre moments χ_l = ∫ p P_l dω, l = 0 … `count` − 1, by quadrature. 768 nodes: to 1e-9 for g = 0.8 and l < 24 (tested).
    pub fn legendre_moments(&self, count: usize, wavelength_nm: f64) -> Vec<f64> {
        let mut moments = vec![0.0; count];
        for_each_node(|cos_theta, weight| {
            let value = weight * self.at(cos_theta, wavelength_nm);
            for_each_legendre(cos_theta, count, |l, p| moments[l] += value * p);
        });
        moments
    }

    /// Mean cosine of the scattering angle.
    pub fn mean_cosine(&self, wavelength_nm: f64) -> f64 {
        integrate(|cos_theta| cos_theta * self.at(cos_theta, wavelength_nm))
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
        for (g, alpha) in [(0.5, 0.0), (0.8, 0.3), (0.8, 1.0), (-0.3, 0.7)] {
            let (sum, mean) = moments(&Phase::Draine { g: Spectrum::Constant(g), alpha });
            let stated = g * (1.0 + alpha * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0);
            assert!((sum - 1.0).abs() < 1e-10 && (mean - stated).abs() < 1e-10, "Draine {g}: {sum} {mean}");
        }
        assert!((draine_phase(0.3, 0.8, 1.0) / cornette_shanks_phase(0.3, 0.8) - 1.0).abs() < 1e-14);
        assert!((rayleigh_phase(0.5, 0.0) - 3.0 / (16.0 * PI) * 1.25).abs() < 1e-15);
    }

    /// Henyey–Greenstein has χ_l = g^l; depolarised Rayleigh χ₂ = (1 − γ)/(10 (1 + 2γ)) and nothing else.
    #[test]
    fn moments_are_the_closed_ones() {
        let moments = Phase::HenyeyGreenstein { g: Spectrum::Constant(0.8) }.legendre_moments(24, 550.0);
        for (l, moment) in moments.iter().enumerate() {
            assert!((moment - 0.8f64.powi(l as i32)).abs() < 1e-9, "{l}: {moment}");
        }
        let gamma = 0.0143;
        let moments = Phase::Rayleigh { gamma }.legendre_moments(5, 550.0);
        for (moment, stated) in moments.iter().zip([1.0, 0.0, (1.0 - gamma) / (10.0 * (1.0 + 2.0 * gamma)), 0.0, 0.0]) {
            assert!((moment - stated).abs() < 1e-9, "{moment} {stated}");
        }
    }

    #[test]
    fn the_haze_parameter_is_the_mean_cosine() {
        for u in [-0.6, 0.0, 0.3, 0.7, 0.8436, 0.85, 0.99] {
            let g = cornette_shanks_g_of_haze(u);
            assert!((3.0 * g * (4.0 + g * g) / (5.0 * (2.0 + g * g)) - u).abs() < 1e-12, "{u}: {g}");
        }
        assert!((cornette_shanks_g_of_haze(0.8436) - 0.8).abs() < 1e-4);
    }

    #[test]
    fn a_table_repeats_what_it_was_made_of() {
        let cosines = Tabulated::cosines();
        let (low, high) = (0.6, 0.85);
        let values = [low, high].map(|g| cosines.iter().map(|&c| henyey_greenstein_phase(c, g)).collect());
        let table = Phase::Tabulated(Tabulated::new(vec![400.0, 700.0], values.to_vec()).unwrap());
        for (nm, g) in [(300.0, low), (400.0, low), (700.0, high), (900.0, high)] {
            for degrees in [0.1f64, 3.0, 40.0, 90.0, 177.0] {
                let cosine = degrees.to_radians().cos();
                assert!(
                    (table.at(cosine, nm) / henyey_greenstein_phase(cosine, g) - 1.0).abs() < 2e-3,
                    "{nm} {degrees}"
                );
            }
            assert!((table.mean_cosine(nm) - g).abs() < 1e-4);
        }
        assert!((table.legendre_moments(1, 400.0)[0] - 1.0).abs() < 1e-12);
        assert!(Tabulated::new(vec![], vec![]).is_err() && Tabulated::new(vec![500.0], vec![vec![1.0; 3]]).is_err());
        assert!(Tabulated::new(vec![500.0], vec![vec![f64::NAN; Tabulated::ANGLES]]).is_err());
    }
}
