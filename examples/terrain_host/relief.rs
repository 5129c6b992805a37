//! Height maps, one laid over the other, and nothing where there is none.

use std::path::Path;

use himmel::glam::DVec3;

use crate::Result;

/// Share of a map's width, at each of its edges, over which it passes into the map below.
const BORDER: f64 = 0.1;

/// What stands beside a map's picture.
struct Georeference {
    west_deg: f64,
    north_deg: f64,
    step_east_deg: f64,
    step_south_deg: f64,
}

/// One map, in latitude and longitude.
struct Map {
    at: Georeference,
    columns: usize,
    rows: usize,
    heights_m: Vec<f32>,
}

impl Map {
    /// Reads `NAME.toml` and the 16-bit picture `NAME.png` beside it; `assets/terrain/SOURCE.md` tells of both.
    fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let table: toml::Table = text.parse().map_err(|error| format!("{}: {error}", path.display()))?;
        let number = |key: &str| {
            let value = table.get(key).and_then(|value| value.as_float().or(value.as_integer().map(|i| i as f64)));
            value.ok_or_else(|| format!("{}: the number {key} is missing", path.display()))
        };
        let at = Georeference {
            west_deg: number("west_deg")?,
            north_deg: number("north_deg")?,
            step_east_deg: number("step_east_deg")?,
            step_south_deg: number("step_south_deg")?,
        };
        let (lowest_m, metres_per_unit) = (number("lowest_m")?, number("metres_per_unit")?);
        let picture = image::open(path.with_extension("png"))?.into_luma16();
        let heights_m = picture.pixels().map(|p| (lowest_m + metres_per_unit * f64::from(p.0[0])) as f32).collect();
        Ok(Self { at, columns: picture.width() as usize, rows: picture.height() as usize, heights_m })
    }

    fn wraps(&self) -> bool {
        (self.at.step_east_deg * self.columns as f64 - 360.0).abs() < 1e-6
    }

    /// Height by Catmull–Rom's cubics, so that slopes have no creases, and the map's weight: 0 outside, 1 well inside.
    fn height(&self, latitude_deg: f64, longitude_deg: f64) -> (f64, f64) {
        // Measured from half a pixel outside, so that it stays positive all around a map that wraps.
        let east_deg = (longitude_deg - self.at.west_deg + 0.5 * self.at.step_east_deg).rem_euclid(360.0);
        let column = east_deg / self.at.step_east_deg - 0.5;
        let row = (self.at.north_deg - latitude_deg) / self.at.step_south_deg;
        let inside = |at: f64, count: usize| {
            let last = count as f64 - 1.0;
            (at.min(last - at) / (BORDER * last)).clamp(0.0, 1.0)
        };
        // The poles of a whole globe are no edges.
        let weight = if self.wraps() { 1.0 } else { inside(column, self.columns) * inside(row, self.rows) };
        if weight == 0.0 {
            return (0.0, 0.0);
        }
        let (left, top) = (column.floor(), row.floor());
        let (across, down) = (catmull_rom(column - left), catmull_rom(row - top));
        let mut height = 0.0;
        for (j, down) in down.iter().enumerate() {
            let y = (top as i64 + j as i64 - 1).clamp(0, self.rows as i64 - 1) as usize;
            for (i, across) in across.iter().enumerate() {
                let x = left as i64 + i as i64 - 1;
                let count = self.columns as i64;
                let x = if self.wraps() { x.rem_euclid(count) } else { x.clamp(0, count - 1) };
                height += down * across * f64::from(self.heights_m[y * self.columns + x as usize]);
            }
        }
        (height, weight * weight * (3.0 - 2.0 * weight))
    }
}

/// Weights of four neighbours for a point at `t` between the middle two.
fn catmull_rom(t: f64) -> [f64; 4] {
    [
        0.5 * t * (-1.0 + t * (2.0 - t)),
        0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
        0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
        0.5 * t * t * (t - 1.0),
    ]
}

/// The relief of a planet.
pub struct Relief {
    /// The coarsest first.
    maps: Vec<Map>,
}

impl Relief {
    pub fn load<'a>(paths: impl Iterator<Item = &'a Path>) -> Result<Self> {
        Ok(Self { maps: paths.map(Map::load).collect::<Result<_>>()? })
    }

    /// Height above the datum in a direction from the planet's centre (z: north pole, x: meridian 0), m.
    pub fn height_m(&self, direction: DVec3) -> f64 {
        let latitude_deg = direction.z.clamp(-1.0, 1.0).asin().to_degrees();
        let longitude_deg = direction.y.atan2(direction.x).to_degrees();
        self.maps.iter().fold(0.0, |below, map| {
            let (height, weight) = map.height(latitude_deg, longitude_deg);
            below + weight * (height - below)
        })
    }
}
