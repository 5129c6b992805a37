//! Questions and their answers.

use glam::DVec3;

use super::first::{Scratch, first_order, light_rule, points_for};
use super::flight::Flight;
use super::importance::Importance;
use super::line::Line;
use super::optics::Optics;
use super::path::{ORDERS, Walker};
use super::random::Random;
use super::source::Source;
use crate::error::AirError;
use crate::medium::Sampled;

/// Independent batches that an error is estimated from.
pub const BATCHES: usize = 32;

/// The most paths of one question.
pub const MOST_SAMPLES: u64 = 1 << 40;

/// Paths are steered through air of less than this optical depth of scattering, forward peaks taken out. In thicker air light
/// is everywhere, and the weights of steered paths would wander off over their many events until rare, heavy ones
/// carried the answer.
const THICK: f64 = 2.0;

/// How much work to put into an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Paths, at least 32: each batch has one.
    pub samples: u64,
    /// Go on, doubling the paths, until the standard error is this share of the answer at every wavelength…
    pub target_relative_error: Option<f64>,
    /// … or this many paths have been followed.
    pub most_samples: u64,
    /// Seed of the random numbers: the same one gives the same answer, whatever the machine's threads.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { samples: 4096, target_relative_error: None, most_samples: 1 << 22, seed: 1 }
    }
}

impl Effort {
    /// Whether the numbers make sense.
    pub fn check(&self) -> Result<(), AirError> {
        let error = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
        if !(BATCHES as u64..=MOST_SAMPLES).contains(&self.samples) {
            return error("number of samples", "lie in 32..=1e12 (an error needs 32 batches)", self.samples as f64);
        }
        match self.target_relative_error {
            Some(target) if !(1e-6..=1.0).contains(&target) => {
                error("target error", "lie in 1e-6..=1 (a share of the answer)", target)
            }
            _ => Ok(()),
        }
    }
}

/// An estimate with its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate<const N: usize> {
    /// The value: radiance (per sr) or irradiance, in the sources' unit.
    pub value: [f64; N],
    /// Standard error of the mean, from independent batches. The first order has none.
    pub standard_error: [f64; N],
    /// The value order by order: light scattered (or reflected by the ground) once, twice …; the last one holds the rest.
    pub orders: Vec<[f64; N]>,
    /// Paths that were followed.
    pub samples: u64,
}

impl<const N: usize> Estimate<N> {
    fn exact(first: [f64; N]) -> Self {
        Self { value: first, standard_error: [0.0; N], orders: vec![first], samples: 0 }
    }

    /// The largest standard error relative to its value.
    pub fn relative_error(&self) -> f64 {
        let each = self.value.iter().zip(&self.standard_error);
        each.map(|(value, error)| if *error > 0.0 { error / value.abs() } else { 0.0 }).fold(0.0, f64::max)
    }
}

/// Reflectance of the ground by place.
type GroundMap = Box<dyn Fn(DVec3) -> f64 + Send + Sync>;

/// A medium, ready to be asked. It holds no light: sources come with each question.
pub struct Tracer<const N: usize> {
    pub(super) optics: Optics<N>,
    pub(super) importance: Importance,
    /// How much each wavelength matters for where paths go; sums to 1.
    pub(super) weight: [f64; N],
    ground_map: Option<GroundMap>,
}

/// Vertical optical depth of scattering at a wavelength, without what goes on forwards.
fn scattering_depth<const N: usize>(optics: &Optics<N>, k: usize) -> f64 {
    let line = Line::new(optics, DVec3::Z * optics.radius_m, DVec3::Z);
    let (mut edges, count) = (Vec::new(), optics.components.len());
    let (mut densities, mut columns_m) = (vec![0.0; count], vec![0.0; count]);
    line.cut(optics, 1.0, &mut edges);
    line.columns(optics, &edges, light_rule(), &mut densities, &mut columns_m);
    let share = |(column, component): (&f64, &super::optics::Constituent<N>)| {
        let forward = component.lobe.as_ref().map_or(0.0, |lobe| lobe.mean_cosine[k].max(0.0));
        column * component.scattering_per_m[k] * (1.0 - forward)
    };
    columns_m.iter().zip(&optics.components).map(share).sum()
}

