//! The moment table: where its texels stand, and how it is read.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::geometry::excess;

/// Smallest G that is stored: keeps the logarithm finite. Far darker than any night.
pub(super) const FLOOR: f64 = 1e-30;

/// What stands on the floor is nothing. The tenth above it covers the rounding of its logarithm to half floats.
pub(super) fn lit(light: f64) -> f64 {
    if light > 1.1 * FLOOR { light } else { 0.0 }
}

/// Six moments at N wavelengths: G, F_x, F_z, Q_xx, Q_zz, Q_xz.
pub(super) type Six<const N: usize> = [[f64; N]; 6];

/// Where the texels of a table stand: rows over altitude, columns over the Sun's elevation above the local horizon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapping {
    pub radius_m: f64,
    pub top_m: f64,
    pub rows: usize,
    pub columns: usize,
}

/// The Sun's coordinate at one altitude.
#[derive(Clone, Copy, Debug)]
pub(super) struct Suns {
    dip_rad: f64,
    /// The lowest Sun of the table, relative to the horizon (negative).
    lowest_rad: f64,
    a: f64,
    b: f64,
}

/// Width w and centre x₀ of the crowd of columns: twilight, where the sky changes fastest.
const WIDTH_RAD: f64 = 5.0 * PI / 180.0;
const CENTRE_RAD: f64 = -3.0 * PI / 180.0;

impl Mapping {
    /// Altitude of a row: h = H (i/(rows − 1))², m. The last row stands just under the top, so that it sees air.
    pub fn altitude_m(&self, row: usize) -> f64 {
        let v = row as f64 / (self.rows - 1) as f64;
        self.top_m * (v * v).min(0.9999)
    }

    /// Row coordinate of an altitude, 0..=rows − 1.
    pub fn row(&self, altitude_m: f64) -> f64 {
        (altitude_m / self.top_m).clamp(0.0, 1.0).sqrt() * (self.rows - 1) as f64
    }

    /// How the columns lie at an altitude.
    ///
    /// u = (asinh((x − x₀)/w) − a)/(b − a) with x = asin µ_s + dip,
    /// a = asinh((−X − x₀)/w), b = asinh((π/2 + dip − x₀)/w)
    ///
    /// dip: how far the horizon lies below the level, rad.  X: depth of the lowest Sun, 2.5 times the depth at which
    /// the top of the air over the ground loses it, or the nadir.
    pub fn suns(&self, altitude_m: f64) -> Suns {
        let altitude_m = altitude_m.clamp(0.0, self.top_m);
        let dip_rad = (excess(self.radius_m, altitude_m).sqrt() / (self.radius_m + altitude_m)).min(1.0).asin();
        let night = 2.5 * (self.radius_m / (self.radius_m + self.top_m)).acos();
        let lowest_rad = -night.min(FRAC_PI_2 - dip_rad);
        let a = ((lowest_rad - CENTRE_RAD) / WIDTH_RAD).asinh();
        let b = ((FRAC_PI_2 + dip_rad - CENTRE_RAD) / WIDTH_RAD).asinh();
        Suns { dip_rad, lowest_rad, a, b }
    }
}

/// How the columns of the moment table lie at an altitude: dip of the horizon and lowest Sun (rad), a, 1/(b − a); see
/// `Mapping::suns`. What the renderer tabulates over altitude.
pub fn sun_columns(radius_m: f64, top_m: f64, altitude_m: f64) -> [f64; 4] {
    let suns = Mapping { radius_m, top_m, rows: 2, columns: 2 }.suns(altitude_m);
    [suns.dip_rad, suns.lowest_rad, suns.a, 1.0 / (suns.b - suns.a)]
}

impl Suns {
    /// Column coordinate 0..=1 of a zenith cosine, and a factor on the light: 1 in the table; below its lowest Sun the
    /// coordinate stays and the factor falls to 0 over five degrees.
    pub fn coordinate(&self, mu_s: f64) -> (f64, f64) {
        let x = mu_s.clamp(-1.0, 1.0).asin() + self.dip_rad;
        let u = (((x - CENTRE_RAD) / WIDTH_RAD).asinh() - self.a) / (self.b - self.a);
        if u >= 0.0 {
            return (u.min(1.0), 1.0);
        }
        let fade = (1.0 + (x - self.lowest_rad) / WIDTH_RAD).clamp(0.0, 1.0);
        (0.0, fade * fade)
    }

    /// Zenith cosine of a column coordinate.
    pub fn mu_s(&self, u: f64) -> f64 {
        let x = CENTRE_RAD + WIDTH_RAD * (self.a + u * (self.b - self.a)).sinh();
        (x - self.dip_rad).clamp(-FRAC_PI_2, FRAC_PI_2).sin()
    }
}

