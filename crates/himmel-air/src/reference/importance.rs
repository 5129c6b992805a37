//! Where light is worth looking for: a coarse solution that only steers chance. It changes the noise of an answer, never
//! its mean (tested: without it the answers are the same within their errors).

use std::f64::consts::PI;

use glam::DVec3;
use himmel_core::quadrature::gauss_legendre_unit;

use super::first::{Scratch, transmittance_to};
use super::line::Line;
use super::optics::Optics;
use crate::geometry::horizon_cosine;

const ROWS: usize = 20;
const COLUMNS: usize = 56;
/// Zenith cosines relative to the horizon's that the table spans, and how much it crowds about the horizon.
const LOW: f64 = -0.6;
const HIGH: f64 = 2.0;
const CROWD: f64 = 0.1;
/// Orders are summed until one adds less than this share to the light anywhere, or there are so many; the rest is a geometric
/// tail. (Four were too few beneath an optical depth of 20: paths that the solution had no hope for died there, and the rare
/// survivors were so heavy that no error told of them.)
const CONVERGED: f64 = 0.02;
const ORDERS: usize = 100;

/// Actinic flux (light from all sides) per unit irradiance of a source, over altitude and the source's zenith cosine, as
/// if everything scattered evenly and forward peaks were no scattering at all.
pub(super) struct Importance {
    radius_m: f64,
    top_m: f64,
    /// ln of direct and diffuse light together, and of diffuse light alone.
    log: Option<Tables>,
}

struct Tables {
    total: Vec<f64>,
    diffuse: Vec<f64>,
}

/// Row and column of a point, and the weights of the next ones.
type Place = (usize, usize, f64, f64);

impl Importance {
    /// The same everywhere.
    pub fn even<const N: usize>(optics: &Optics<N>) -> Self {
        Self { radius_m: optics.radius_m, top_m: optics.top_m, log: None }
    }

