//! The medium made smooth: the aerosols' forward peaks taken out of the scattering (delta-M) and put aside.

use crate::medium::{Component, Sampled};
use crate::phase::Phase;

/// Largest share of the scattering that may count as forward peak: beyond it the rest would be divided by nothing.
const LARGEST_PEAK: f64 = 0.999;

/// A component at N wavelengths as the moments need it. Coefficients hold where the profile is 1.
#[derive(Clone, Debug)]
pub(super) struct Scatterer<const N: usize> {
    /// Extinction σ_t, m⁻¹.
    pub extinction_per_m: [f64; N],
    /// Scattering σ_s, m⁻¹; 0 without a phase function.
    pub scattering_per_m: [f64; N],
    /// Scattering into the forward peak, f σ_s, m⁻¹.
    pub peak_per_m: [f64; N],
    /// χ₁ and χ₂ of the phase function.
    pub chi: [[f64; N]; 2],
    /// (χ₁ − f) / (1 − f) and (χ₂ − f) / (1 − f).
    pub scaled_chi: [[f64; N]; 2],
    /// Moments of (p − (1 − f) p′): what the polynomial p′ leaves, l = 0, 1, …; empty for molecules, which leave
    /// nothing.
    pub rest: Vec<[f64; N]>,
    /// All χ_l, in the same order; empty for molecules.
    pub all_chi: Vec<[f64; N]>,
}

impl<const N: usize> Scatterer<N> {
    /// Delta-M [wiscombe1977]: f = χ₃, χ_l′ = (χ_l − f)/(1 − f), σ_s′ = (1 − f) σ_s, σ_t′ = σ_t − f σ_s.
    ///
    /// Molecules have no moments beyond l = 2 and are left as they are; so are phase functions with χ₃ ≤ 0.
    fn new(component: &Component, air: &Sampled<'_, N>, index: usize, terms: usize) -> Self {
        let sampled = &air.components[index];
        let none = [0.0; N];
        let mut scatterer = Self {
            extinction_per_m: sampled.extinction_per_m,
            scattering_per_m: none,
            peak_per_m: none,
            chi: [none; 2],
            scaled_chi: [none; 2],
            rest: Vec::new(),
            all_chi: Vec::new(),
        };
        let Some(phase) = &component.phase else { return scatterer };
        scatterer.scattering_per_m = sampled.scattering_per_m;
        if let Phase::Rayleigh { gamma } = phase {
            scatterer.chi[1] = [(1.0 - gamma) / (10.0 * (1.0 + 2.0 * gamma)); N];
            scatterer.scaled_chi = scatterer.chi;
            return scatterer;
        }
        let terms = terms.max(4);
        scatterer.all_chi = vec![none; terms];
        scatterer.rest = vec![none; terms];
        for k in 0..N {
            let chi = phase.legendre_moments(terms, air.wavelengths_nm[k]);
            let f = chi[3].clamp(0.0, LARGEST_PEAK);
            scatterer.peak_per_m[k] = f * sampled.scattering_per_m[k];
            for l in 0..2 {
                scatterer.chi[l][k] = chi[l + 1];
                scatterer.scaled_chi[l][k] = (chi[l + 1] - f) / (1.0 - f);
            }
            for l in 0..terms {
                scatterer.all_chi[l][k] = chi[l];
                scatterer.rest[l][k] = if l < 3 { f } else { chi[l] };
            }
        }
        scatterer
    }

    /// Whether it has (or could have) a forward peak: everything that scatters but molecules.
    pub fn is_aerosol(&self) -> bool {
        !self.rest.is_empty()
    }
}

/// All components, in the medium's order.
#[derive(Clone, Debug)]
pub(super) struct Optics<const N: usize> {
    pub scatterers: Vec<Scatterer<N>>,
    /// Whether any component is an aerosol of some amount.
    pub aerosols: bool,
}

/// What a point of the air does to light, all components together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local<const N: usize> {
    /// Extinction of the scaled medium, m⁻¹.
    pub scaled_extinction_per_m: [f64; N],
    /// Σ σ_s′, Σ σ_s′ χ₁′, Σ σ_s′ χ₂′, m⁻¹: what turns G, F and Q into scattered light.
    pub scaled: [[f64; N]; 3],
}

impl<const N: usize> Optics<N> {
    /// From a sampled medium; `terms`: moments of each aerosol's phase function.
    pub fn new(air: &Sampled<'_, N>, terms: usize) -> Self {
        let scatterers: Vec<_> = air
            .medium
            .components
            .iter()
            .take(air.components.len())
            .enumerate()
            .map(|(index, component)| Scatterer::new(component, air, index, terms))
            .collect();
        let aerosols = scatterers.iter().any(|s| s.is_aerosol() && s.scattering_per_m.iter().any(|&s| s > 0.0));
        Self { scatterers, aerosols }
    }

    /// The scaled medium at an altitude.
    pub fn local(&self, components: &[Component], altitude_m: f64) -> Local<N> {
        let mut local = Local { scaled_extinction_per_m: [0.0; N], scaled: [[0.0; N]; 3] };
        for (component, s) in components.iter().zip(&self.scatterers) {
            let density = component.profile.at(altitude_m);
            for k in 0..N {
                let scattering = density * (s.scattering_per_m[k] - s.peak_per_m[k]);
                local.scaled_extinction_per_m[k] += density * (s.extinction_per_m[k] - s.peak_per_m[k]);
                local.scaled[0][k] += scattering;
                local.scaled[1][k] += scattering * s.scaled_chi[0][k];
                local.scaled[2][k] += scattering * s.scaled_chi[1][k];
            }
        }
        local
    }
}
