//! One random path: light followed backwards from the observer, with the Sun looked for at every event after the first.

use std::f64::consts::PI;

use glam::DVec3;

use super::first::{Scratch, transmittance_to};
use super::flight::{Event, Flight, ground_point};
use super::line::{Line, in_shadow};
use super::lobe::around;
use super::random::Random;
use super::source::Source;
use super::tracer::Tracer;
use crate::phase::henyey_greenstein_phase;

/// Orders that are told apart; the last one holds all that follow.
pub const ORDERS: usize = 32;

/// Chance of aiming the next direction at the Sun's aureole instead of along the path's own.
const AIM: f64 = 0.3;
/// Only the first events aim: weights that are even on average wander off as a product of many.
const AIMED_EVENTS: usize = 3;
/// In the planet's shadow: height of the bright arch above the horizon, and the Henyey–Greenstein g of the aim at it.
const ARCH_HEIGHT_RAD: f64 = 0.12;
const ARCH_G: f64 = 0.8;
/// A path that expects less than this share of what its first line of sight did is followed by chance only.
const FAINT: f64 = 0.25;
/// The smallest chance of being followed on: bounds the weight of survivors.
const LEAST_CHANCE: f64 = 0.25;
/// Where a path ends at last. Conservative air of optical depth 1e4 needs some thousands of events.
const MOST_EVENTS: usize = 200_000;

/// Memory of one thread.
pub(super) struct Walker<const N: usize> {
    pub scratch: Scratch,
    flight: Flight<N>,
    densities: Vec<f64>,
    /// Chance of each component and wavelength for the next direction.
    chances: Vec<f64>,
    /// Where the next direction may be aimed at, and whether with the peaks of the phase functions or at the bright arch.
    aims: Vec<(DVec3, bool)>,
    /// Radiance of each order.
    pub orders: [[f64; N]; ORDERS],
}

impl<const N: usize> Walker<N> {
    pub fn new(tracer: &Tracer<N>) -> Self {
        let count = tracer.optics.components.len();
        Self {
            scratch: Scratch::new(&tracer.optics),
            flight: Flight::new(&tracer.optics),
            densities: vec![0.0; count],
            chances: vec![0.0; count * N],
            aims: Vec::new(),
            orders: [[0.0; N]; ORDERS],
        }
    }

    /// Adds orders ≥ 2 of one path to `orders`, times `factor`. `first`, prepared for `line`; `u`: where on it.
    pub fn walk(
        &mut self,
        tracer: &Tracer<N>,
        line: &Line,
        first: &Flight<N>,
        sources: &[Source<N>],
        (u, factor): (f64, f64),
        random: &mut Random,
    ) {
        let optics = &tracer.optics;
        let expected = first.expected;
        let mut line = *line;
        let (mut event, mut carried) = first.draw(optics, &line, u, random, &mut self.densities);
        carried.iter_mut().for_each(|c| *c *= factor);
        for order in 1..MOST_EVENTS {
            let point = match event {
                Event::None => return,
                Event::Air(t) => line.at(t),
                Event::Ground => ground_point(optics, &line),
            };
            let up = point.normalize();
            let albedo = if event == Event::Ground { tracer.albedo_at(up) } else { [0.0; N] };
            if order >= 2 {
                for source in sources {
                    let (direction, brightness) = source.sample(random);
                    let reflected = match event {
                        Event::Ground => albedo.map(|albedo| albedo / PI * up.dot(direction).max(0.0)),
                        _ => optics.scattered(&self.densities, line.direction.dot(direction)),
                    };
                    if reflected.iter().all(|r| *r == 0.0) {
                        continue;
                    }
                    let light = transmittance_to(optics, point, direction, &mut self.scratch);
                    let sum = &mut self.orders[(order - 1).min(ORDERS - 1)];
                    for k in 0..N {
                        sum[k] += carried[k] * reflected[k] * light[k] * brightness[k] * source.irradiance[k];
                    }
                }
            }
            // A path that has little to bring is followed by chance.
            let altitude_m = (point.length() - optics.radius_m).max(0.0);
            let scattering = match event {
                Event::Ground => albedo.map(|albedo| 2.0 * albedo),
                _ => optics.scattering(&self.densities),
            };
            let hope: f64 = (0..N).map(|k| tracer.weight[k] * carried[k] * scattering[k]).sum();
            let light: f64 =
                sources.iter().map(|source| tracer.importance.diffuse(altitude_m, up.dot(source.direction))).sum();
            let share = hope * light / (FAINT * expected * factor);
            if !(share.is_finite() && hope > 0.0) {
                return;
            }
            if share < 1.0 {
                let chance = share.max(LEAST_CHANCE);
                if random.unit() >= chance {
                    return;
                }
                carried.iter_mut().for_each(|c| *c /= chance);
            }
            let aimed = if order <= AIMED_EVENTS { sources } else { &[] };
            let Some(direction) = self.turn(tracer, &line, point, up, event, &albedo, aimed, &mut carried, random)
            else {
                return;
            };
            let origin = if event == Event::Ground { up * optics.radius_m } else { point };
            line = Line::new(optics, origin, direction);
            let weight = std::array::from_fn(|k| tracer.weight[k] * carried[k]);
            self.flight.prepare(optics, &tracer.importance, &line, sources, &weight, false);
            let u = random.unit();
            let factors;
            (event, factors) = self.flight.draw(optics, &line, u, random, &mut self.densities);
            for k in 0..N {
                carried[k] *= factors[k];
            }
        }
    }

