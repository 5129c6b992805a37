//! Light scattered many times: six moments of the radiance field over altitude and Sun, and the sky that follows.
//!
//! The field of light at a point, `L(ω)`, matters to scattering only through its moments up to l = 2, if phase
//! functions end there: molecules' do, and aerosols' do once their forward peak counts as not scattered (delta-M
//! [wiscombe1977]). So the whole problem of multiple scattering is a table over altitude and the Sun's zenith angle of
//!
//! G = ∫L dω,  F = ∫L ω dω,  Q = ∫L (ωωᵀ − I/3) dω   (ω: direction of travel; z up, x towards the Sun's azimuth)
//!
//! filled order by order: order k + 1 is what order k scatters into each direction, integrated along the rays.
//! Then [`radiance`] marches one ray: the exact first order, the table's source, the lit ground behind.
//!
//! All light is per unit spectral irradiance of a parallel Sun above the air, its disc excluded.
//!
//! ```
//! use himmel_air::moments::{Moments, Quality, radiance};
//! use himmel_air::{Columns, Preset, single::Ray};
//! let earth = Preset::named("bruneton2017")?;
//! let air = earth.medium.sampled(&[550.0]);
//! let columns = Columns::new(&earth.medium);
//! let quality = Quality { rows: 8, columns: 24, ..Quality::default() }; // a coarse one for a quick example
//! let moments = Moments::build(&air, &columns, &quality);
//! let up = Ray { altitude_m: 0.0, mu: 1.0, mu_s: 0.5, nu: 0.5 };
//! let all = radiance(&air, &columns, &moments, &up, 32)[0];
//! let once = himmel_air::single::march(&air, &columns, &up, 32).radiance_per_sr[0];
//! assert!(all > 1.1 * once && all < 1.5 * once);
//! # Ok::<(), himmel_air::AirError>(())
//! ```
//!
//! What it leaves out: polarisation, refraction, a finite Sun, terrain. With several aerosols the peak that widens the
//! beam is their mean by vertical column, at all altitudes.
//!
//! Known to look wrong: the zenith of Mars with the Sun at the horizon, and thick haze near a low Sun (the forward
//! peak); beneath the clouds of Venus orders fade so slowly that 80 of them are too few: [`Moments::last_change`] stays
//! above the tolerance. The limb of the night side from space, 1e-8 of sunlight, is uncertain by several percent.

mod build;
mod frame;
mod optics;
mod peak;
mod prepared;
mod quality;
mod rays;
mod scaled;
mod table;
#[cfg(test)]
mod tests;

pub use frame::{Irradiance, irradiance, radiance, radiance_to, smooth_radiance};
pub use prepared::{Aerosol, Prepared, Species};
pub use quality::Quality;
pub use scaled::Scaled;
pub use table::sun_columns;

use crate::columns::Columns;
use crate::medium::Sampled;

use build::{Filled, Ground, Scene, in_parallel};
use optics::Optics;
use peak::Peaks;
use table::{FLOOR, Mapping, Six, Table};

/// The moments of all orders of scattering of one medium at N wavelengths, for all altitudes and Suns.
#[derive(Clone, Debug)]
pub struct Moments<const N: usize> {
    optics: Optics<N>,
    peaks: Peaks<N>,
    table: Table<N>,
    ground: Ground<N>,
    orders: usize,
    last_change: f64,
}

/// Largest ratio of an order to the one before in the geometric tail: a conservative cloud's may come close to 1, where
/// the tail would be a guess.
const LARGEST_RATIO: f64 = 0.97;

/// G of this size (the sky with the Sun 9° down) counts half in the question whether the orders have converged; darker
/// texels less: nobody sees a percent there.
const DIM: f64 = 1e-6;

/// What all orders beyond the last will add, relative to the last: q/(1 − q), q the ratio of the last two orders.
///
/// 0 while orders still grow (thick media, at depth). While q rises the tail is an underestimate, and better than none;
/// while it falls an overestimate, which is why the caller goes on until tail and orders agree.
fn tail(before: f64, last: f64) -> f64 {
    if !(before > FLOOR && last > FLOOR) || last > before {
        return 0.0;
    }
    let q = (last / before).min(LARGEST_RATIO);
    q / (1.0 - q)
}