/// Sums of a batch.
#[derive(Clone)]
pub(super) struct Batch<const N: usize> {
    pub orders: Box<[[f64; N]; ORDERS]>,
    pub samples: u64,
}

impl<const N: usize> Tracer<N> {
    /// Prepares a medium at N wavelengths, all of which every path carries. Fails where a coefficient is no number.
    pub fn new(air: &Sampled<'_, N>) -> Result<Self, AirError> {
        let optics = Optics::new(air)?;
        // Steered by the wavelength in the middle of the extinctions at the ground.
        let mut densities = vec![0.0; optics.components.len()];
        optics.densities(0.0, &mut densities);
        let extinction = optics.depth(&densities);
        let mut by_extinction: Vec<usize> = (0..N).collect();
        by_extinction.sort_by(|a, b| extinction[*a].total_cmp(&extinction[*b]));
        let importance = match by_extinction.get(N / 2) {
            Some(k) if scattering_depth(&optics, *k) < THICK => Importance::solve(&optics, *k),
            _ => Importance::even(&optics),
        };
        Ok(Self { optics, importance, weight: [1.0 / N as f64; N], ground_map: None })
    }

    /// Without the coarse solution that tells paths where light is: noisier, the same on average.
    pub fn unguided(mut self) -> Self {
        self.importance = Importance::even(&self.optics);
        self
    }

    /// How much each wavelength matters (luminous efficacy times irradiance, say): only the noise depends on it. Weights
    /// that are not positive and finite count as a thousandth of the largest.
    pub fn weighted(mut self, weight: [f64; N]) -> Self {
        let largest = weight.iter().copied().filter(|w| w.is_finite()).fold(0.0, f64::max);
        if largest > 0.0 {
            let weight = weight.map(|w| if w.is_finite() { w.max(1e-3 * largest) } else { largest });
            let sum: f64 = weight.iter().sum();
            self.weight = weight.map(|w| w / sum);
        }
        self
    }

