//! The medium as the approximation's shaders read it: two arrays, made when the atmosphere is given.

use std::f64::consts::PI;

use himmel_air::{Atmosphere, Phase};

use crate::error::GpuError;

/// Nodes over √(h / top), and over √(θ / π) of a phase function; `NODES` in `hillaire.wgsl`.
const NODES: usize = 256;
/// Fields of `PhaseValues` in `hillaire.wgsl`.
const MOST_PHASES: usize = 4;

/// Arrays of four wavelengths.
pub(crate) struct Arrays {
    /// Number of different phase functions; at least 1.
    pub(crate) phase_count: usize,
    /// For each altitude: extinction of all components, then scattering of each phase function's components, m⁻¹.
    pub(crate) medium: Vec<[f32; 4]>,
    /// For each phase function: its values over the scattering angle, sr⁻¹.
    pub(crate) phases: Vec<[f32; 4]>,
}

impl Arrays {
    /// Samples an atmosphere. Components with equal phase functions are added up: the Earth has two kinds.
    pub(crate) fn new(atmosphere: &Atmosphere) -> Result<Self, GpuError> {
        let (air, medium) = (atmosphere.sampled(), atmosphere.medium());
        let mut kinds: Vec<&Phase> = Vec::new();
        for phase in medium.components.iter().filter_map(|component| component.phase.as_ref()) {
            if !kinds.contains(&phase) {
                kinds.push(phase);
            }
        }
        if kinds.len() > MOST_PHASES {
            return Err(GpuError::Comparison(format!(
                "it holds {MOST_PHASES} different phase functions, this air has {}",
                kinds.len()
            )));
        }
        let phase_count = kinds.len().max(1);
        let mut arrays = Self { phase_count, medium: Vec::new(), phases: vec![[0.0; 4]; phase_count * NODES] };
        for node in 0..NODES {
            let altitude_m = medium.top_altitude_m * (node as f64 / (NODES - 1) as f64).powi(2);
            let mut scattering = vec![[0.0; 4]; phase_count];
            for (component, sampled) in medium.components.iter().zip(&air.components) {
                let kind = kinds.iter().position(|kind| component.phase.as_ref() == Some(kind));
                let Some(kind) = kind else { continue };
                let density = component.profile.at(altitude_m);
                for k in 0..4 {
                    scattering[kind][k] += density * sampled.scattering_per_m[k];
                }
            }
            arrays.medium.push(narrow(air.extinction_per_m(altitude_m)));
            arrays.medium.extend(scattering.into_iter().map(narrow));
        }
        for (kind, phase) in kinds.iter().enumerate() {
            for node in 0..NODES {
                let cos_theta = (PI * (node as f64 / (NODES - 1) as f64).powi(2)).cos();
                arrays.phases[kind * NODES + node] = narrow(air.wavelengths_nm.map(|nm| phase.at(cos_theta, nm)));
            }
        }
        Ok(arrays)
    }
}

fn narrow(values: [f64; 4]) -> [f32; 4] {
    values.map(|value| value as f32)
}