    /// Draws the next direction from the scatterers' own phase functions and (`sources`: what to aim at), where there is a forward peak, from peaks
    /// about the lights: the product of two peaks, which makes the noise of haze, is bounded by the sum of their chances.
    #[allow(clippy::too_many_arguments)]
    fn turn(
        &mut self,
        tracer: &Tracer<N>,
        line: &Line,
        point: DVec3,
        up: DVec3,
        event: Event,
        albedo: &[f64; N],
        sources: &[Source<N>],
        carried: &mut [f64; N],
        random: &mut Random,
    ) -> Option<DVec3> {
        let optics = &tracer.optics;
        let (mut all, mut peaked) = (0.0, 0.0);
        for (c, component) in optics.components.iter().enumerate() {
            let aims = component.lobe.as_ref().is_some_and(|lobe| lobe.peaked());
            for k in 0..N {
                let chance = self.densities[c] * component.scattering_per_m[k] * tracer.weight[k] * carried[k];
                self.chances[c * N + k] = chance;
                all += chance;
                peaked += if aims { chance } else { 0.0 };
            }
        }
        self.aims.clear();
        self.aims.extend(sources.iter().filter_map(|source| {
            if in_shadow(optics, point, source.direction) {
                // In the planet's shadow light comes from the bright arch above the place where the source has set.
                let level = (source.direction - up * up.dot(source.direction)).try_normalize()?;
                Some((level * ARCH_HEIGHT_RAD.cos() + up * ARCH_HEIGHT_RAD.sin(), false))
            } else {
                (peaked > 0.0).then_some((source.direction, true))
            }
        }));
        let aims = self.aims.len();
        let aim = if aims > 0 { AIM } else { 0.0 };
        // A component and a wavelength by their chances; `only`: among those with a peak.
        let choose = |only: bool, total: f64, random: &mut Random| {
            let mut left = random.unit() * total;
            let mut found = None;
            for (c, component) in optics.components.iter().enumerate() {
                let Some(lobe) = &component.lobe else { continue };
                if only && !lobe.peaked() {
                    continue;
                }
                for k in 0..N {
                    if self.chances[c * N + k] > 0.0 {
                        found = Some((lobe, k));
                        left -= self.chances[c * N + k];
                        if left < 0.0 {
                            return found;
                        }
                    }
                }
            }
            found
        };
        let direction = if aim > 0.0 && random.unit() < aim {
            let (axis, peak) = *self.aims.get((random.unit() * aims as f64) as usize)?;
            let cosine = match peak {
                true => {
                    let (lobe, k) = choose(true, peaked, random)?;
                    lobe.sample(k, random)
                }
                false => arch_sample(random),
            };
            around(axis, cosine, random)
        } else if event == Event::Ground {
            around(up, random.unit().sqrt(), random)
        } else {
            let (lobe, k) = choose(false, all, random)?;
            around(line.direction, lobe.sample(k, random), random)
        };
        // The mean of the phase functions by their chances, about an axis.
        let density = |only: bool, total: f64, cosine: f64| {
            let mut sum = 0.0;
            for (c, component) in optics.components.iter().enumerate() {
                let Some(lobe) = &component.lobe else { continue };
                if only && !lobe.peaked() {
                    continue;
                }
                let at = lobe.at(cosine);
                for k in 0..N {
                    sum += self.chances[c * N + k] * at[k];
                }
            }
            sum / total
        };
        let cosine = line.direction.dot(direction);
        let mut chance = (1.0 - aim)
            * match event {
                Event::Ground => up.dot(direction).max(0.0) / PI,
                _ => density(false, all, cosine),
            };
        for (axis, peak) in &self.aims {
            let cosine = axis.dot(direction);
            let density = if *peak { density(true, peaked, cosine) } else { henyey_greenstein_phase(cosine, ARCH_G) };
            chance += aim / aims as f64 * density;
        }
        let turned = match event {
            Event::Ground => albedo.map(|albedo| albedo / PI * up.dot(direction).max(0.0)),
            _ => optics.scattered(&self.densities, cosine),
        };
        if !(chance > 0.0 && chance.is_finite()) {
            return None;
        }
        for k in 0..N {
            carried[k] *= turned[k] / chance;
        }
        carried.iter().any(|c| *c > 0.0).then_some(direction)
    }
}

/// A cosine with the density of the aim at the bright arch.
fn arch_sample(random: &mut Random) -> f64 {
    let ratio = (1.0 - ARCH_G * ARCH_G) / (1.0 - ARCH_G + 2.0 * ARCH_G * random.unit());
    ((1.0 + ARCH_G * ARCH_G - ratio * ratio) / (2.0 * ARCH_G)).clamp(-1.0, 1.0)
}
