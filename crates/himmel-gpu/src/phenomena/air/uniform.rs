//! The medium as shaders read it.

use himmel_air::moments::Prepared;
use himmel_air::{Atmosphere, Medium};

use crate::error::GpuError;
use crate::layout::gpu_struct;

/// Distinct profiles that one air may have.
pub const MOST_SPECIES: usize = 16;
/// Aerosols that one air may have.
pub const MOST_AEROSOLS: usize = 4;
/// Bodies with air in one scene.
pub const MOST_BODIES: usize = 4;

gpu_struct! {
    /// All components with one profile; the fields are explained in `medium.wgsl`.
    pub struct Species {
        /// Extinction, 1/m.
        pub extinction: [f32; 4],
        /// Scattering into forward peaks.
        pub peak: [f32; 4],
        /// σ_s′ of the scaled medium.
        pub scaled_0: [f32; 4],
        /// σ_s′ χ₁′.
        pub scaled_1: [f32; 4],
        /// σ_s′ χ₂′.
        pub scaled_2: [f32; 4],
        /// σ_R.
        pub molecules_0: [f32; 4],
        /// σ_R χ₂.
        pub molecules_2: [f32; 4],
        /// Peak at the reference, three zeros.
        pub reference: [f32; 4],
    }
}

gpu_struct! {
    /// An aerosol; the fields are explained in `medium.wgsl`.
    pub struct Aerosol {
        /// Scattering, 1/m.
        pub scattering: [f32; 4],
        /// (1 − f) σ_M.
        pub smooth_0: [f32; 4],
        /// (1 − f) σ_M χ₁′.
        pub smooth_1: [f32; 4],
        /// (1 − f) σ_M χ₂′.
        pub smooth_2: [f32; 4],
        /// Its species.
        pub species: u32,
        /// Layer of the peak table.
        pub layer: u32,
        /// Fills up.
        pub padding_0: u32,
        /// Fills up.
        pub padding_1: u32,
    }
}

gpu_struct! {
    /// The air of a body; the fields are explained in `medium.wgsl`.
    pub struct AirUniform {
        /// Its profiles.
        pub species: [Species; MOST_SPECIES],
        /// Its aerosols.
        pub aerosols: [Aerosol; MOST_AEROSOLS],
        /// Ground albedo at the four wavelengths.
        pub ground_albedo: [f32; 4],
        /// Depth of the peaks relative to the reference.
        pub peak_ratio: [f32; 4],
        /// Radius of the ground, m.
        pub bottom_radius_m: f32,
        /// Altitude of the top of the air, m.
        pub top_altitude_m: f32,
        /// Fills up.
        pub padding_0: f32,
        /// Profiles in use.
        pub species_count: u32,
        /// Aerosols in use.
        pub aerosol_count: u32,
        /// Fills up.
        pub padding_1: u32,
        /// Fills up.
        pub padding_2: u32,
        /// Fills up.
        pub padding_3: u32,
    }
}

fn narrow(values: [f64; 4]) -> [f32; 4] {
    values.map(|value| value as f32)
}

impl AirUniform {
    /// `first_layer`: of the peak table, where this body's aerosols begin.
    pub(crate) fn new(atmosphere: &Atmosphere, prepared: &Prepared, first_layer: usize) -> Result<Self, GpuError> {
        let limit = |what, got, most| match got > most {
            true => Err(GpuError::Air(format!("has {got} {what}; the renderer takes at most {most}: merge some"))),
            false => Ok(()),
        };
        limit("density profiles", prepared.species.len(), MOST_SPECIES)?;
        limit("aerosols", prepared.aerosols.len(), MOST_AEROSOLS)?;
        let medium: &Medium = atmosphere.medium();
        let mut air = Self {
            ground_albedo: narrow(atmosphere.sampled().ground_albedo),
            peak_ratio: narrow(prepared.peak_ratio),
            bottom_radius_m: medium.bottom_radius_m as f32,
            top_altitude_m: medium.top_altitude_m as f32,
            species_count: prepared.species.len() as u32,
            aerosol_count: prepared.aerosols.len() as u32,
            ..Self::default()
        };
        for ((slot, species), reference) in
            air.species.iter_mut().zip(&prepared.species).zip(&prepared.peak_reference_per_m)
        {
            *slot = Species {
                extinction: narrow(species.extinction_per_m),
                peak: narrow(species.peak_per_m),
                scaled_0: narrow(species.scaled_per_m[0]),
                scaled_1: narrow(species.scaled_per_m[1]),
                scaled_2: narrow(species.scaled_per_m[2]),
                molecules_0: narrow(species.molecules_per_m[0]),
                molecules_2: narrow(species.molecules_per_m[1]),
                reference: [*reference as f32, 0.0, 0.0, 0.0],
            };
        }
        for (index, (slot, aerosol)) in air.aerosols.iter_mut().zip(&prepared.aerosols).enumerate() {
            *slot = Aerosol {
                scattering: narrow(aerosol.scattering_per_m),
                smooth_0: narrow(aerosol.smooth_per_m[0]),
                smooth_1: narrow(aerosol.smooth_per_m[1]),
                smooth_2: narrow(aerosol.smooth_per_m[2]),
                species: aerosol.species as u32,
                layer: (first_layer + index) as u32,
                ..Aerosol::default()
            };
        }
        Ok(air)
    }
}