    /// Solved at one of the wavelengths, `k`.
    pub fn solve<const N: usize>(optics: &Optics<N>, k: usize) -> Self {
        let mut importance = Self::even(optics);
        let mut scratch = Scratch::new(optics);
        let count = optics.components.len();
        let mut densities = vec![0.0; count];
        let node = |row: usize, column: usize| {
            let altitude_m = optics.top_m * (row as f64 / (ROWS - 1) as f64).powi(2);
            let (low, high) = (squash(LOW), squash(HIGH));
            let u = low + (high - low) * column as f64 / (COLUMNS - 1) as f64;
            let x = CROWD * u / (1.0 - u.abs());
            (altitude_m, (x + horizon_cosine(optics.radius_m, altitude_m)).clamp(-1.0, 1.0))
        };
        let mut direct = vec![0.0; ROWS * COLUMNS];
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let (altitude_m, mu_s) = node(row, column);
                let sun = DVec3::new((1.0 - mu_s * mu_s).max(0.0).sqrt(), 0.0, mu_s);
                let point = DVec3::Z * (optics.radius_m + altitude_m);
                direct[row * COLUMNS + column] = transmittance_to(optics, point, sun, &mut scratch)[k];
            }
        }
        let mut diffuse = vec![0.0; ROWS * COLUMNS];
        // Lines of each row: solid angle, and for each cell where it lies and how much it scatters towards the row.
        let directions = |altitude_m: f64| {
            let horizon = horizon_cosine(optics.radius_m, altitude_m);
            let panel = |count: usize, to: f64| {
                gauss_legendre_unit(count)
                    .into_iter()
                    .map(move |(s, w)| (horizon + (to - horizon) * s * s, (to - horizon).abs() * 2.0 * s * w))
            };
            panel(6, 1.0).chain(panel(4, -1.0)).collect::<Vec<_>>()
        };
        let mut lines = Vec::new();
        for row in 0..ROWS {
            let (altitude_m, _) = node(row, 0);
            for (mu, weight) in directions(altitude_m) {
                let sin = (1.0 - mu * mu).max(0.0).sqrt();
                let line = Line::new(optics, DVec3::Z * (optics.radius_m + altitude_m), DVec3::new(sin, 0.0, mu));
                line.cut(optics, 1.0, &mut scratch.edges);
                let (mut depth, mut cells) = (0.0f64, Vec::new());
                for pair in scratch.edges.windows(2) {
                    let (length, t) = (pair[1] - pair[0], 0.5 * (pair[0] + pair[1]));
                    optics.densities(line.altitude_m(t), &mut densities);
                    let (mut scattering, mut extinction) = (0.0, 0.0);
                    for (density, component) in densities.iter().zip(&optics.components) {
                        let forward = component.lobe.as_ref().map_or(0.0, |lobe| lobe.mean_cosine[k].max(0.0));
                        let scattered = density * component.scattering_per_m[k];
                        scattering += scattered * (1.0 - forward);
                        extinction += density * component.extinction_per_m[k] - scattered * forward;
                    }
                    let through = (-extinction * length).exp();
                    let share = if extinction * length > 1e-9 { (1.0 - through) / extinction } else { length };
                    cells.push((t, line.altitude_m(t), (-depth).exp() * share * scattering / (4.0 * PI)));
                    depth += extinction * length;
                }
                lines.push((row, line, weight, cells, if line.ground { (-depth).exp() } else { 0.0 }));
            }
        }
        let mut before = direct.clone();
        for order in 1..=ORDERS {
            importance.log = Some(Tables { total: logarithms(&before), diffuse: Vec::new() });
            let tables = importance.log.as_ref();
            let mut now = vec![0.0; ROWS * COLUMNS];
            for (row, line, weight, cells, to_ground) in &lines {
                for column in 0..COLUMNS {
                    let (altitude_m, mu_s) = node(*row, column);
                    let sin_s = (1.0 - mu_s * mu_s).max(0.0).sqrt();
                    // Four azimuths over half a circle; the other half is the same.
                    for j in 0..4 {
                        let azimuth = PI * (f64::from(j) + 0.5) / 4.0;
                        let sun = DVec3::new(sin_s * azimuth.cos(), sin_s * azimuth.sin(), mu_s);
                        let nu = line.direction.dot(sun);
                        let mu_at = |t: f64, altitude_at: f64| {
                            ((optics.radius_m + altitude_m) * mu_s + t * nu) / (optics.radius_m + altitude_at)
                        };
                        let mut sum = 0.0;
                        for (t, altitude_at, share) in cells {
                            let place = importance.place(*altitude_at, mu_at(*t, *altitude_at));
                            sum += share * tables.map_or(0.0, |t| read(&t.total, place).exp());
                        }
                        if *to_ground > 0.0 {
                            let mu_ground = mu_at(line.end_m, 0.0);
                            let place = importance.place(0.0, mu_ground);
                            let light = tables.map_or(0.0, |t| read(&t.total, place).exp());
                            let falls = if order == 1 { mu_ground.max(0.0) } else { 0.5 };
                            sum += to_ground * optics.albedo[k] / PI * falls * light;
                        }
                        now[row * COLUMNS + column] += sum * weight * PI / 2.0;
                    }
                }
            }
            let mut largest: f64 = 0.0;
            for i in 0..diffuse.len() {
                diffuse[i] += now[i];
                largest = largest.max(now[i] / (direct[i] + diffuse[i]).max(1e-12));
            }
            let last = largest < CONVERGED || order == ORDERS;
            if last {
                for i in 0..diffuse.len() {
                    let ratio = if before[i] > 0.0 { (now[i] / before[i]).min(0.97) } else { 0.0 };
                    diffuse[i] += now[i] * ratio / (1.0 - ratio);
                }
                break;
            }
            before = now;
        }
        let total: Vec<f64> = direct.iter().zip(&diffuse).map(|(a, b)| a + b).collect();
        importance.log = Some(Tables { total: logarithms(&total), diffuse: logarithms(&diffuse) });
        importance
    }

    fn place(&self, altitude_m: f64, mu_s: f64) -> Place {
        let y = (altitude_m / self.top_m).clamp(0.0, 1.0).sqrt() * (ROWS - 1) as f64;
        let (low, high) = (squash(LOW), squash(HIGH));
        let u = (squash(mu_s - horizon_cosine(self.radius_m, altitude_m)) - low) / (high - low);
        let x = u.clamp(0.0, 1.0) * (COLUMNS - 1) as f64;
        let (row, column) = ((y as usize).min(ROWS - 2), (x as usize).min(COLUMNS - 2));
        (row, column, y - row as f64, x - column as f64)
    }

    /// Direct and diffuse light at an altitude, for a source of a zenith cosine there.
    pub fn total(&self, altitude_m: f64, mu_s: f64) -> f64 {
        self.log.as_ref().map_or(1.0, |tables| read(&tables.total, self.place(altitude_m, mu_s)).exp())
    }

    /// Diffuse light alone.
    pub fn diffuse(&self, altitude_m: f64, mu_s: f64) -> f64 {
        self.log.as_ref().map_or(1.0, |tables| read(&tables.diffuse, self.place(altitude_m, mu_s)).exp())
    }
}

fn squash(x: f64) -> f64 {
    x / (x.abs() + CROWD)
}

/// 1e-12 of full light is a night: keeps logarithms finite.
fn logarithms(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.max(1e-12).ln()).collect()
}

fn read(table: &[f64], (row, column, fy, fx): Place) -> f64 {
    let line = |row: usize| {
        let (a, b) = (table[row * COLUMNS + column], table[row * COLUMNS + column + 1]);
        a + fx * (b - a)
    };
    let (a, b) = (line(row), line(row + 1));
    a + fy * (b - a)
}