    /// A ground whose albedo changes from place to place: a factor on the medium's albedo (the product is held within
    /// 0..=1) by the unit vector from the planet's centre to the place, in the observer's frame.
    pub fn with_ground_map(mut self, map: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Self {
        self.ground_map = Some(Box::new(map));
        self
    }

    pub(super) fn albedo_at(&self, place: DVec3) -> [f64; N] {
        match &self.ground_map {
            Some(map) => {
                let factor = map(place);
                self.optics.albedo.map(|albedo| (albedo * factor).clamp(0.0, 1.0))
            }
            None => self.optics.albedo,
        }
    }

    /// The line of sight of an observer within the air; `None` where it misses the air.
    pub(super) fn sight(&self, altitude_m: f64, direction: DVec3) -> Result<Option<Line>, AirError> {
        let error = |what: &str, law, got| Err(AirError::Optics { what: what.into(), law, got });
        if !(0.0..=1e12).contains(&altitude_m) {
            return error("altitude", "lie in 0..=1e12 m, above the ground", altitude_m);
        }
        let length = direction.length();
        if length.is_nan() || (length - 1.0).abs() > 1e-6 {
            return error("direction of view", "be a unit vector", length);
        }
        let direction = direction / length;
        let mut origin = DVec3::Z * (self.optics.radius_m + altitude_m);
        if altitude_m > self.optics.top_m {
            let top = self.optics.radius_m + self.optics.top_m;
            let b = origin.dot(direction);
            // Across the line of sight nothing cancels.
            let nearest = (origin - direction * b).length();
            if b >= 0.0 || nearest >= top {
                return Ok(None);
            }
            origin += direction * (-b - ((top - nearest) * (top + nearest)).sqrt());
            origin = origin.normalize() * top;
        }
        Ok(Some(Line::new(&self.optics, origin, direction)))
    }

    fn check_sources(sources: &[Source<N>]) -> Result<(), AirError> {
        sources.iter().try_for_each(Source::check)
    }

    /// Light of the first order alone, without chance: scattered once, or reflected once by the ground. The disc of a
    /// source itself is not in it.
    pub fn first_order(&self, sources: &[Source<N>], altitude_m: f64, direction: DVec3) -> Result<[f64; N], AirError> {
        Self::check_sources(sources)?;
        let Some(line) = self.sight(altitude_m, direction)? else { return Ok([0.0; N]) };
        let mut scratch = Scratch::new(&self.optics);
        Ok(first_order(&self.optics, &line, sources, &|place| self.albedo_at(place), &mut scratch).radiance)
    }

    /// Transmittance from an observer along a direction to space; 0 where the ground is in the way.
    pub fn transmittance(&self, altitude_m: f64, direction: DVec3) -> Result<[f64; N], AirError> {
        let Some(line) = self.sight(altitude_m, direction)? else { return Ok([1.0; N]) };
        if line.ground {
            return Ok([0.0; N]);
        }
        let rule = himmel_core::quadrature::gauss_legendre_unit(12);
        let (mut edges, count) = (Vec::new(), self.optics.components.len());
        let (mut densities, mut columns_m) = (vec![0.0; count], vec![0.0; count]);
        line.cut(&self.optics, 0.5, &mut edges);
        line.columns(&self.optics, &edges, &rule, &mut densities, &mut columns_m);
        Ok(self.optics.depth(&columns_m).map(|depth| (-depth).exp()))
    }

    /// Radiance that arrives at an altitude from a direction (unit vector; z is the zenith), all orders.
    ///
    /// Errors: an altitude in the ground, a direction that is none, sources that are none, too few samples.
    pub fn radiance(
        &self,
        sources: &[Source<N>],
        altitude_m: f64,
        direction: DVec3,
        effort: &Effort,
        question: u64,
    ) -> Result<Estimate<N>, AirError> {
        Self::check_sources(sources)?;
        effort.check()?;
        let Some(line) = self.sight(altitude_m, direction)? else { return Ok(Estimate::exact([0.0; N])) };
        let mut walker = Walker::new(self);
        let first =
            first_order(&self.optics, &line, sources, &|place| self.albedo_at(place), &mut walker.scratch).radiance;
        let mut flight = Flight::new(&self.optics);
        flight.prepare(&self.optics, &self.importance, &line, sources, &self.weight, true);
        if flight.expected.is_nan() || flight.expected <= 0.0 {
            return Ok(Estimate::exact(first));
        }
        let mut streams: Vec<Random> = (0..BATCHES).map(|b| Random::new(effort.seed, question, b as u64)).collect();
        estimate(effort, first, |batch, count, sums| {
            let random = &mut streams[batch];
            walker.orders = *sums.orders;
            for i in 0..count {
                // One path for each stratum of the line of sight.
                let u = (i as f64 + random.unit()) / count as f64;
                walker.walk(self, &line, &flight, sources, (u, 1.0), random);
            }
            *sums.orders = walker.orders;
        })
    }
}

/// Pictures: many small answers whose error is told from one another.
impl<const N: usize> Tracer<N> {
    /// One sample of a pixel: the radiance that arrives at an altitude from a direction, all orders, in the sources' unit
    /// per sr. The first order by one of the points that stand for each source's disc (where its centre will do, without
    /// chance), the others as the mean of `paths` paths; the mean of many samples is [`radiance`](Self::radiance). `stream`: seed, question (the pixel) and
    /// number of the sample; the same stream gives the same answer.
    ///
    /// Errors: an altitude in the ground, a direction that is none, sources that are none.
    pub fn sample(
        &self,
        sources: &[Source<N>],
        altitude_m: f64,
        direction: DVec3,
        paths: u32,
        [seed, question, number]: [u64; 3],
    ) -> Result<[f64; N], AirError> {
        Self::check_sources(sources)?;
        let Some(line) = self.sight(altitude_m, direction)? else { return Ok([0.0; N]) };
        let mut random = Random::new(seed, question, number);
        let points: Vec<Source<N>> = sources
            .iter()
            .map(|source| {
                let points = points_for(&self.optics, &line, source);
                let share = |weight: &[f64; N]| (0..N).map(|k| self.weight[k] * weight[k]).sum::<f64>();
                // Drawn by their weights, which sum to 1: what is left of them is the limb's colour.
                let mut left = random.unit();
                let mut drawn = points.iter().find(|(_, weight)| {
                    left -= share(weight);
                    left < 0.0
                });
                drawn = drawn.or(points.last());
                let (direction, weight) = drawn.map_or((source.direction, [1.0; N]), |(d, weight)| (*d, *weight));
                let irradiance = std::array::from_fn(|k| source.irradiance[k] * weight[k] / share(&weight));
                Source { direction, radius_rad: 0.0, irradiance, limb: None }
            })
            .collect();
        let mut walker = Walker::new(self);
        let albedo_at = |place| self.albedo_at(place);
        let first = first_order(&self.optics, &line, &points, &albedo_at, &mut walker.scratch).radiance;
        let mut flight = Flight::new(&self.optics);
        flight.prepare(&self.optics, &self.importance, &line, sources, &self.weight, true);
        if paths == 0 || flight.expected.is_nan() || flight.expected <= 0.0 {
            return Ok(first);
        }
        for i in 0..paths {
            let u = (f64::from(i) + random.unit()) / f64::from(paths);
            walker.walk(self, &line, &flight, sources, (u, 1.0), &mut random);
        }
        let later = |k: usize| walker.orders.iter().map(|order| order[k]).sum::<f64>() / f64::from(paths);
        Ok(std::array::from_fn(|k| first[k] + later(k)))
    }
}

/// Follows paths in batches until the effort is spent. `work`: batch, paths to follow, where to add them.
pub(super) fn estimate<const N: usize>(
    effort: &Effort,
    first: [f64; N],
    mut work: impl FnMut(usize, u64, &mut Batch<N>),
) -> Result<Estimate<N>, AirError> {
    let mut batches = vec![Batch { orders: Box::new([[0.0; N]; ORDERS]), samples: 0 }; BATCHES];
    let mut per_batch = effort.samples.div_ceil(BATCHES as u64);
    loop {
        for (index, batch) in batches.iter_mut().enumerate() {
            work(index, per_batch, batch);
            batch.samples += per_batch;
        }
        let answer = evaluate(&batches, first);
        let reached = effort.target_relative_error.is_none_or(|target| answer.relative_error() <= target);
        if reached || answer.samples >= effort.most_samples {
            return Ok(answer);
        }
        // As many again as there are: the doubling keeps batches even.
        per_batch = answer.samples / BATCHES as u64;
    }
}

fn evaluate<const N: usize>(batches: &[Batch<N>], first: [f64; N]) -> Estimate<N> {
    let samples: u64 = batches.iter().map(|batch| batch.samples).sum();
    let mut orders = vec![[0.0; N]; ORDERS];
    orders[0] = first;
    let mut means = vec![[0.0; N]; batches.len()];
    for (mean, batch) in means.iter_mut().zip(batches) {
        for (order, sums) in orders.iter_mut().zip(batch.orders.iter()) {
            for k in 0..N {
                order[k] += sums[k] / samples as f64;
                mean[k] += sums[k] / batch.samples as f64;
            }
        }
    }
    let mut value = [0.0; N];
    for order in &orders {
        for k in 0..N {
            value[k] += order[k];
        }
    }
    let count = batches.len() as f64;
    let standard_error = std::array::from_fn(|k| {
        let mean = means.iter().map(|m| m[k]).sum::<f64>() / count;
        let variance = means.iter().map(|m| (m[k] - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (variance / count).sqrt()
    });
    while orders.len() > 1 && orders.last().is_some_and(|order| order.iter().all(|v| *v == 0.0)) {
        orders.pop();
    }
    Estimate { value, standard_error, orders, samples }
}
