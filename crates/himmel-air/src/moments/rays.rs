//! The rays of a row: what the air along each direction weighs, once for all Suns, azimuths and orders.

use crate::geometry::{altitude_along, ground_distance, top_distance};
use crate::medium::Component;

use super::optics::Optics;
use super::table::{Mapping, Suns};

/// Three weights at N wavelengths: ∫ T′ Σσ_s′ dt, the same with χ₁′, with χ₂′ (of no dimension).
pub(super) type Three<const N: usize> = [[f64; N]; 3];

/// One cell of a ray as the orders beyond the first see it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<const N: usize> {
    /// Distance of the cell's centre of weight, m.
    pub t: f64,
    /// Distance from the planet's centre there, m.
    pub r: f64,
    /// Cosine between the ray and the vertical there.
    pub mu: f64,
    /// Row coordinate there.
    pub row: f64,
    /// The Sun's coordinate there.
    pub suns: Suns,
    pub weights: Three<N>,
}

/// A ray of the scaled medium.
#[derive(Clone, Debug)]
pub(super) struct Path<const N: usize> {
    /// Cosine of the zenith angle at the start.
    pub mu: f64,
    /// Where it ends: at the ground or at the top of the air, m.
    pub end: f64,
    /// Whether it ends at the ground.
    pub ground: bool,
    /// T′ from the start to the end.
    pub through: [f64; N],
    /// Cells of equal importance, for the orders ≥ 2.
    pub cells: Vec<Cell<N>>,
    /// Distances (m) and weights up to there, for the first order.
    pub cumulative: Vec<(f64, Three<N>)>,
}

/// Sizes of a ray's tables.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    pub fine: usize,
    pub cells: usize,
    pub cumulative: usize,
}

/// Boundaries of `n` cells along a ray that crowd at its point nearest to the ground: t = t_c + s|s|, equal in s.
pub(super) fn crowded(n: usize, nearest: f64, end: f64) -> impl Iterator<Item = f64> {
    let t_c = nearest.clamp(0.0, end);
    let (before, after) = (t_c.sqrt(), (end - t_c).sqrt());
    (0..=n).map(move |i| {
        let s = -before + (before + after) * i as f64 / n as f64;
        (t_c + s * s.abs()).clamp(0.0, end)
    })
}

/// A running sum over fine cells that can be inverted: distance of a share of the whole.
#[derive(Clone, Debug)]
pub(super) struct Shares {
    /// Ascending from 0 to 1, one more than cells; empty if there is nothing to share.
    sums: Vec<f64>,
}

impl Shares {
    /// From the amount in each cell.
    pub fn new(amounts: impl Iterator<Item = f64>) -> Self {
        let mut sum = 0.0;
        let mut sums = vec![0.0];
        sums.extend(amounts.map(|amount| {
            sum += amount.max(0.0);
            sum
        }));
        if !(sum > 0.0 && sum.is_finite()) {
            return Self { sums: Vec::new() };
        }
        sums.iter_mut().for_each(|s| *s /= sum);
        Self { sums }
    }

    /// `a` and `b` mixed, with the weight `of_b` of b; whichever is there if the other has nothing to share.
    pub fn mixed(a: &Self, b: &Self, of_b: f64) -> Self {
        if a.sums.is_empty() || b.sums.is_empty() {
            return if a.sums.is_empty() { b.clone() } else { a.clone() };
        }
        Self { sums: a.sums.iter().zip(&b.sums).map(|(a, b)| a * (1.0 - of_b) + b * of_b).collect() }
    }

    /// Cell coordinate (index and fraction) at which a share 0..=1 of the whole is reached.
    pub fn at(&self, share: f64) -> (usize, f64) {
        himmel_core::interpolate::locate(&self.sums, share)
    }

    /// Whether there was nothing.
    pub fn is_empty(&self) -> bool {
        self.sums.is_empty()
    }
}

fn lerp3<const N: usize>(a: &Three<N>, b: &Three<N>, x: f64) -> Three<N> {
    std::array::from_fn(|m| std::array::from_fn(|k| a[m][k] + (b[m][k] - a[m][k]) * x))
}

fn minus<const N: usize>(a: &Three<N>, b: &Three<N>) -> Three<N> {
    std::array::from_fn(|m| std::array::from_fn(|k| a[m][k] - b[m][k]))
}

