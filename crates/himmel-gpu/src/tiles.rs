//! A picture in tiles, so that each is drawn by a pipeline that has what its pixels need and nothing else.
//!
//! Rasterisers on CPUs run every branch of a shader, and GPUs keep registers for the largest: most pixels of a sky are
//! far from its lights and from the horizon, and need neither.

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;

use crate::error::GpuError;
use crate::frame::MOST_LIGHTS;
use crate::view::View;

/// Tiles along the sides of a picture. Cells are whole pixels in 1280 × 720, 1920 × 1080 and their multiples: drivers place
/// corners at sixteenths of a pixel (SwiftShader) or finer, and what is interpolated between them is off by half of that,
/// which shows at the horizon.
const TILES: [usize; 2] = [16, 18];
/// Tiles with a disc, the Moon or the horizon are divided into so many cells a side, as far as there is room for the rectangles.
const DIVISION: usize = 4;
/// Cells along the sides of a picture; the same in `sky.wgsl`.
const CELLS: [usize; 2] = [TILES[0] * DIVISION, TILES[1] * DIVISION];
/// Room for what reaches out of its cell into pixels beside it: a disc smaller than a pixel is widened to one, the horizon
/// is mixed over a pixel. In pixels where their size is known, else as a share of a tile's reach, enough from 40 rows on.
const WIDENED_PX: f64 = 3.0;
const WIDENED: f64 = 0.4;

/// Angle to a light up to which its aureole is drawn, rad; the same in `sky_view_table.wgsl`.
const AUREOLE_TO: f64 = 0.35;

/// Discs of a frame: of every light, and the Moon's.
const MOST_DISCS: usize = MOST_LIGHTS + 1;

/// What pixels may have to draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Needs {
    /// The horizon, where ground and sky are mixed in a pixel.
    pub horizon: bool,
    /// What surrounds a light in the air.
    pub aureole: bool,
    /// The disc of a light; with it always everything.
    pub disc: bool,
    /// The Moon's disc.
    pub moon: bool,
}

impl Needs {
    /// All of it.
    pub(crate) const ALL: Self = Self { horizon: true, aureole: true, disc: true, moon: true };
    /// Every set of needs that a tile may have, cheapest first.
    pub(crate) const SETS: [Self; 7] = [
        Self { horizon: false, aureole: false, disc: false, moon: false },
        Self { horizon: true, aureole: false, disc: false, moon: false },
        Self { horizon: false, aureole: true, disc: false, moon: false },
        Self { horizon: true, aureole: true, disc: false, moon: false },
        // The Moon far from the Sun by day; at night it is itself a light with an aureole.
        Self { horizon: false, aureole: false, disc: false, moon: true },
        Self { horizon: false, aureole: true, disc: false, moon: true },
        Self::ALL,
    ];
}

/// A light, for the tiles around it.
pub(crate) struct TileLight {
    /// Unit vector towards it, east-north-up: its aureole; `None`: it has none.
    pub direction: Option<DVec3>,
    /// Whether it is the Moon's disc.
    pub moon: bool,
    /// Unit vector towards its disc.
    pub disc_direction: DVec3,
    /// Radius of all that is drawn with the disc, rad.
    pub reach_rad: f64,
}

/// Rectangles of cells, those with the same needs together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tiles {
    /// First and last corner in cells: x₀, y₀, x₁, y₁ a byte each, from the lowest.
    pub rectangles: [[[u32; 4]; 12]; 6],
    /// Which rectangles have each of [`Needs::SETS`].
    pub ranges: [Range<u32>; 7],
}

/// As many as there are tiles: undivided ones always have room.
const MOST_RECTANGLES: usize = TILES[0] * TILES[1];

impl Tiles {
    /// Sorts a view's tiles. `up`: the zenith, east-north-up. `horizon`: elevation of the horizon, rad. `clear`: what tiles
    /// without the horizon keep clear of it, as a share of the angle that a tile reaches from its middle.
    pub(crate) fn new(
        view: &View,
        up: DVec3,
        horizon: f64,
        lights: &[TileLight],
        clear: f64,
    ) -> Result<Self, GpuError> {
        let around = Around { clear, ..Around::new(view, up, horizon, lights)? };
        let merged = Self::merged(&around.sort(DIVISION)).or_else(|| Self::merged(&around.sort(1)));
        Ok(merged.unwrap_or_default())
    }

