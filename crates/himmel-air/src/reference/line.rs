//! Straight rays through shells of air: where they begin and end, how they are cut into cells, the columns along them.

use glam::DVec3;

use super::optics::Optics;
use crate::geometry::{altitude_along, excess, ground_distance, horizon_cosine, top_distance};

/// A ray from a point within the air to the ground or to the top of the air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub origin: DVec3,
    pub direction: DVec3,
    radius_m: f64,
    altitude_m: f64,
    /// Cosine of the zenith angle at the origin.
    mu: f64,
    /// Its length, m.
    pub end_m: f64,
    /// Whether it ends on the ground.
    pub ground: bool,
}

impl Line {
    /// From a point (m from the planet's centre) along a unit vector.
    pub fn new<const N: usize>(optics: &Optics<N>, origin: DVec3, direction: DVec3) -> Self {
        let r = origin.length();
        let altitude_m = (r - optics.radius_m).clamp(0.0, optics.top_m);
        let mu = (origin.dot(direction) / r).clamp(-1.0, 1.0);
        let ground_m = ground_distance(optics.radius_m, altitude_m, mu);
        let ground = ground_m >= 0.0;
        let end_m = if ground { ground_m } else { top_distance(optics.radius_m, optics.top_m, altitude_m, mu) };
        Self { origin, direction, radius_m: optics.radius_m, altitude_m, mu, end_m, ground }
    }

    /// The point at a distance.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// Altitude at a distance, m.
    pub fn altitude_m(&self, t: f64) -> f64 {
        altitude_along(self.radius_m, self.altitude_m, self.mu, t)
    }

    /// Distance of the point nearest to the ground, within the line.
    pub fn nearest_m(&self) -> f64 {
        (-(self.radius_m + self.altitude_m) * self.mu).clamp(0.0, self.end_m)
    }

    /// Both distances at which the (endless) line is at an altitude.
    fn crossings_m(&self, altitude_m: f64) -> Option<[f64; 2]> {
        let b = (self.radius_m + self.altitude_m) * self.mu;
        let gap = excess(self.radius_m, altitude_m) - excess(self.radius_m, self.altitude_m);
        let discriminant = b * b + gap;
        (discriminant > 0.0).then(|| {
            let root = discriminant.sqrt();
            [-b - root, -b + root]
        })
    }

    /// Cuts the line: even steps of the square root of the distance from the point nearest to the ground, which crowd
    /// where the air is densest, and every altitude in `kinks_m`. `step`: in square roots of the air's shortest scale.
    pub fn cut<const N: usize>(&self, optics: &Optics<N>, step: f64, edges: &mut Vec<f64>) {
        edges.clear();
        edges.extend([0.0, self.end_m]);
        let nearest = self.nearest_m();
        let lowest = self.altitude_m(nearest);
        for (extent, sign, end) in [(nearest, -1.0, 0.0), (self.end_m - nearest, 1.0, self.end_m)] {
            let rise = self.altitude_m(end) - lowest;
            if extent <= 0.0 {
                continue;
            }
            // 64: no more than that, however thin a layer is beside the whole air.
            let count = ((rise / optics.scale_m).sqrt() / step).ceil().clamp(1.0, 64.0) as usize;
            edges.extend((0..count).map(|i| nearest + sign * extent * (i as f64 / count as f64).powi(2)));
            for kink in optics.kinks_m.iter().filter(|kink| **kink > lowest && **kink < lowest + rise) {
                if let Some(crossings) = self.crossings_m(*kink) {
                    edges.push(if sign < 0.0 { crossings[0] } else { crossings[1] });
                }
            }
        }
        tidy(edges, self.end_m);
    }

    /// Columns (m) of all components over the line, added to `columns_m`. `rule`: nodes and weights on 0..1.
    pub fn columns<const N: usize>(
        &self,
        optics: &Optics<N>,
        edges: &[f64],
        rule: &[(f64, f64)],
        densities: &mut [f64],
        columns_m: &mut [f64],
    ) {
        for pair in edges.windows(2) {
            let length = pair[1] - pair[0];
            for (x, w) in rule {
                optics.densities(self.altitude_m(pair[0] + x * length), densities);
                for (column, density) in columns_m.iter_mut().zip(densities.iter()) {
                    *column += w * length * density;
                }
            }
        }
    }
}

/// Ascending, within 0..=`end_m`, without cells of no length.
pub(super) fn tidy(edges: &mut Vec<f64>, end_m: f64) {
    edges.retain(|t| (0.0..=end_m).contains(t));
    edges.sort_by(f64::total_cmp);
    // A micrometre, or the last digits of a long ray.
    let least = 1e-6f64.max(end_m * 1e-15);
    edges.dedup_by(|b, a| *b - *a < least);
    if let Some(last) = edges.last_mut() {
        *last = end_m;
    }
}

/// Whether a source in a direction is hidden by the planet at a point.
pub(super) fn in_shadow<const N: usize>(optics: &Optics<N>, point: DVec3, direction: DVec3) -> bool {
    let r = point.length();
    point.dot(direction) / r < horizon_cosine(optics.radius_m, r - optics.radius_m)
}

/// Distances at which a line enters and leaves the endless cylinder of a radius about an axis through the planet's
/// centre, where that lies behind the planet's middle as seen from the source; `None` where it stays outside.
///
/// `direction`: unit vector towards the source.  `radius_m`: the planet's plus the altitude at which the light passes.
pub(super) fn cylinder_m(line: &Line, direction: DVec3, radius_m: f64) -> Option<[f64; 2]> {
    let (along, nu) = (line.origin.dot(direction), line.direction.dot(direction));
    // Across the axis: |p + t d|² = radius².
    let across = line.origin - direction * along;
    let step = line.direction - direction * nu;
    let (a, b) = (step.length_squared(), across.dot(step));
    let c = (across.length() - radius_m) * (across.length() + radius_m);
    let discriminant = b * b - a * c;
    if a < 1e-18 || discriminant <= 0.0 {
        return (a < 1e-18 && c < 0.0 && along < 0.0).then_some([0.0, line.end_m]);
    }
    // Both roots without cancellation.
    let q = -(b + discriminant.sqrt().copysign(b));
    let (mut from, mut to) = (q / a, c / q);
    if from > to {
        std::mem::swap(&mut from, &mut to);
    }
    // Behind the plane through the centre: along + t nu < 0.
    let plane = -along / nu;
    if nu > 0.0 {
        to = to.min(plane);
    } else if nu < 0.0 {
        from = from.max(plane);
    } else if along >= 0.0 {
        return None;
    }
    let (from, to) = (from.max(0.0), to.min(line.end_m));
    (to > from).then_some([from, to])
}