impl<const N: usize> Path<N> {
    /// Follows a ray from an altitude within the air.
    pub fn new(components: &[Component], optics: &Optics<N>, map: &Mapping, h0: f64, mu: f64, sizes: Sizes) -> Self {
        let (radius_m, top_m) = (map.radius_m, map.top_m);
        let hit = ground_distance(radius_m, h0, mu);
        let ground = hit >= 0.0;
        let end = if ground { hit } else { top_distance(radius_m, top_m, h0, mu) };
        let r0 = radius_m + h0;
        let edges: Vec<f64> = crowded(sizes.fine.max(1), -r0 * mu, end).collect();
        let mut through = [1.0; N];
        let mut sums = vec![[[0.0; N]; 3]];
        let mut running = [[0.0; N]; 3];
        let mut moment = vec![0.0];
        for pair in edges.windows(2) {
            let (dt, middle) = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
            let local = optics.local(components, altitude_along(radius_m, h0, mu, middle));
            let mut weight = 0.0;
            for k in 0..N {
                let depth = local.scaled_extinction_per_m[k] * dt;
                let lost = -(-depth).exp_m1();
                let length = if depth > 1e-9 { dt * lost / depth } else { dt };
                for m in 0..3 {
                    running[m][k] += through[k] * length * local.scaled[m][k];
                }
                weight += through[k] * length * local.scaled[0][k];
                through[k] *= 1.0 - lost;
            }
            sums.push(running);
            moment.push(moment.last().copied().unwrap_or(0.0) + weight * middle);
        }
        let mut path = Self { mu, end, ground, through, cells: Vec::new(), cumulative: Vec::new() };
        // How much of each wavelength's scattered light a cell holds, averaged over the wavelengths that scatter at
        // all.
        let total = running[0];
        let amount = |i: usize| -> f64 {
            let share = |k: usize| if total[k] > 0.0 { (sums[i + 1][0][k] - sums[i][0][k]) / total[k] } else { 0.0 };
            (0..N).map(share).sum()
        };
        let cells = edges.len() - 1;
        let power = |p: f64| {
            let dt = |i: usize| edges[i + 1] - edges[i];
            let amount = |i: usize| if dt(i) > 0.0 { (amount(i).max(0.0) / dt(i)).powf(p) * dt(i) } else { 0.0 };
            Shares::new((0..cells).map(amount))
        };
        let weight = Shares::new((0..cells).map(amount));
        if weight.is_empty() {
            return path;
        }
        let value = |(i, x): (usize, f64)| lerp3(&sums[i], &sums[i + 1], x);
        let distance = |(i, x): (usize, f64)| edges[i] + (edges[i + 1] - edges[i]) * x;
        let important = Shares::mixed(&weight, &power(0.5), 0.5);
        let mut before = (0, 0.0);
        for j in 1..=sizes.cells {
            let after = important.at(j as f64 / sizes.cells as f64);
            let weights = minus(&value(after), &value(before));
            let sum: f64 = weights[0].iter().sum();
            if sum > 0.0 {
                let turned = |(i, x): (usize, f64)| moment[i] + (moment[i + 1] - moment[i]) * x;
                let t = ((turned(after) - turned(before)) / sum).clamp(distance(before), distance(after));
                let h = altitude_along(radius_m, h0, mu, t);
                let r = radius_m + h;
                let mu = ((r0 * mu + t) / r).clamp(-1.0, 1.0);
                path.cells.push(Cell { t, r, mu, row: map.row(h), suns: map.suns(h), weights });
            }
            before = after;
        }
        let flat = power(0.25);
        path.cumulative = (0..=sizes.cumulative)
            .map(|j| flat.at(j as f64 / sizes.cumulative as f64))
            .map(|place| (distance(place), value(place)))
            .collect();
        path
    }

    /// Coordinate in the cumulative table of a distance.
    pub fn coordinate(&self, t: f64) -> f64 {
        let upper = self.cumulative.partition_point(|(distance, _)| *distance <= t);
        if upper == 0 || upper >= self.cumulative.len() {
            return if upper == 0 { 0.0 } else { self.cumulative.len().saturating_sub(1) as f64 };
        }
        let (a, b) = (self.cumulative[upper - 1].0, self.cumulative[upper].0);
        (upper - 1) as f64 + (t - a) / (b - a)
    }

    /// Distance and weights up to a coordinate of a table that is not empty.
    pub fn up_to(&self, coordinate: f64) -> (f64, Three<N>) {
        let i = (coordinate as usize).min(self.cumulative.len() - 2);
        let x = coordinate - i as f64;
        let ((t0, w0), (t1, w1)) = (&self.cumulative[i], &self.cumulative[i + 1]);
        (t0 + (t1 - t0) * x, lerp3(w0, w1, x))
    }
}