    /// Runs of cells with the same needs, grown over the rows; `None`: more than there is room for.
    fn merged(cells: &[Needs]) -> Option<Self> {
        let mut tiles = Self::default();
        let mut count = 0;
        for (set, range) in Needs::SETS.iter().zip(&mut tiles.ranges) {
            let from = count;
            // x₀, y₀, x₁, y₁ of rectangles that end at the row below.
            let mut open: Vec<[usize; 4]> = Vec::new();
            let mut done: Vec<[usize; 4]> = Vec::new();
            for (y, row) in cells.chunks(CELLS[0]).enumerate() {
                let mut grown = Vec::new();
                let mut x = 0;
                while x < CELLS[0] {
                    let length = row[x..].iter().take_while(|needs| *needs == set).count();
                    if length > 0 {
                        let below = open.iter().position(|r| r[0] == x && r[2] == x + length);
                        let first_row = below.map_or(y, |index| open.swap_remove(index)[1]);
                        grown.push([x, first_row, x + length, y + 1]);
                    }
                    x += length.max(1);
                }
                done.append(&mut open);
                open = grown;
            }
            done.append(&mut open);
            for corners in done {
                let place = (count < MOST_RECTANGLES).then_some([count / 48, count / 4 % 12, count % 4])?;
                let packed = corners.iter().rev().fold(0, |sum, &value| sum << 8 | value as u32);
                tiles.rectangles[place[0]][place[1]][place[2]] = packed;
                count += 1;
            }
            *range = from as u32..count as u32;
        }
        Some(tiles)
    }
}

/// A view and what is around it.
struct Around<'a> {
    view: &'a View,
    rays: [DVec3; 3],
    up: DVec3,
    horizon: f64,
    lights: &'a [TileLight],
    /// What tiles beside the horizon keep clear of it, as a share of the reach.
    clear: f64,
    /// The largest angle from the middle of a tile to its corners, with a tenth to spare, rad.
    reach: f64,
}

impl<'a> Around<'a> {
    fn new(view: &'a View, up: DVec3, horizon: f64, lights: &'a [TileLight]) -> Result<Self, GpuError> {
        let mut around = Self { view, rays: view.rays()?, up, horizon, lights, clear: 0.0, reach: 0.0 };
        let [columns, rows] = TILES;
        let mut reach: f64 = 0.0;
        // Tiles are widest in the middle or at an edge of a picture, never in between.
        for x in [0, columns / 2, columns - 1] {
            for y in [0, rows / 2, rows - 1] {
                let (x, y) = (x as f64, y as f64);
                let Some(middle) = around.at([x + 0.5, y + 0.5]) else { continue };
                for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                    reach = reach.max(around.at([x + dx, y + dy]).map_or(0.0, |corner| middle.angle_between(corner)));
                }
            }
        }
        around.reach = 1.1 * reach + 1e-3;
        Ok(around)
    }

    /// Where a place in tiles looks; `None` outside the picture.
    fn at(&self, place: [f64; 2]) -> Option<DVec3> {
        let [left, bottom, width, height] = self.view.part;
        let ndc = |from: f64, size: f64, share: f64| 2.0 * (from + size * share) - 1.0;
        let [x, y] = [place[0] / TILES[0] as f64, place[1] / TILES[1] as f64];
        self.view.along(&self.rays, [ndc(left, width, x), ndc(bottom, height, y)])
    }

    /// What each cell needs; all cells of a tile alike, but where tiles are divided.
    fn sort(&self, division: usize) -> Vec<Needs> {
        let (of_tile, of_cell) = (self.limits(self.reach), self.limits(self.reach / DIVISION as f64));
        let mut cells = vec![Needs::default(); CELLS[0] * CELLS[1]];
        for index in 0..TILES[0] * TILES[1] {
            let corner = [index % TILES[0], index / TILES[0]];
            let whole = self.needs(self.at(corner.map(|x| x as f64 + 0.5)), &of_tile);
            let divided = division > 1 && (whole.disc || whole.horizon || whole.moon) && self.reach <= 1.0;
            for inner in 0..DIVISION * DIVISION {
                let inside = [inner % DIVISION, inner / DIVISION];
                let cell = [0, 1].map(|i| corner[i] * DIVISION + inside[i]);
                cells[cell[1] * CELLS[0] + cell[0]] = if divided {
                    self.needs(self.at(cell.map(|x| (x as f64 + 0.5) / DIVISION as f64)), &of_cell)
                } else {
                    whole
                };
            }
        }
        cells
    }

    /// Up to where the middle of a tile or cell is near enough.
    fn limits(&self, reach: f64) -> Limits {
        let rows = f64::from(self.view.rows_px);
        let widened = if rows > 0.0 {
            // Pixels from the middle of a tile to its corners.
            let across = (rows * self.view.part[2] * self.view.aspect / TILES[0] as f64)
                .hypot(rows * self.view.part[3] / TILES[1] as f64);
            WIDENED_PX * self.reach / (0.5 * across)
        } else {
            WIDENED * self.reach
        };
        let widened = reach + widened;
        // Below any cosine where the angle is all around.
        let cosine = |angle: f64| if angle > PI { -2.0 } else { angle.cos() };
        let mut discs = [-2.0; MOST_DISCS];
        for (limit, light) in discs.iter_mut().zip(self.lights) {
            *limit = cosine(light.reach_rad + widened);
        }
        Limits { horizon: widened.max(reach + self.clear * self.reach), aureole: cosine(AUREOLE_TO + reach), discs }
    }

    /// What pixels around a direction need.
    fn needs(&self, middle: Option<DVec3>, limits: &Limits) -> Needs {
        // Outside a fisheye, or so wide that nothing can be told.
        let Some(middle) = middle.filter(|_| self.reach <= 1.0) else { return Needs::ALL };
        let near =
            self.lights.iter().zip(limits.discs).filter(|(light, limit)| middle.dot(light.disc_direction) > *limit);
        let (moons, others): (Vec<_>, Vec<_>) = near.partition(|(light, _)| light.moon);
        if !others.is_empty() {
            return Needs::ALL;
        }
        let elevation = middle.dot(self.up).clamp(-1.0, 1.0).asin();
        let horizon = (elevation - self.horizon).abs() <= limits.horizon;
        let aureole =
            self.lights.iter().filter_map(|light| light.direction).any(|light| middle.dot(light) > limits.aureole);
        // A Moon that is made huge spans more of the air than its cubics do.
        let huge = moons.iter().any(|(light, _)| light.reach_rad > 0.05);
        if !moons.is_empty() && (horizon || huge) {
            return Needs::ALL;
        }
        Needs { horizon, aureole, disc: false, moon: !moons.is_empty() }
    }
}

