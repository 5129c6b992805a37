//! A second estimator, built unlike the first: photons followed forwards from the Sun, by null collisions, counted where
//! they fall. It shares the medium and the phase functions with the tracer, and neither its quadratures nor its chances.
//!
//! It answers few questions (irradiance of the ground by scattered light, reflection, absorption) and those slowly: it is
//! here to check the tracer, above all in twilight, where a path must find the lit air far away.

use std::f64::consts::PI;

use glam::DVec3;

use super::lobe::around;
use super::optics::Optics;
use super::random::Random;
use super::tracer::{BATCHES, Estimate, Tracer};

/// Shells of the envelope of the extinction.
const SHELLS: usize = 512;
/// Share of photons that start at the planet's rim, where twilight is made.
const AT_THE_RIM: f64 = 0.7;
/// The rim reaches this many times the air's height inwards.
const RIM_DEPTH: f64 = 2.0;
/// A photon of less weight lives on by chance.
const FAINT: f64 = 0.05;

/// What became of photons that fell on a planet in a parallel beam of unit irradiance.
pub struct Photons {
    /// Irradiance of the ground by scattered light in each band of the Sun's zenith cosine, per unit irradiance.
    pub scattered: Vec<Estimate<1>>,
    /// Power that arrived, that left again, that air and ground absorbed: per area π (R + top)² of the beam.
    pub arrived: f64,
    /// See `arrived`.
    pub left: f64,
    /// See `arrived`.
    pub absorbed_by_air: f64,
    /// See `arrived`.
    pub absorbed_by_ground: f64,
}

/// Largest extinction at and above each altitude.
struct Envelope {
    above: Vec<f64>,
    top_m: f64,
}

impl Envelope {
    fn new(optics: &Optics<1>) -> Self {
        let mut densities = vec![0.0; optics.components.len()];
        let mut extinction = |altitude_m: f64| {
            optics.densities(altitude_m, &mut densities);
            optics.depth(&densities)[0]
        };
        let mut above = vec![0.0; SHELLS + 1];
        let mut largest: f64 = 0.0;
        for shell in (0..SHELLS).rev() {
            let at = |x: f64| optics.top_m * ((shell as f64 + x) / SHELLS as f64).powi(2);
            for i in 0..=16 {
                largest = largest.max(extinction(at(f64::from(i) / 16.0)));
            }
            for kink in optics.kinks_m.iter().filter(|kink| (at(0.0)..=at(1.0)).contains(*kink)) {
                largest = largest.max(extinction(*kink));
            }
            // 1 ‰: what a curve may rise between its samples.
            above[shell] = largest * 1.001;
        }
        Self { above, top_m: optics.top_m }
    }

    fn at_and_above(&self, altitude_m: f64) -> f64 {
        let shell = ((altitude_m / self.top_m).clamp(0.0, 1.0).sqrt() * SHELLS as f64) as usize;
        self.above[shell.min(SHELLS)]
    }
}

