//! Filling the table, order by order.

use std::f64::consts::PI;

use himmel_core::quadrature::gauss_legendre_unit;

use crate::columns::Columns;
use crate::geometry::{altitude_along, horizon_cosine, shadow_interval};
use crate::medium::Component;

use super::Quality;
use super::optics::Optics;
use super::rays::{Path, Sizes};
use super::table::{Mapping, Six, Table};

/// Suns lower than this get the finer set of directions. (Below the level, not the horizon: high up the arch of
/// twilight is thin as soon as the Sun has set.)
const DEEP_RAD: f64 = -8.0 * PI / 180.0;

/// What all rows need to know.
pub(super) struct Scene<'a, const N: usize> {
    pub components: &'a [Component],
    pub optics: &'a Optics<N>,
    pub columns: &'a Columns,
    pub albedo: [f64; N],
    pub map: Mapping,
    pub quality: &'a Quality,
}

/// Directions of a row: rays with their share of the zenith cosine, and azimuths.
struct Directions<const N: usize> {
    /// Ray, sine of its zenith angle, dµ.
    rays: Vec<(Path<N>, f64, f64)>,
    azimuths: usize,
}

/// A row of the table with its rays.
pub(super) struct Row<const N: usize> {
    altitude_m: f64,
    day: Directions<N>,
    deep: Directions<N>,
}

/// Moments of one row over the Suns, and the irradiance of what comes from above on a level surface there.
pub(super) type Filled<const N: usize> = Vec<(Six<N>, [f64; N])>;

