//! The medium at N wavelengths, prepared for many evaluations.

use crate::error::AirError;
use crate::medium::Sampled;
use crate::profile::Profile;

use super::lobe::Lobe;

/// What the tracer needs to know of air and ground, copied out of a [`Sampled`] medium.
pub(super) struct Optics<const N: usize> {
    /// Radius of the ground, m.
    pub radius_m: f64,
    /// Altitude above which there is nothing, m.
    pub top_m: f64,
    /// Lambertian albedo of the ground.
    pub albedo: [f64; N],
    /// What the air is made of: only what scatters or absorbs at all.
    pub components: Vec<Constituent<N>>,
    /// Altitudes strictly within the air at which some density has a kink, a jump or a narrow layer, ascending, m.
    pub kinks_m: Vec<f64>,
    /// The shortest length over which a density changes, m: sets the cells of every quadrature.
    pub scale_m: f64,
}

/// One component at N wavelengths.
pub(super) struct Constituent<const N: usize> {
    profile: Density,
    /// Scattering coefficient where the profile is 1, m⁻¹.
    pub scattering_per_m: [f64; N],
    /// Extinction coefficient where the profile is 1, m⁻¹.
    pub extinction_per_m: [f64; N],
    /// Where its scattered light goes; `None` for what only absorbs.
    pub lobe: Option<Lobe<N>>,
}

/// A profile in the form that is quickest to evaluate; same values as [`Profile::at`].
enum Density {
    Exponential {
        per_m: f64,
    },
    /// Logarithms at the nodes, with an index that is even in altitude: no search.
    LogTable {
        altitude_m: Vec<f64>,
        log: Vec<f64>,
        first: Vec<u32>,
        cells_per_m: f64,
    },
    Other(Profile),
}

/// Even cells of the index into a table; a cell that holds several nodes is searched on.
const INDEX_CELLS: usize = 256;

impl Density {
    fn new(profile: &Profile) -> Self {
        match profile {
            Profile::Exponential { scale_height_m } => Self::Exponential { per_m: -1.0 / scale_height_m },
            Profile::LogTable { altitude_m, value }
                if altitude_m.len() == value.len()
                    && altitude_m.len() > 1
                    && value.iter().all(|v| *v > 0.0)
                    && altitude_m.last() > Some(&0.0) =>
            {
                let top = altitude_m[altitude_m.len() - 1];
                let first = (0..=INDEX_CELLS)
                    .map(|cell| {
                        let from = top * cell as f64 / INDEX_CELLS as f64;
                        altitude_m.partition_point(|&node| node <= from).clamp(1, altitude_m.len() - 1) as u32 - 1
                    })
                    .collect();
                Self::LogTable {
                    altitude_m: altitude_m.clone(),
                    log: value.iter().map(|v| v.ln()).collect(),
                    first,
                    cells_per_m: INDEX_CELLS as f64 / top,
                }
            }
            other => Self::Other(other.clone()),
        }
    }

    fn at(&self, altitude_m: f64) -> f64 {
        match self {
            Self::Exponential { per_m } => (altitude_m * per_m).exp(),
            Self::LogTable { altitude_m: nodes, log, first, cells_per_m } => {
                let last = nodes.len() - 1;
                if altitude_m > nodes[last] {
                    return 0.0;
                }
                let cell = ((altitude_m * cells_per_m).max(0.0) as usize).min(INDEX_CELLS);
                let mut i = first[cell] as usize;
                while i + 1 < last && nodes[i + 1] <= altitude_m {
                    i += 1;
                }
                let t = ((altitude_m - nodes[i]) / (nodes[i + 1] - nodes[i])).clamp(0.0, 1.0);
                (log[i] + t * (log[i + 1] - log[i])).exp()
            }
            Self::Other(profile) => profile.at(altitude_m),
        }
    }
}

/// Altitudes that quadratures must not step over, and the shortest scale.
fn landmarks(profile: &Profile, kinks_m: &mut Vec<f64>, scale_m: &mut f64) {
    let mut layer = |centre: f64, width: f64| {
        // Five marks resolve a bell: between them it is a gentle curve.
        kinks_m.extend([-3.0, -1.5, 0.0, 1.5, 3.0].map(|k| centre + k * width));
    };
    // Nothing holds above the last node: a jump, held between two marks 2 cm apart.
    let jump = |altitude_m: &[f64], kinks_m: &mut Vec<f64>| {
        kinks_m.extend(altitude_m.last().into_iter().flat_map(|last| [last - 0.01, last + 0.01]));
    };
    match profile {
        Profile::Exponential { scale_height_m } => *scale_m = scale_m.min(*scale_height_m),
        Profile::Gaussian { centre_m, width_m } => layer(*centre_m, *width_m),
        Profile::Tent { bottom_m, peak_m, top_m } => kinks_m.extend([*bottom_m, *peak_m, *top_m]),
        Profile::Table { altitude_m, .. } => {
            kinks_m.extend(altitude_m);
            jump(altitude_m, kinks_m);
        }
        Profile::LogTable { altitude_m, .. } => {
            // The logarithm's slope changes little from node to node of a fine table: every fourth is mark enough (the
            // transmittance then errs by less than 1e-5 of the optical depth: `transmittance_is_exact`).
            let step = if altitude_m.len() > 8 { 4 } else { 1 };
            kinks_m.extend(altitude_m.iter().step_by(step));
            jump(altitude_m, kinks_m);
        }
        Profile::Sum(parts) => parts.iter().for_each(|(_, part)| landmarks(part, kinks_m, scale_m)),
        Profile::Layered { scale_height_m, layers } => {
            *scale_m = scale_m.min(*scale_height_m);
            layers.iter().for_each(|[centre, width, _]| layer(*centre, *width));
        }
    }
}