/// Moments over altitude and Sun: ln G and the ratios to G of the five others, which interpolate better than they.
#[derive(Clone, Debug)]
pub(super) struct Table<const N: usize> {
    pub mapping: Mapping,
    /// `[row][column]`, `rows * columns` of them.
    texels: Vec<Six<N>>,
}

impl<const N: usize> Table<N> {
    /// From the moments themselves. `half`: rounds what is stored to half floats.
    pub fn new(mapping: Mapping, moments: &[Six<N>], half: bool) -> Self {
        let round = |x: f64| if half { half::f16::from_f64(x).to_f64() } else { x };
        let texel = |raw: &Six<N>| {
            let mut stored = [[0.0; N]; 6];
            for k in 0..N {
                let g = raw[0][k];
                stored[0][k] = round(g.max(FLOOR).ln());
                if g > FLOOR {
                    for m in 1..6 {
                        // No light has |F| > G or |Q| > G; an undershoot of the polynomial phase could.
                        stored[m][k] = round((raw[m][k] / g).clamp(-1.0, 1.0));
                    }
                }
            }
            stored
        };
        let mut texels: Vec<_> = moments.iter().map(texel).collect();
        texels.resize(mapping.rows * mapping.columns, [[0.0; N]; 6]);
        Self { mapping, texels }
    }

    /// The moments at a row coordinate and a column coordinate with its fade: bilinear in what is stored, then
    /// multiplied.
    pub fn at(&self, row: f64, (u, fade): (f64, f64)) -> Six<N> {
        let (rows, columns) = (self.mapping.rows, self.mapping.columns);
        let column = u * (columns - 1) as f64;
        let (i, j) = ((row as usize).min(rows - 2), (column as usize).min(columns - 2));
        let (y, x) = (row - i as f64, column - j as f64);
        let corner = i * columns + j;
        let near = [
            (corner, (1.0 - y) * (1.0 - x)),
            (corner + 1, (1.0 - y) * x),
            (corner + columns, y * (1.0 - x)),
            (corner + columns + 1, y * x),
        ];
        let mut moments = [[0.0; N]; 6];
        for (index, weight) in near {
            let texel = &self.texels[index];
            for m in 0..6 {
                for k in 0..N {
                    moments[m][k] += weight * texel[m][k];
                }
            }
        }
        for k in 0..N {
            let g = lit(moments[0][k].exp() * fade);
            moments[0][k] = g;
            for m in 1..6 {
                moments[m][k] *= g;
            }
        }
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mappings() -> [Mapping; 4] {
        // The Earth, a Titan whose night the table covers whole, a plane, a moonlet.
        [(6.36e6, 6e4), (2.575e6, 5e5), (6.36e9, 6e4), (4e5, 2e5)].map(|(radius_m, top_m)| Mapping {
            radius_m,
            top_m,
            rows: 32,
            columns: 64,
        })
    }

    #[test]
    fn the_mapping_inverts() {
        for mapping in mappings() {
            for row in 0..mapping.rows {
                let h = mapping.altitude_m(row);
                assert!((mapping.row(h) - row as f64).abs() < 2e-3, "{row}");
                let suns = mapping.suns(h);
                for column in 0..64 {
                    let u = f64::from(column) / 63.0;
                    let (back, fade) = suns.coordinate(suns.mu_s(u));
                    // asin loses half the digits at the zenith.
                    assert!((back - u).abs() < 1e-6 && (fade == 1.0 || u == 0.0), "{h} {u}: {back}");
                }
                assert!((suns.mu_s(1.0) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn texels_are_read_back_and_the_night_fades() {
        let mapping = mappings()[0];
        let value = |i: usize, j: usize| [[1e-3 * (1 + i + 2 * j) as f64], [1e-4], [-2e-4], [3e-4], [0.0], [-1e-5]];
        let raw: Vec<_> = (0..32).flat_map(|i| (0..64).map(move |j| value(i, j))).collect();
        let table = Table::new(mapping, &raw, false);
        for (i, j) in [(0, 0), (31, 63), (7, 20)] {
            let read = table.at(i as f64, (j as f64 / 63.0, 1.0));
            for m in 0..6 {
                assert!((read[m][0] - value(i, j)[m][0]).abs() < 1e-15, "{i} {j}: {read:?}");
            }
        }
        let suns = mapping.suns(0.0);
        assert_eq!(suns.coordinate(-1.0), (0.0, 0.0));
        assert!(suns.coordinate(suns.mu_s(0.0) - 0.02).1 < 1.0);
        let night = Table::new(mapping, &vec![[[0.0]; 6]; 32 * 64], false);
        assert_eq!(night.at(3.3, (0.4, 1.0)), [[0.0]; 6]);
    }
}
