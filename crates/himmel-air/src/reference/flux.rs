//! Light that falls on a level surface.

use std::f64::consts::PI;

use glam::DVec3;

use super::first::{first_order, transmittance_to};
use super::flight::Flight;
use super::lobe::around;
use super::path::Walker;
use super::random::Random;
use super::source::Source;
use super::tracer::{BATCHES, Effort, Estimate, Tracer, estimate};
use crate::error::AirError;
use crate::phase::henyey_greenstein_phase;

/// From which side light falls on a level surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From above: the sky on the ground.
    Above,
    /// From below: ground and air on the belly of an aeroplane.
    Below,
}

/// Paths that share a line of sight: its first order costs as much as some ten of them.
const PATHS_PER_LINE: u64 = 8;
/// Shares of lines that are drawn by the cosine, evenly over the hemisphere (which finds the bright horizon of twilight),
/// and about the first source (the aureole).
const BY_COSINE: f64 = 0.5;
const EVENLY: f64 = 0.25;
/// Henyey–Greenstein g of the lines about the source.
const AUREOLE_G: f64 = 0.8;

impl<const N: usize> Tracer<N> {
    /// Irradiance of a level surface at an altitude by scattered light and light from the ground: everything but the
    /// sources themselves, for which there is [`direct_irradiance`](Self::direct_irradiance). Paths are counted as samples.
    pub fn irradiance(
        &self,
        sources: &[Source<N>],
        altitude_m: f64,
        side: Side,
        effort: &Effort,
        question: u64,
    ) -> Result<Estimate<N>, AirError> {
        sources.iter().try_for_each(Source::check)?;
        effort.check()?;
        self.sight(altitude_m, DVec3::Z)?;
        let zenith = if side == Side::Above { DVec3::Z } else { DVec3::NEG_Z };
        let mut walker = Walker::new(self);
        let mut flight = Flight::new(&self.optics);
        let mut streams: Vec<Random> = (0..BATCHES).map(|b| Random::new(effort.seed, question, b as u64)).collect();
        let aims: Vec<DVec3> = sources.iter().map(|source| source.direction).collect();
        let aimed = if aims.is_empty() { 0.0 } else { 1.0 - BY_COSINE - EVENLY };
        let mut failure = Ok(());
        let answer = estimate(effort, [0.0; N], |batch, count, sums| {
            let random = &mut streams[batch];
            walker.orders = *sums.orders;
            let mut left = count;
            while left > 0 {
                let paths = left.min(PATHS_PER_LINE);
                left -= paths;
                let u = random.unit();
                let direction = if u < aimed {
                    let ratio = (1.0 - AUREOLE_G * AUREOLE_G) / (1.0 - AUREOLE_G + 2.0 * AUREOLE_G * random.unit());
                    let cosine = (1.0 + AUREOLE_G * AUREOLE_G - ratio * ratio) / (2.0 * AUREOLE_G);
                    let which = (random.unit() * aims.len() as f64) as usize;
                    around(aims[which.min(aims.len() - 1)], cosine.clamp(-1.0, 1.0), random)
                } else if u < aimed + EVENLY {
                    around(zenith, random.unit(), random)
                } else {
                    around(zenith, random.unit().sqrt(), random)
                };
                let cosine = zenith.dot(direction);
                if cosine <= 0.0 {
                    continue;
                }
                let about: f64 = aims.iter().map(|aim| henyey_greenstein_phase(aim.dot(direction), AUREOLE_G)).sum();
                let about = if aims.is_empty() { 0.0 } else { aimed * about / aims.len() as f64 };
                let chance = about + EVENLY / (2.0 * PI) + (1.0 - aimed - EVENLY) * cosine / PI;
                let line = match self.sight(altitude_m, direction) {
                    Ok(Some(line)) => line,
                    Ok(None) => continue,
                    Err(error) => {
                        failure = Err(error);
                        break;
                    }
                };
                let factor = cosine / chance;
                let albedo_at = |place| self.albedo_at(place);
                let first = first_order(&self.optics, &line, sources, &albedo_at, &mut walker.scratch).radiance;
                for k in 0..N {
                    walker.orders[0][k] += first[k] * factor * paths as f64;
                }
                flight.prepare(&self.optics, &self.importance, &line, sources, &self.weight, true);
                if flight.expected > 0.0 {
                    for i in 0..paths {
                        let u = (i as f64 + random.unit()) / paths as f64;
                        walker.walk(self, &line, &flight, sources, (u, factor), random);
                    }
                }
            }
            *sums.orders = walker.orders;
        })?;
        failure.map(|()| answer)
    }

    /// Irradiance of a surface that faces `normal` by the sources themselves, through the air; the part of each disc that
    /// is above the horizon counts.
    pub fn direct_irradiance(
        &self,
        sources: &[Source<N>],
        altitude_m: f64,
        normal: DVec3,
    ) -> Result<[f64; N], AirError> {
        sources.iter().try_for_each(Source::check)?;
        let mut scratch = super::first::Scratch::new(&self.optics);
        let mut sum = [0.0; N];
        for source in sources {
            for (direction, weight) in source.points() {
                let through = match self.sight(altitude_m, direction)? {
                    Some(line) => transmittance_to(&self.optics, line.origin, direction, &mut scratch),
                    // The line misses the air, or the planet hides nothing above it.
                    None => [1.0; N],
                };
                for k in 0..N {
                    sum[k] += weight[k] * source.irradiance[k] * through[k] * normal.dot(direction).max(0.0);
                }
            }
        }
        Ok(sum)
    }
}
