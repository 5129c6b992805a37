//! Where along a line the next event is: cells with known chances, so that every weight is exact.

use glam::DVec3;

use super::importance::Importance;
use super::line::Line;
use super::optics::Optics;
use super::random::Random;
use super::source::Source;

/// Steps of a flight, in square roots of the air's shortest scale.
const STEP: f64 = 0.9;
/// Cells of more optical depth than this are split; beyond `OPAQUE` nothing is followed (e⁻⁴⁵ is 3e-20).
const THICK: f64 = 1.0;
const OPAQUE: f64 = 45.0;
/// Share of events that are placed by the air alone, in case the coarse solution sees no light where there is some.
const PLAIN: f64 = 0.1;
/// Largest logarithm of the ratio of chances at the two ends of a cell.
const SLOPE: f64 = 4.0;

/// Inner nodes of the Lobatto rule of four points on 0..1, and the weights of ends and inner nodes.
const INNER: [f64; 2] = [0.276_393_202_250_021, 0.723_606_797_749_979];
const END_WEIGHT: f64 = 1.0 / 12.0;
const INNER_WEIGHT: f64 = 5.0 / 12.0;

/// A line cut into cells with the chance of each.
pub(super) struct Flight<const N: usize> {
    /// Distances of the edges, m.
    edges: Vec<f64>,
    /// Columns (m) from the start to each edge, of all components.
    columns_m: Vec<f64>,
    /// Densities at each edge.
    densities: Vec<f64>,
    cells: Vec<Cell>,
    /// Sum of the cells' steered and plain weights.
    steered: f64,
    plain: f64,
    /// Transmittance to the line's end.
    through: [f64; N],
    ground_chance: f64,
    /// What the coarse solution expects from all of it; to be compared with later events of the path.
    pub expected: f64,
    // Work memory.
    todo: Vec<f64>,
    inner: [Vec<f64>; 2],
    to: Vec<f64>,
}

#[derive(Clone, Copy)]
struct Cell {
    /// Sums of the weights up to the end of this cell.
    steered: f64,
    plain: f64,
    /// Logarithm of the ratio of steered chances, end over start.
    slope: f64,
}

/// What happens at the end of a flight.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// Nothing: the light is lost.
    None,
    /// Scattering in the air, at a distance.
    Air(f64),
    /// The ground.
    Ground,
}

impl<const N: usize> Flight<N> {
    pub fn new(optics: &Optics<N>) -> Self {
        let zeros = vec![0.0; optics.components.len()];
        Self {
            edges: Vec::new(),
            columns_m: Vec::new(),
            densities: Vec::new(),
            cells: Vec::new(),
            steered: 0.0,
            plain: 0.0,
            through: [1.0; N],
            ground_chance: 0.0,
            expected: 0.0,
            todo: Vec::new(),
            inner: [zeros.clone(), zeros.clone()],
            to: zeros,
        }
    }

    /// Cuts a line into cells and gives each its chance.
    ///
    /// `weight`: what the path carries at each wavelength, times how much that wavelength matters.  `diffuse_only`: the
    /// next event's direct light is known already.
    pub fn prepare(
        &mut self,
        optics: &Optics<N>,
        importance: &Importance,
        line: &Line,
        sources: &[Source<N>],
        weight: &[f64; N],
        diffuse_only: bool,
    ) {
        let count = optics.components.len();
        let mut todo = std::mem::take(&mut self.todo);
        line.cut(optics, STEP, &mut todo);
        todo.reverse();
        self.edges.clear();
        self.columns_m.clear();
        self.densities.clear();
        self.cells.clear();
        let start = todo.pop().unwrap_or(0.0);
        self.edges.push(start);
        self.columns_m.resize(count, 0.0);
        self.densities.resize(count, 0.0);
        optics.densities(line.altitude_m(start), &mut self.densities);
        let light = |t: f64, altitude_m: f64| {
            let point = line.at(t);
            let r = point.length();
            let sum: f64 = sources
                .iter()
                .map(|source| {
                    let mu_s = point.dot(source.direction) / r;
                    match diffuse_only {
                        true => importance.diffuse(altitude_m, mu_s),
                        false => importance.total(altitude_m, mu_s),
                    }
                })
                .sum();
            sum
        };
        // Chances at the last edge: plain, and steered by the light there.
        let at = |densities: &[f64], depth: &[f64; N], t: f64| {
            let scattering = optics.scattering(densities);
            let plain: f64 = (0..N).map(|k| weight[k] * (-depth[k]).exp() * scattering[k]).sum();
            (plain, if plain > 0.0 { plain * light(t, line.altitude_m(t)) } else { 0.0 })
        };
        let mut depth = [0.0; N];
        let mut last = at(&self.densities, &depth, start);
        let (mut steered, mut plain) = (0.0, 0.0);
        let mut opaque = false;
        while let Some(to) = todo.pop() {
            let base = (self.edges.len() - 1) * count;
            let from = self.edges[self.edges.len() - 1];
            let length = to - from;
            optics.densities(line.altitude_m(to), &mut self.to);
            for (inner, x) in self.inner.iter_mut().zip(INNER) {
                optics.densities(line.altitude_m(from + x * length), inner);
            }
            let mut next_depth = depth;
            for (c, component) in optics.components.iter().enumerate() {
                let column = length
                    * (END_WEIGHT * (self.densities[base + c] + self.to[c])
                        + INNER_WEIGHT * (self.inner[0][c] + self.inner[1][c]));
                for k in 0..N {
                    next_depth[k] += column * component.extinction_per_m[k];
                }
            }
            let thickness = (0..N).map(|k| next_depth[k] - depth[k]).fold(0.0, f64::max);
            if thickness > THICK && length > 1e-9 * line.end_m.max(1.0) {
                todo.extend([to, from + 0.5 * length]);
                continue;
            }
            for c in 0..count {
                let column = length
                    * (END_WEIGHT * (self.densities[base + c] + self.to[c])
                        + INNER_WEIGHT * (self.inner[0][c] + self.inner[1][c]));
                self.columns_m.push(self.columns_m[base + c] + column);
            }
            self.densities.extend_from_slice(&self.to);
            self.edges.push(to);
            depth = next_depth;
            let next = at(&self.densities[base + count..], &depth, to);
            let slope = (next.1.max(1e-300) / last.1.max(1e-300)).ln();
            // The mean of what is straight in the logarithm.
            let mean = if slope.abs() < 1e-3 {
                0.5 * (last.1 + next.1)
            } else if slope.abs() < 600.0 {
                (next.1 - last.1) / slope
            } else {
                0.5 * last.1.max(next.1)
            };
            steered += length * mean;
            plain += length * 0.5 * (last.0 + next.0);
            self.cells.push(Cell { steered, plain, slope: slope.clamp(-SLOPE, SLOPE) });
            last = next;
            if depth.iter().all(|depth| *depth > OPAQUE) {
                opaque = true;
                break;
            }
        }
        todo.clear();
        self.todo = todo;
        (self.steered, self.plain) = (steered, plain);
        self.through = depth.map(|depth| (-depth).exp());
        let mut ground = 0.0;
        if line.ground && !opaque {
            let point = line.at(line.end_m);
            let falls: f64 = sources
                .iter()
                .map(|source| {
                    let mu_s = point.dot(source.direction) / point.length();
                    let diffuse = importance.diffuse(0.0, mu_s);
                    let direct = importance.total(0.0, mu_s) - diffuse;
                    0.5 * diffuse + if diffuse_only { 0.0 } else { direct.max(0.0) * mu_s.max(0.0) }
                })
                .sum();
            // 4: radiance of the ground is albedo/π times what falls on it, of the air 1/4π times what passes.
            let albedo: f64 = (0..N).map(|k| weight[k] * self.through[k] * optics.albedo[k]).sum();
            ground = 4.0 * falls * albedo;
        }
        self.expected = steered + ground;
        self.ground_chance = match (ground > 0.0, plain > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            // 5 %: neither may starve where the coarse solution is wrong.
            (true, true) => (ground / (steered + ground)).clamp(0.05, 0.95),
        };
    }