impl Tracer<1> {
    /// Follows `count` photons of a parallel beam. `bands`: zenith cosines of the Sun between which the ground's irradiance
    /// is averaged over area, descending (1.0, …, −0.3).
    pub fn forward(&self, bands: &[f64], count: u64, seed: u64) -> Photons {
        let optics = &self.optics;
        let envelope = Envelope::new(optics);
        let top = optics.radius_m + optics.top_m;
        let rim = (optics.radius_m - RIM_DEPTH * optics.top_m).max(0.0);
        let disc = PI * top * top;
        let band_count = bands.len().saturating_sub(1);
        let mut hits = vec![vec![0.0; BATCHES]; band_count];
        let (mut left, mut by_air, mut by_ground) = (0.0, 0.0, 0.0);
        let per_batch = count.div_ceil(BATCHES as u64);
        let total = (per_batch * BATCHES as u64) as f64;
        let mut densities = vec![0.0; optics.components.len()];
        for batch in 0..BATCHES {
            let mut random = Random::new(seed, 0, batch as u64);
            for _ in 0..per_batch {
                // The Sun stands at +z; the photon starts on the sphere's sunny side.
                let inner = if random.unit() < AT_THE_RIM { rim } else { 0.0 };
                let b = (inner * inner + random.unit() * (top * top - inner * inner)).sqrt();
                let density = (1.0 - AT_THE_RIM) / disc
                    + if b >= rim { AT_THE_RIM / (PI * (top * top - rim * rim)) } else { 0.0 };
                let phi = 2.0 * PI * random.unit();
                let mut weight = 1.0 / (density * disc * total);
                let mut point = DVec3::new(b * phi.cos(), b * phi.sin(), (top * top - b * b).max(0.0).sqrt());
                let mut direction = DVec3::NEG_Z;
                let mut scattered = false;
                // Straight flights end at the ground, at the top, or at a collision.
                'life: loop {
                    let Some(ground) = fly(optics, &envelope, &mut point, direction, &mut random, &mut densities)
                    else {
                        left += weight;
                        break 'life;
                    };
                    if ground {
                        let up = point.normalize();
                        if scattered {
                            let band = bands.windows(2).position(|pair| up.z <= pair[0] && up.z > pair[1]);
                            if let Some(band) = band {
                                hits[band][batch] += weight;
                            }
                        }
                        let albedo = self.albedo_at(up)[0];
                        by_ground += weight * (1.0 - albedo);
                        weight *= albedo;
                        if weight <= 0.0 {
                            break 'life;
                        }
                        direction = around(up, random.unit().sqrt(), &mut random);
                        point = up * optics.radius_m;
                    } else {
                        optics.densities((point.length() - optics.radius_m).max(0.0), &mut densities);
                        let (scattering, extinction) = (optics.scattering(&densities)[0], optics.depth(&densities)[0]);
                        by_air += weight * (1.0 - scattering / extinction);
                        weight *= scattering / extinction;
                        let mut u = random.unit() * scattering;
                        let chosen = optics.components.iter().zip(&densities).find(|(component, density)| {
                            u -= component.scattering_per_m[0] * **density;
                            u < 0.0
                        });
                        let Some(lobe) = chosen.and_then(|(component, _)| component.lobe.as_ref()) else {
                            by_air += weight;
                            break 'life;
                        };
                        let cosine = lobe.sample(0, &mut random);
                        direction = around(direction, cosine, &mut random);
                    }
                    scattered = true;
                    // A rim photon starts with less: what counts is what is left of it.
                    let start = 1.0 / (density * disc * total);
                    if weight < FAINT * start {
                        if random.unit() >= 0.5 {
                            // Half of them die, the others carry their light.
                            break 'life;
                        }
                        weight *= 2.0;
                    }
                }
            }
        }
        let scattered = (0..band_count)
            .map(|band| {
                let area = 2.0 * PI * optics.radius_m * optics.radius_m * (bands[band] - bands[band + 1]);
                let batches: Vec<f64> = hits[band].iter().map(|sum| sum * BATCHES as f64 * disc / area).collect();
                let mean = batches.iter().sum::<f64>() / BATCHES as f64;
                let variance = batches.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (BATCHES as f64 - 1.0);
                Estimate {
                    value: [mean],
                    standard_error: [(variance / BATCHES as f64).sqrt()],
                    orders: Vec::new(),
                    samples: per_batch * BATCHES as u64,
                }
            })
            .collect();
        Photons { scattered, arrived: 1.0, left, absorbed_by_air: by_air, absorbed_by_ground: by_ground }
    }
}

/// Moves a photon to its next real collision (`Some(false)`) or to the ground (`Some(true)`); `None`: it left the air.
fn fly(
    optics: &Optics<1>,
    envelope: &Envelope,
    point: &mut DVec3,
    direction: DVec3,
    random: &mut Random,
    densities: &mut [f64],
) -> Option<bool> {
    let (radius, top) = (optics.radius_m, optics.radius_m + optics.top_m);
    loop {
        let r = point.length();
        let along = point.dot(direction);
        let closest = (*point - direction * along).length();
        // Distances to the ground and to the top.
        let ground = (along < 0.0 && closest < radius)
            .then(|| -along - ((radius - closest) * (radius + closest)).sqrt())
            .map(|t| t.max(0.0));
        let exit = -along + ((top - closest) * (top + closest)).max(0.0).sqrt();
        let end = ground.unwrap_or(exit);
        // A stretch over which the envelope changes little: up to half of the altitude change matters.
        let stretch = (0.5 * (r - radius).max(optics.scale_m)).min(end);
        let lowest = if along + stretch < 0.0 {
            (*point + direction * stretch).length()
        } else if along < 0.0 {
            closest
        } else {
            r
        };
        let majorant = envelope.at_and_above((lowest - radius).max(0.0));
        let t = -(1.0 - random.unit()).ln() / majorant.max(1e-300);
        if t >= stretch {
            *point += direction * stretch;
            if stretch >= end {
                return ground.map(|_| true);
            }
            continue;
        }
        *point += direction * t;
        optics.densities((point.length() - radius).max(0.0), densities);
        if random.unit() * majorant < optics.depth(densities)[0] {
            return Some(false);
        }
    }
}