impl<const N: usize> Scene<'_, N> {
    /// Optical depth of the scaled medium from a point to the Sun.
    fn sun_through(&self, altitude_m: f64, mu_s: f64) -> [f64; N] {
        let mut depth = [0.0; N];
        self.columns.for_each_column(altitude_m, mu_s, |component, column_m| {
            if let Some(s) = self.optics.scatterers.get(component) {
                for k in 0..N {
                    depth[k] += column_m * (s.extinction_per_m[k] - s.peak_per_m[k]);
                }
            }
        });
        depth.map(|depth| (-depth).exp())
    }

    /// Direct sunlight (with its forward-scattered company) on the level ground.
    pub fn direct(&self, mu_s: f64) -> [f64; N] {
        if mu_s <= 0.0 {
            return [0.0; N];
        }
        self.sun_through(0.0, mu_s).map(|through| through * mu_s)
    }

    /// The rays of a row: two Gauss panels that meet at the horizon, µ = µ_h ± (…) s², where light changes fastest.
    pub fn row(&self, index: usize) -> Row<N> {
        let altitude_m = self.map.altitude_m(index);
        let horizon = horizon_cosine(self.map.radius_m, altitude_m);
        let quality = self.quality;
        let sizes = Sizes { fine: quality.fine_cells, cells: quality.cells, cumulative: quality.cumulative_cells };
        let directions = |[up, down, azimuths]: [usize; 3]| {
            let panel = |nodes: usize, reach: f64| {
                gauss_legendre_unit(nodes)
                    .into_iter()
                    .map(move |(s, w)| (horizon + reach * s * s, reach.abs() * 2.0 * s * w))
            };
            let ray = |(mu, weight): (f64, f64)| {
                let path = Path::new(self.components, self.optics, &self.map, altitude_m, mu, sizes);
                (path, (1.0 - mu * mu).max(0.0).sqrt(), weight)
            };
            let rays = panel(up, 1.0 - horizon).chain(panel(down, -1.0 - horizon)).map(ray).collect();
            Directions { rays, azimuths }
        };
        Row { altitude_m, day: directions(quality.directions), deep: directions(quality.deep_directions) }
    }

    /// Sums a radiance over the sphere, for every Sun of a row. `radiance`: of a ray, a Sun's zenith cosine and the
    /// cosine between the two.
    fn fill(&self, row: &Row<N>, radiance: impl Fn(&Path<N>, f64, f64) -> [f64; N]) -> Filled<N> {
        let suns = self.map.suns(row.altitude_m);
        let columns = self.map.columns;
        let deep = DEEP_RAD.sin();
        let sun = |column: usize| {
            let mu_s = suns.mu_s(column as f64 / (columns - 1) as f64);
            let sin_s = (1.0 - mu_s * mu_s).max(0.0).sqrt();
            let Directions { rays, azimuths } = if mu_s < deep { &row.deep } else { &row.day };
            let (mut six, mut from_above) = ([[0.0; N]; 6], [0.0; N]);
            for (path, sin, weight) in rays {
                let z = path.mu;
                for j in 0..*azimuths {
                    let x = sin * (PI * (j as f64 + 0.5) / *azimuths as f64).cos();
                    let light = radiance(path, mu_s, (z * mu_s + x * sin_s).clamp(-1.0, 1.0));
                    let weight = weight * 2.0 * PI / *azimuths as f64;
                    // Light travels against the look direction: F changes its sign.
                    let basis = [1.0, -x, -z, x * x - 1.0 / 3.0, z * z - 1.0 / 3.0, x * z];
                    for k in 0..N {
                        for m in 0..6 {
                            six[m][k] += weight * light[k] * basis[m];
                        }
                        from_above[k] += weight * light[k] * z.max(0.0);
                    }
                }
            }
            (six, from_above)
        };
        (0..columns).map(sun).collect()
    }

    /// Sunlight reflected once by the ground where a ray ends: T′ · albedo/π · E.
    fn reflected(&self, path: &Path<N>, irradiance: [f64; N]) -> [f64; N] {
        std::array::from_fn(|k| path.through[k] * self.albedo[k] / PI * irradiance[k])
    }

    /// Zenith cosine of the Sun at the end of a ray, on the ground.
    fn ground_mu_s(&self, row: &Row<N>, path: &Path<N>, mu_s: f64, nu: f64) -> f64 {
        (((self.map.radius_m + row.altitude_m) * mu_s + path.end * nu) / self.map.radius_m).clamp(-1.0, 1.0)
    }

    /// Order 1: sunlight scattered once by the scaled medium, or reflected once by the ground.
    ///
    /// Only the lit part of each ray is sampled: the planet's shadow cylinder cuts it analytically.
    pub fn first(&self, row: &Row<N>) -> Filled<N> {
        let (radius_m, h0) = (self.map.radius_m, row.altitude_m);
        let r0 = radius_m + h0;
        self.fill(row, |path, mu_s, nu| {
            let mut light = match path.ground {
                true => self.reflected(path, self.direct(self.ground_mu_s(row, path, mu_s, nu))),
                false => [0.0; N],
            };
            if path.cumulative.len() < 2 {
                return light;
            }
            let second = 0.5 * (3.0 * nu * nu - 1.0);
            let (from, to) = shadow_interval(radius_m, h0, path.mu, mu_s, nu);
            let parts = lit_parts(path, from, to, self.quality.lit_samples);
            for (begin, finish, samples) in parts {
                let step = (finish - begin) / samples.max(1) as f64;
                let mut before = path.up_to(begin).1;
                for i in 0..samples {
                    let t = path.up_to(begin + (i as f64 + 0.5) * step).0;
                    let after = path.up_to(begin + (i + 1) as f64 * step).1;
                    let h = altitude_along(radius_m, h0, path.mu, t);
                    let sun = self.sun_through(h, (r0 * mu_s + t * nu) / (radius_m + h));
                    for k in 0..N {
                        // p′ = (1 + 3 χ₁′ cos θ + 5 χ₂′ P₂(cos θ)) / 4π
                        let scattered = (after[0][k] - before[0][k])
                            + 3.0 * nu * (after[1][k] - before[1][k])
                            + 5.0 * second * (after[2][k] - before[2][k]);
                        light[k] += sun[k] * scattered / (4.0 * PI);
                    }
                    before = after;
                }
            }
            light
        })
    }

    /// Order k + 1 from the moments of order k and the irradiance it brings to the ground.
    pub fn next(&self, row: &Row<N>, before: &Table<N>, ground: &Ground<N>) -> Filled<N> {
        let r0 = self.map.radius_m + row.altitude_m;
        self.fill(row, |path, mu_s, nu| {
            let mut light = match path.ground {
                true => self.reflected(path, ground.at(self.ground_mu_s(row, path, mu_s, nu))),
                false => [0.0; N],
            };
            for cell in &path.cells {
                let mu_s = ((r0 * mu_s + cell.t * nu) / cell.r).clamp(-1.0, 1.0);
                let moments = before.at(cell.row, cell.suns.coordinate(mu_s));
                add_scattered(&mut light, &moments, &cell.weights, cell.mu, mu_s, nu);
            }
            light
        })
    }
}