/// Limits of what is near: an angle to the horizon, rad, and cosines of angles to lights.
struct Limits {
    horizon: f64,
    aureole: f64,
    discs: [f64; MOST_DISCS],
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By which sets each cell is drawn.
    fn drawn(tiles: &Tiles) -> Vec<Vec<Needs>> {
        let mut by = vec![Vec::new(); CELLS[0] * CELLS[1]];
        for (set, range) in tiles.ranges.iter().enumerate() {
            for index in range.clone().map(|index| index as usize) {
                let packed = tiles.rectangles[index / 48][index / 4 % 12][index % 4];
                let [x0, y0, x1, y1] = packed.to_le_bytes().map(usize::from);
                for y in y0..y1 {
                    for x in x0..x1 {
                        by[y * CELLS[0] + x].push(Needs::SETS[set]);
                    }
                }
            }
        }
        by
    }

    #[test]
    fn every_cell_is_drawn_once_by_what_it_needs() {
        let mut number = 1u64;
        let mut random = || {
            number = number.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (number >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut divided = 0;
        for _ in 0..300 {
            let view = View::looking(6.3 * random(), 3.0 * random() - 1.5, 0.05 + 2.5 * random(), 1.6);
            let direction = view.direction([2.0 * random() - 1.0, 2.0 * random() - 1.0]).unwrap();
            let up = DVec3::new(random() - 0.5, random() - 0.5, 1.0).normalize();
            let light =
                TileLight { direction: Some(direction), moon: false, disc_direction: direction, reach_rad: 0.005 };
            let lights = [light];
            let tiles = Tiles::new(&view, up, -0.01, &lights, 0.0).unwrap();
            let by = drawn(&tiles);
            assert!(by.iter().all(|by| by.len() == 1));
            // The cell with the disc, one on the horizon, one in the aureole.
            let around = Around::new(&view, up, -0.01, &lights).unwrap();
            let point = Limits { horizon: 0.0, aureole: AUREOLE_TO.cos(), discs: [0.005f64.cos(); MOST_DISCS] };
            for (index, by) in by.iter().enumerate() {
                let place = [index % CELLS[0], index / CELLS[0]].map(|x| (x as f64 + 0.5) / DIVISION as f64);
                let point = around.needs(around.at(place), &point);
                let tile = by[0];
                assert!(
                    tile.disc
                        || !point.disc
                            && tile.moon >= point.moon
                            && tile.horizon >= point.horizon
                            && tile.aureole >= point.aureole
                );
            }
            divided += usize::from(tiles != Tiles::merged(&around.sort(1)).unwrap());
        }
        assert!(divided > 100, "{divided}");
    }
}
