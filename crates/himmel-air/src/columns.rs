//! Optical depth: how much air lies along a ray to space.

use himmel_core::quadrature::gauss_legendre_unit;

use crate::geometry::{altitude_along, depth_table_ray, depth_table_uv, horizon_cosine, top_distance};
use crate::medium::{Medium, Sampled};

/// Columns of each component along rays to space, tabulated by altitude and zenith angle.
///
/// A column is ∫ profile dt in metres: it knows no wavelength and no amount, so one table serves every spectrum and
/// survives a change of concentrations. Logarithms are stored, because they are nearly linear in altitude.
pub struct Columns {
    bottom_radius_m: f64,
    top_altitude_m: f64,
    width: usize,
    height: usize,
    /// ln of the column in metres, `[component][y][x]`.
    log_columns: Vec<Vec<f64>>,
}

/// Width of the table: directions (the distance to the top of the air).
pub const WIDTH: usize = 128;
/// Height of the table: altitudes.
pub const HEIGHT: usize = 64;

/// Gauss nodes on either side of the point nearest to the ground.
const NODES: usize = 40;

/// Columns below this many metres are nothing: keeps the logarithm finite.
const FLOOR_M: f64 = 1e-12;

/// The column of each component along a ray to space by quadrature, metres. `mu` must clear the horizon.
///
/// The distance is substituted by t = t_c + s|s| around the point nearest to the ground, which makes the integrand of
/// an exponential atmosphere a Gaussian in s; Gauss–Legendre on either side.
///
/// `rule`: nodes and weights on 0..1 for each of the two sides.
pub fn columns_by_quadrature(medium: &Medium, altitude_m: f64, mu: f64, rule: &[(f64, f64)]) -> Vec<f64> {
    let radius_m = medium.bottom_radius_m;
    let length = top_distance(radius_m, medium.top_altitude_m, altitude_m, mu);
    let nearest = (-(radius_m + altitude_m) * mu).clamp(0.0, length);
    let mut sums = vec![0.0; medium.components.len()];
    for (side, extent) in [(-1.0, nearest.sqrt()), (1.0, (length - nearest).sqrt())] {
        if extent == 0.0 {
            continue;
        }
        for (x, w) in rule {
            let s = x * extent;
            let h = altitude_along(radius_m, altitude_m, mu, nearest + side * s * s);
            for (sum, component) in sums.iter_mut().zip(&medium.components) {
                *sum += w * extent * 2.0 * s * component.profile.at(h);
            }
        }
    }
    sums
}

impl Columns {
    /// Integrates the table, [`WIDTH`] × [`HEIGHT`].
    pub fn new(medium: &Medium) -> Self {
        Self::with_size(medium, WIDTH, HEIGHT)
    }

    /// A table of another size (at least 2 × 2): for measuring what the usual size costs.
    pub fn with_size(medium: &Medium, width: usize, height: usize) -> Self {
        let (width, height) = (width.max(2), height.max(2));
        let rule = gauss_legendre_unit(NODES);
        let mut log_columns = vec![vec![0.0; width * height]; medium.components.len()];
        for y in 0..height {
            for x in 0..width {
                let (u, v) = (x as f64 / (width - 1) as f64, y as f64 / (height - 1) as f64);
                let (altitude_m, mu) = depth_table_ray(medium.bottom_radius_m, medium.top_altitude_m, u, v);
                let columns = columns_by_quadrature(medium, altitude_m, mu, &rule);
                for (table, column) in log_columns.iter_mut().zip(columns) {
                    table[y * width + x] = column.max(FLOOR_M).ln();
                }
            }
        }
        let (bottom_radius_m, top_altitude_m) = (medium.bottom_radius_m, medium.top_altitude_m);
        Self { bottom_radius_m, top_altitude_m, width, height, log_columns }
    }

    /// The column of one component at a node of the table, metres.
    pub fn node_m(&self, component: usize, x: usize, y: usize) -> f64 {
        self.log_columns[component][y * self.width + x].exp()
    }

    /// Optical depth to space. Directions below the horizon are taken as the horizon: the caller decides about shadow.
    pub fn optical_depth<const N: usize>(&self, air: &Sampled<'_, N>, altitude_m: f64, mu: f64) -> [f64; N] {
        let mut depth = [0.0; N];
        self.for_each_column(altitude_m, mu, |component, column_m| {
            if let Some(component) = air.components.get(component) {
                for i in 0..N {
                    depth[i] += column_m * component.extinction_per_m[i];
                }
            }
        });
        depth
    }