impl<const N: usize> Moments<N> {
    /// Fills the table: order by order until what is left no longer shows, then the geometric tail. Uses all cores; the
    /// result does not depend on how many there are.
    ///
    /// `columns`: of the same medium as `air`. Sizes in `quality` that make no sense are raised to the least that does.
    pub fn build(air: &Sampled<'_, N>, columns: &Columns, quality: &Quality) -> Self {
        let quality = &quality.sane();
        let medium = air.medium;
        let optics = Optics::new(air, quality.legendre_terms);
        let (radius_m, top_m) = (medium.bottom_radius_m, medium.top_altitude_m);
        let peaks = Peaks::new(&medium.components, &optics, top_m, quality.peak_angles, quality.peak_depths);
        let map = Mapping { radius_m, top_m, rows: quality.rows, columns: quality.columns };
        let scene =
            Scene { components: &medium.components, optics: &optics, columns, albedo: air.ground_albedo, map, quality };

        let rows = in_parallel(map.rows, |i| scene.row(i));
        let nothing = || vec![([[0.0; N]; 6], [0.0; N]); map.columns * map.rows];
        let (mut sum, mut total, mut orders, mut last_change) = (nothing(), nothing(), 0, 0.0);
        // The last two orders, the newer last.
        let mut history = [nothing(), nothing()];
        for order in 1..=quality.max_orders {
            let filled: Vec<Filled<N>> = if order == 1 {
                in_parallel(map.rows, |i| scene.first(&rows[i]))
            } else {
                let (before, ground) = tables(map, &history[1], quality.half_floats);
                in_parallel(map.rows, |i| scene.next(&rows[i], &before, &ground))
            };
            history.rotate_left(1);
            history[1] = filled.into_iter().flatten().collect();
            orders = order;
            last_change = 0.0;
            for ((old, new), (sum, all)) in history[0].iter().zip(&history[1]).zip(sum.iter_mut().zip(&mut total)) {
                for k in 0..N {
                    let (before, beyond) = (all.0[0][k], tail(old.0[0][k], new.0[0][k]));
                    for m in 0..6 {
                        sum.0[m][k] += new.0[m][k];
                        all.0[m][k] = sum.0[m][k] + beyond * new.0[m][k];
                    }
                    sum.1[k] += new.1[k];
                    all.1[k] = sum.1[k] + tail(old.1[k], new.1[k]) * new.1[k];
                    let now = all.0[0][k];
                    if now > FLOOR {
                        let change = (now - before).abs() / now / (1.0 + (DIM / now).sqrt());
                        last_change = f64::max(last_change, change);
                    }
                }
            }
            if last_change < quality.tolerance {
                break;
            }
        }
        let (table, ground) = tables(map, &total, quality.half_floats);
        Self { optics, peaks, table, ground, orders, last_change }
    }

    /// The moments at an altitude within the air (clamped to it) with the Sun at a zenith cosine there, all orders
    /// summed: G, F_x, F_z, Q_xx, Q_zz, Q_xz. Unit: per unit irradiance of the Sun, so none.
    ///
    /// F is the net flux of the diffuse light: F_z > 0 is upward. In the scaled medium what aerosols scatter into their
    /// forward peak counts as sunlight, not as diffuse.
    pub fn at(&self, altitude_m: f64, mu_s: f64) -> [[f64; N]; 6] {
        let map = &self.table.mapping;
        self.table.at(map.row(altitude_m), map.suns(altitude_m).coordinate(mu_s))
    }

    /// Irradiance of the level ground, by the Sun (with the light that aerosols scatter into their forward peak) and by
    /// the sky, with the Sun at a zenith cosine.
    ///
    /// `columns`: those the table was built with.
    pub fn ground_irradiance(&self, columns: &Columns, mu_s: f64) -> [f64; N] {
        let mut light = self.ground.at(mu_s);
        if mu_s > 0.0 {
            let (through, _) = self.sun(columns, 0.0, mu_s);
            for k in 0..N {
                light[k] += mu_s * through[k];
            }
        }
        light
    }

    /// Sunlight on a surface that faces the Sun, with what aerosols scatter into their forward peak around it: 0 below the
    /// horizon. `columns`: those the table was built with.
    pub fn sun_with_peaks(&self, columns: &Columns, altitude_m: f64, mu_s: f64) -> [f64; N] {
        let horizon = crate::geometry::horizon_cosine(self.table.mapping.radius_m, altitude_m);
        if mu_s > horizon { self.sun(columns, altitude_m, mu_s).0 } else { [0.0; N] }
    }

    /// Transmittance of the scaled medium from a point to the Sun, which must stand above the horizon, and the optical
    /// depth of the forward peaks on the way.
    fn sun(&self, columns: &Columns, altitude_m: f64, mu_s: f64) -> ([f64; N], [f64; N]) {
        let (mut depth, mut peak) = ([0.0; N], [0.0; N]);
        columns.for_each_column(altitude_m, mu_s, |component, column_m| {
            if let Some(s) = self.optics.scatterers.get(component) {
                for k in 0..N {
                    depth[k] += column_m * (s.extinction_per_m[k] - s.peak_per_m[k]);
                    peak[k] += column_m * s.peak_per_m[k];
                }
            }
        });
        (depth.map(|depth| (-depth).exp()), peak)
    }

    /// How many orders were computed; the tail is the rest.
    pub fn orders(&self) -> usize {
        self.orders
    }

    /// Largest relative change of G by the last order (tail included, dark texels counted less): above
    /// `Quality::tolerance` only if the orders ran out first.
    pub fn last_change(&self) -> f64 {
        self.last_change
    }

    /// How well the series of the aerosols' forward peaks has converged: the share of its terms' sum in the last tenth
    /// of them. Above 0.01 the aureole in thick haze lacks its finest core; more `Quality::legendre_terms` help.
    pub fn peak_remainder(&self) -> f64 {
        self.peaks.remainder
    }
}

fn tables<const N: usize>(map: Mapping, texels: &[(Six<N>, [f64; N])], half: bool) -> (Table<N>, Ground<N>) {
    let moments: Vec<_> = texels.iter().map(|texel| texel.0).collect();
    let ground = Ground::new(&map, texels.iter().take(map.columns).map(|texel| texel.1), half);
    (Table::new(map, &moments, half), ground)
}