impl<const N: usize> Optics<N> {
    /// Fails where a coefficient, an albedo or a length is no finite, non-negative number.
    pub fn new(air: &Sampled<'_, N>) -> Result<Self, AirError> {
        let medium = air.medium;
        let lengths = [("radius of the planet", medium.bottom_radius_m), ("top of the air", medium.top_altitude_m)];
        for (what, length) in lengths {
            if !(length.is_finite() && length > 0.0) {
                return Err(AirError::Optics { what: what.into(), law: "be a positive length in metres", got: length });
            }
        }
        for albedo in air.ground_albedo {
            if !(0.0..=1.0).contains(&albedo) {
                return Err(AirError::Optics { what: "ground albedo".into(), law: "lie in 0..=1", got: albedo });
            }
        }
        let mut components = Vec::new();
        let (mut kinks_m, mut scale_m) = (Vec::new(), medium.top_altitude_m);
        for (component, sampled) in medium.components.iter().zip(&air.components) {
            for (scattering, extinction) in sampled.scattering_per_m.iter().zip(&sampled.extinction_per_m) {
                // 1e30: what is thicker than any star; products stay finite.
                let good = (0.0..=1e30).contains(scattering) && (*scattering..=1e30).contains(extinction);
                if !good {
                    let got = if (0.0..=1e30).contains(scattering) { *extinction } else { *scattering };
                    let what = format!("coefficient of {}", component.name);
                    return Err(AirError::Optics { what, law: "be finite, and extinction at least scattering", got });
                }
            }
            if sampled.extinction_per_m.iter().all(|e| *e == 0.0) {
                continue;
            }
            let phase = component.phase.as_ref().filter(|_| sampled.scattering_per_m.iter().any(|s| *s > 0.0));
            let lobe = phase.map(|phase| Lobe::new(phase, &air.wavelengths_nm));
            landmarks(&component.profile, &mut kinks_m, &mut scale_m);
            components.push(Constituent {
                profile: Density::new(&component.profile),
                scattering_per_m: if lobe.is_some() { sampled.scattering_per_m } else { [0.0; N] },
                extinction_per_m: sampled.extinction_per_m,
                lobe,
            });
        }
        kinks_m.retain(|kink| *kink > 1e-3 && *kink < medium.top_altitude_m - 1e-3);
        kinks_m.sort_by(f64::total_cmp);
        kinks_m.dedup_by(|b, a| *b - *a < 1e-3);
        Ok(Self {
            radius_m: medium.bottom_radius_m,
            top_m: medium.top_altitude_m,
            albedo: air.ground_albedo,
            components,
            kinks_m,
            scale_m,
        })
    }

    /// Densities of all components at an altitude, one for each of `densities`.
    pub fn densities(&self, altitude_m: f64, densities: &mut [f64]) {
        for (density, component) in densities.iter_mut().zip(&self.components) {
            *density = component.profile.at(altitude_m);
        }
    }

    /// Optical depths of columns (m) of all components.
    pub fn depth(&self, columns_m: &[f64]) -> [f64; N] {
        let mut depth = [0.0; N];
        for (column, component) in columns_m.iter().zip(&self.components) {
            for k in 0..N {
                depth[k] += column * component.extinction_per_m[k];
            }
        }
        depth
    }

    /// Scattering coefficient of all components at their densities, m⁻¹.
    pub fn scattering(&self, densities: &[f64]) -> [f64; N] {
        let mut sum = [0.0; N];
        for (density, component) in densities.iter().zip(&self.components) {
            for k in 0..N {
                sum[k] += density * component.scattering_per_m[k];
            }
        }
        sum
    }

    /// Σ σ_s p(θ) of all components at their densities, m⁻¹ sr⁻¹.
    pub fn scattered(&self, densities: &[f64], cos_theta: f64) -> [f64; N] {
        let mut sum = [0.0; N];
        for (density, component) in densities.iter().zip(&self.components) {
            let Some(lobe) = &component.lobe else { continue };
            let at = lobe.at(cos_theta);
            for k in 0..N {
                sum[k] += density * component.scattering_per_m[k] * at[k];
            }
        }
        sum
    }
}