/// Adds what a field of known moments scatters towards a viewer: (1/4π) [w₀ G + 3 w₁ ω·F + (15/2) w₂ ωᵀQω]
///
/// `weights`: Σσ_s, Σσ_s χ₁, Σσ_s χ₂, times whatever they are summed over.  `mu`, `mu_s`, `nu`: cosines view–vertical,
/// Sun–vertical, view–Sun there; ω = −view is the direction of travel.
///
/// Law tested: exact for phase functions without moments beyond l = 2.
pub(super) fn add_scattered<const N: usize>(
    sum: &mut [f64; N],
    moments: &Six<N>,
    weights: &[[f64; N]; 3],
    mu: f64,
    mu_s: f64,
    nu: f64,
) {
    let sin_s = (1.0 - mu_s * mu_s).max(0.0).sqrt();
    let across = (1.0 - mu * mu).max(0.0).sqrt();
    // With the Sun in the zenith every azimuth is the same: F_x and Q_xz vanish, and x² takes half of what is level.
    let (x, xx) = if sin_s > 1e-9 {
        let x = ((nu - mu * mu_s) / sin_s).clamp(-across, across);
        (x, x * x)
    } else {
        (0.0, 0.5 * across * across)
    };
    let yy = across * across - xx;
    let [g, f_x, f_z, q_xx, q_zz, q_xz] = moments;
    for k in 0..N {
        let f = -(x * f_x[k] + mu * f_z[k]);
        let q = q_xx[k] * (xx - yy) + q_zz[k] * (mu * mu - yy) + 2.0 * q_xz[k] * x * mu;
        sum[k] += (weights[0][k] * g[k] + 3.0 * weights[1][k] * f + 7.5 * weights[2][k] * q) / (4.0 * PI);
    }
}

/// The lit parts of a ray as coordinates of its cumulative table, with their shares of the samples.
fn lit_parts<const N: usize>(path: &Path<N>, dark_from: f64, dark_to: f64, samples: usize) -> [(f64, f64, usize); 2] {
    let last = (path.cumulative.len() - 1) as f64;
    let (from, to) = (dark_from.min(path.end), dark_to.min(path.end));
    if to <= from {
        return [(0.0, last, samples), (last, last, 0)];
    }
    let near = if from > 0.0 { path.coordinate(from) } else { 0.0 };
    let far = if to < path.end { path.coordinate(to) } else { last };
    let lit = near + last - far;
    if lit <= 0.0 {
        return [(0.0, 0.0, 0), (last, last, 0)];
    }
    let in_near = match (near > 0.0, far < last) {
        (true, true) => {
            ((samples as f64 * near / lit).round() as usize).clamp(samples.min(3), samples - samples.min(3))
        }
        (true, false) => samples,
        (false, _) => 0,
    };
    [(0.0, near, in_near), (far, last, samples - in_near)]
}

/// Irradiance of the ground by the sky over the columns of the first row: the logarithm is stored.
#[derive(Clone, Debug)]
pub(super) struct Ground<const N: usize> {
    suns: super::table::Suns,
    logs: Vec<[f64; N]>,
}

impl<const N: usize> Ground<N> {
    pub fn new(map: &Mapping, irradiance: impl Iterator<Item = [f64; N]>, half: bool) -> Self {
        let round = |x: f64| if half { half::f16::from_f64(x).to_f64() } else { x };
        let mut logs: Vec<_> = irradiance.map(|e| e.map(|e| round(e.max(super::table::FLOOR).ln()))).collect();
        logs.resize(map.columns, [super::table::FLOOR.ln(); N]);
        Self { suns: map.suns(0.0), logs }
    }

    /// Diffuse irradiance at a zenith cosine of the Sun.
    pub fn at(&self, mu_s: f64) -> [f64; N] {
        let (u, fade) = self.suns.coordinate(mu_s);
        let x = u * (self.logs.len() - 1) as f64;
        let j = (x as usize).min(self.logs.len() - 2);
        std::array::from_fn(|k| {
            let log = himmel_core::interpolate::lerp(self.logs[j][k], self.logs[j + 1][k], x - j as f64);
            super::table::lit(log.exp() * fade)
        })
    }
}

/// `f(0) … f(count − 1)` on all cores, in order: the result does not depend on how many there are.
///
/// Where threads cannot be had (wasm) or one dies, the caller's thread does the work.
pub(super) fn in_parallel<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(count);
    let mut slots: Vec<Option<T>> = (0..count).map(|_| None).collect();
    if threads > 1 {
        // Taken one by one, because rows do not cost the same.
        let taken = std::sync::atomic::AtomicUsize::new(0);
        let work = || {
            let next = || Some(taken.fetch_add(1, std::sync::atomic::Ordering::Relaxed)).filter(|&i| i < count);
            std::iter::from_fn(next).map(|i| (i, f(i))).collect::<Vec<_>>()
        };
        std::thread::scope(|scope| {
            let spawn = |_| std::thread::Builder::new().spawn_scoped(scope, work);
            let helpers: Vec<_> = (1..threads).map_while(|i| spawn(i).ok()).collect();
            let mut done = work();
            done.extend(helpers.into_iter().filter_map(|helper| helper.join().ok()).flatten());
            for (i, value) in done {
                slots[i] = Some(value);
            }
        });
    }
    slots.into_iter().enumerate().map(|(i, slot)| slot.unwrap_or_else(|| f(i))).collect()
}