    /// Draws the next event. Returns it with the factor T / chance for each wavelength, and leaves in `densities` those of
    /// the air at the event. `u`: even in 0..1, or a stratum of it.
    pub fn draw(
        &self,
        optics: &Optics<N>,
        line: &Line,
        mut u: f64,
        random: &mut Random,
        densities: &mut [f64],
    ) -> (Event, [f64; N]) {
        if u < self.ground_chance {
            optics.densities(0.0, densities);
            return (Event::Ground, self.through.map(|through| through / self.ground_chance));
        }
        if self.plain <= 0.0 {
            return (Event::None, [0.0; N]);
        }
        u = (u - self.ground_chance) / (1.0 - self.ground_chance);
        let plain_share = if self.steered > 0.0 { PLAIN } else { 1.0 };
        let by_light = u >= plain_share;
        let (i, x);
        if by_light {
            let target = (u - plain_share) / (1.0 - plain_share) * self.steered;
            i = self.cells.partition_point(|cell| cell.steered <= target).min(self.cells.len() - 1);
            let slope = self.cells[i].slope;
            let v = random.unit();
            x = if slope.abs() < 1e-6 { v } else { (v * slope.exp_m1()).ln_1p() / slope };
        } else {
            let target = u / plain_share * self.plain;
            i = self.cells.partition_point(|cell| cell.plain <= target).min(self.cells.len() - 1);
            x = random.unit();
        }
        let (before_steered, before_plain) = match i {
            0 => (0.0, 0.0),
            i => (self.cells[i - 1].steered, self.cells[i - 1].plain),
        };
        let cell = self.cells[i];
        let shape =
            if cell.slope.abs() < 1e-6 { 1.0 } else { cell.slope * (cell.slope * x).exp() / cell.slope.exp_m1() };
        let (from, to) = (self.edges[i], self.edges[i + 1]);
        let steered = if self.steered > 0.0 { (cell.steered - before_steered) / self.steered } else { 0.0 };
        let plain = (cell.plain - before_plain) / self.plain;
        let chance =
            (1.0 - self.ground_chance) * ((1.0 - plain_share) * steered * shape + plain_share * plain) / (to - from);
        if chance <= 0.0 {
            return (Event::None, [0.0; N]);
        }
        let t = from + x * (to - from);
        let count = optics.components.len();
        let mut depth = optics.depth(&self.columns_m[i * count..(i + 1) * count]);
        // Three Gauss nodes for the rest of the way.
        const NODES: [(f64, f64); 3] =
            [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
        for (node, w) in NODES {
            optics.densities(line.altitude_m(from + node * (t - from)), densities);
            let part = optics.depth(densities);
            for k in 0..N {
                depth[k] += w * (t - from) * part[k];
            }
        }
        optics.densities(line.altitude_m(t), densities);
        (Event::Air(t), depth.map(|depth| (-depth).exp() / chance))
    }
}

/// The point of the ground where a line ends, exactly on the sphere.
pub(super) fn ground_point<const N: usize>(optics: &Optics<N>, line: &Line) -> DVec3 {
    line.at(line.end_m).normalize() * optics.radius_m
}