    /// Calls `f` with the index of each component and its column to space in metres. Directions below the horizon are
    /// taken as the horizon.
    pub fn for_each_column(&self, altitude_m: f64, mu: f64, mut f: impl FnMut(usize, f64)) {
        let altitude_m = altitude_m.clamp(0.0, self.top_altitude_m);
        let mu = mu.max(horizon_cosine(self.bottom_radius_m, altitude_m));
        let (u, v) = depth_table_uv(self.bottom_radius_m, self.top_altitude_m, altitude_m, mu);
        let (x, y) = (u * (self.width - 1) as f64, v * (self.height - 1) as f64);
        let (x0, y0) = ((x as usize).min(self.width - 2), (y as usize).min(self.height - 2));
        let (fx, fy) = (x - x0 as f64, y - y0 as f64);
        for (component, table) in self.log_columns.iter().enumerate() {
            let row = |y: usize| table[y * self.width + x0] * (1.0 - fx) + table[y * self.width + x0 + 1] * fx;
            f(component, (row(y0) * (1.0 - fy) + row(y0 + 1) * fy).exp());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    /// Between nodes the table keeps 99 % of all transmittances within 0.002 of quadrature, for every preset. (Absolute,
    /// because a transmittance of nothing stays nothing.) The worst, 0.0105, are rays that graze the upper kink of
    /// `bruneton2017`'s tent of ozone at 40 km, where the logarithm of its column falls off a cliff.
    #[test]
    fn table_agrees_with_quadrature_between_nodes() {
        for name in crate::preset::names() {
            let preset = Preset::named(name).unwrap();
            let medium = &preset.medium;
            let air = medium.sampled(&[430.0, 550.0, 680.0]);
            let columns = Columns::new(medium);
            let mut errors = Vec::new();
            let rule = gauss_legendre_unit(128);
            for i in 0..40 {
                for j in 0..60 {
                    let (u, v) = ((f64::from(i) + 0.37) / 40.0, (f64::from(j) + 0.61) / 61.0);
                    let (h, mu) = depth_table_ray(medium.bottom_radius_m, medium.top_altitude_m, u, v);
                    let exact = columns_by_quadrature(medium, h, mu, &rule);
                    let table = columns.optical_depth(&air, h, mu);
                    for k in 0..3 {
                        let depth: f64 =
                            exact.iter().zip(&air.components).map(|(column, c)| column * c.extinction_per_m[k]).sum();
                        errors.push(((-table[k]).exp() - (-depth).exp()).abs());
                    }
                }
            }
            errors.sort_by(f64::total_cmp);
            let (p99, worst) = (errors[errors.len() * 99 / 100], errors[errors.len() - 1]);
            // A layer of droplets that ends like a bell (`earth-volcanic`: 0.007) costs more; the deck of `venus`, of
            // optical depth 30 with kinks, costs 0.021, and single rays along its upper edge are wrong altogether.
            let (bound_p99, bound_worst) = match name {
                "earth-volcanic" => (8e-3, 1.5e-2),
                "venus" => (3e-2, 1.0),
                _ => (2e-3, 1.5e-2),
            };
            assert!(p99 < bound_p99 && worst <= bound_worst, "{name}: {p99:e} {worst:e}");
        }
    }

    /// Vertical depths of `bruneton2017` at 550 nm that `cli.md` states: 5.328e-3, 2.82135e-2, 0.108402.
    #[test]
    fn vertical_depths_of_the_comparison_atmosphere() {
        let preset = Preset::named("bruneton2017").unwrap();
        let air = preset.medium.sampled(&[550.0]);
        let columns = columns_by_quadrature(&preset.medium, 0.0, 1.0, &gauss_legendre_unit(200));
        for (name, stated) in [("air", 0.108402), ("aerosol", 5.328e-3), ("ozone", 2.82135e-2)] {
            let i = preset.medium.components.iter().position(|c| c.name == name).unwrap();
            let depth = columns[i] * air.components[i].extinction_per_m[0];
            assert!((depth / stated - 1.0).abs() < 2e-3, "{name}: {depth}");
        }
    }
}
