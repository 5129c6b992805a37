//! The medium: a planet, its ground and the list of what its air is made of.

use himmel_core::spectrum::Spectrum;

use crate::phase::Phase;
use crate::profile::Profile;

/// One constituent of the air.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// What it is.
    pub name: String,
    /// How it is spread over altitude.
    pub profile: Profile,
    /// Scattering coefficient where the profile is 1, m⁻¹.
    pub scattering_per_m: Spectrum,
    /// Absorption coefficient where the profile is 1, m⁻¹.
    pub absorption_per_m: Spectrum,
    /// n − 1 where the profile is 1: how it bends light; 0 where nobody said.
    pub refractivity: Spectrum,
    /// Where its scattered light goes; `None` for pure absorbers.
    pub phase: Option<Phase>,
    /// Factor on its amount.
    pub amount: f64,
}

/// What a component is to the settings `air.molecules`, `air.aerosols` and `air.absorbers`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Scatters by the Rayleigh phase function.
    Molecules,
    /// Scatters by another phase function.
    Aerosols,
    /// Only absorbs.
    Absorbers,
}

impl Component {
    /// Its class.
    pub fn class(&self) -> Class {
        match self.phase {
            Some(Phase::Rayleigh { .. }) => Class::Molecules,
            Some(_) => Class::Aerosols,
            None => Class::Absorbers,
        }
    }
}

/// A planet's air and ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Radius of the ground, m.
    pub bottom_radius_m: f64,
    /// Altitude above which there is nothing, m.
    pub top_altitude_m: f64,
    /// What the air is made of.
    pub components: Vec<Component>,
    /// Lambertian albedo of the ground, 0..=1.
    pub ground_albedo: Spectrum,
}

/// A component at N wavelengths.
#[derive(Clone, Debug)]
pub struct SampledComponent<const N: usize> {
    /// Scattering coefficient where the profile is 1, m⁻¹.
    pub scattering_per_m: [f64; N],
    /// Extinction coefficient where the profile is 1, m⁻¹.
    pub extinction_per_m: [f64; N],
}

/// A medium at N wavelengths.
#[derive(Clone, Debug)]
pub struct Sampled<'a, const N: usize> {
    /// Where the numbers came from.
    pub medium: &'a Medium,
    /// The wavelengths, nm.
    pub wavelengths_nm: [f64; N],
    /// One for each component of the medium, in its order.
    pub components: Vec<SampledComponent<N>>,
    /// Ground albedo.
    pub ground_albedo: [f64; N],
}

impl Medium {
    /// The medium at N wavelengths in nm.
    pub fn sampled<const N: usize>(&self, wavelengths_nm: &[f64; N]) -> Sampled<'_, N> {
        let components = self.components.iter().map(|component| {
            let scattering_per_m = component.scattering_per_m.sample(wavelengths_nm).map(|s| s * component.amount);
            let absorption = component.absorption_per_m.sample(wavelengths_nm).map(|a| a * component.amount);
            let extinction_per_m = std::array::from_fn(|i| scattering_per_m[i] + absorption[i]);
            SampledComponent { scattering_per_m, extinction_per_m }
        });
        Sampled {
            medium: self,
            wavelengths_nm: *wavelengths_nm,
            components: components.collect(),
            ground_albedo: self.ground_albedo.sample(wavelengths_nm),
        }
    }

    /// The lowest altitude, in steps of 1 km, above which the vertical optical depth at 400 nm is below 1e-6.
    pub fn natural_top_m(components: &[Component]) -> f64 {
        const CEILING_M: f64 = 2_000_000.0;
        let depth_above = |altitude_m: f64| -> f64 {
            let per_m = |c: &Component| (c.scattering_per_m.at(400.0) + c.absorption_per_m.at(400.0)) * c.amount;
            components.iter().map(|c| per_m(c) * c.profile.column_m(altitude_m, CEILING_M)).sum()
        };
        let (mut below, mut above) = (0, 2000);
        while above - below > 1 {
            let middle = (below + above) / 2;
            if depth_above(f64::from(middle) * 1e3) < 1e-6 { above = middle } else { below = middle }
        }
        f64::from(above) * 1e3
    }
}

impl<const N: usize> Sampled<'_, N> {
    /// Extinction coefficient at an altitude, m⁻¹.
    pub fn extinction_per_m(&self, altitude_m: f64) -> [f64; N] {
        let mut sum = [0.0; N];
        for (component, sampled) in self.medium.components.iter().zip(&self.components) {
            let density = component.profile.at(altitude_m);
            for i in 0..N {
                sum[i] += density * sampled.extinction_per_m[i];
            }
        }
        sum
    }

    /// The phase functions of all components at one scattering angle, sr⁻¹; zero for absorbers.
    pub fn phases(&self, cos_theta: f64) -> Vec<[f64; N]> {
        let at = |phase: &Option<Phase>| match phase {
            Some(phase) => self.wavelengths_nm.map(|wavelength_nm| phase.at(cos_theta, wavelength_nm)),
            None => [0.0; N],
        };
        self.medium.components.iter().map(|component| at(&component.phase)).collect()
    }
}
