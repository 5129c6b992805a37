//! A picture in tiles, so that each is drawn by a pipeline that has what its pixels need and nothing else.
//!
//! Rasterisers on CPUs run every branch of a shader, and GPUs keep registers for the largest: most pixels of a sky are
//! far from its lights and from the horizon, and need neither.

use std::ops::Range;

use glam::DVec3;

use crate::view::View;

/// Tiles along the sides of a picture; the same in `sky.wgsl`.
const TILES: [usize; 2] = [20, 14];

/// Angle to a light up to which its aureole is drawn, rad; the same in `sky_view_table.wgsl`.
const AUREOLE_TO: f64 = 0.35;

/// What pixels may have to draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Needs {
    /// The horizon, where ground and sky are mixed in a pixel.
    pub horizon: bool,
    /// What surrounds a light in the air.
    pub aureole: bool,
    /// The disc of a light; with it always everything.
    pub disc: bool,
}

impl Needs {
    /// All of it.
    pub(crate) const ALL: Self = Self { horizon: true, aureole: true, disc: true };
    /// Every set of needs that a tile may have, cheapest first.
    pub(crate) const SETS: [Self; 5] = [
        Self { horizon: false, aureole: false, disc: false },
        Self { horizon: true, aureole: false, disc: false },
        Self { horizon: false, aureole: true, disc: false },
        Self { horizon: true, aureole: true, disc: false },
        Self::ALL,
    ];
}

/// A light, for the tiles around it.
pub(crate) struct TileLight {
    /// Unit vector towards it, east-north-up: its aureole.
    pub direction: DVec3,
    /// Unit vector towards its disc.
    pub disc_direction: DVec3,
    /// Radius of all that is drawn with the disc, rad.
    pub reach_rad: f64,
}

/// Rectangles of tiles, those with the same needs together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Tiles {
    /// First and last corner in tiles: x₀, y₀, x₁, y₁ a byte each, from the lowest.
    pub rectangles: [[[u32; 4]; 14]; 5],
    /// Which rectangles have each of [`Needs::SETS`].
    pub ranges: [Range<u32>; 5],
}

impl Tiles {
    /// Sorts a view's tiles. `up`: the zenith, east-north-up. `horizon`: elevation of the horizon, rad.
    pub(crate) fn new(view: &View, up: DVec3, horizon: f64, lights: &[TileLight]) -> Self {
        let reach = reach(view);
        let needs: Vec<Needs> = (0..TILES[0] * TILES[1])
            .map(|index| {
                let middle = at(view, (index % TILES[0]) as f64 + 0.5, (index / TILES[0]) as f64 + 0.5);
                needs(middle, reach, up, horizon, lights)
            })
            .collect();
        let mut tiles = Self::default();
        let mut count = 0;
        for (set, range) in Needs::SETS.iter().zip(&mut tiles.ranges) {
            let from = count;
            let mut open: Vec<[usize; 4]> = Vec::new();
            let mut done: Vec<[usize; 4]> = Vec::new();
            for y in 0..TILES[1] {
                let mut still_open = Vec::new();
                let mut x = 0;
                while x < TILES[0] {
                    let row = &needs[y * TILES[0]..(y + 1) * TILES[0]];
                    let length = row[x..].iter().take_while(|needs| *needs == set).count();
                    if length > 0 {
                        // A run of the same columns in the row below grows.
                        let below = open.iter().position(|r| r[0] == x && r[2] == x + length);
                        let first_row = below.map_or(y, |index| open.swap_remove(index)[1]);
                        still_open.push([x, first_row, x + length, y + 1]);
                    }
                    x += length.max(1);
                }
                done.append(&mut open);
                open = still_open;
            }
            done.append(&mut open);
            for [x0, y0, x1, y1] in done {
                let packed = [x0, y0, x1, y1].iter().rev().fold(0, |sum, &value| sum << 8 | value as u32);
                let vector = count / 4;
                tiles.rectangles[vector / 14][vector % 14][count % 4] = packed;
                count += 1;
            }
            *range = from as u32..count as u32;
        }
        tiles
    }
}

/// Where a place in tiles looks; `None` outside the picture.
fn at(view: &View, x: f64, y: f64) -> Option<DVec3> {
    let [left, bottom, width, height] = view.part;
    let place = |from: f64, size: f64, share: f64| 2.0 * (from + size * share) - 1.0;
    view.direction([place(left, width, x / TILES[0] as f64), place(bottom, height, y / TILES[1] as f64)])
}

fn needs(middle: Option<DVec3>, reach: f64, up: DVec3, horizon: f64, lights: &[TileLight]) -> Needs {
    // Outside a fisheye, or so wide that nothing can be told.
    let Some(middle) = middle.filter(|_| reach <= 1.0) else { return Needs::ALL };
    let near = |direction: DVec3, angle: f64| angle > std::f64::consts::PI || middle.angle_between(direction) < angle;
    // A hundredth more: discs are widened to a pixel.
    if lights.iter().any(|light| near(light.disc_direction, light.reach_rad + reach + 0.01)) {
        return Needs::ALL;
    }
    let elevation = middle.dot(up).clamp(-1.0, 1.0).asin();
    Needs {
        horizon: (elevation - horizon).abs() <= reach,
        aureole: lights.iter().any(|light| near(light.direction, AUREOLE_TO + reach)),
        disc: false,
    }
}

/// The largest angle from the middle of a tile to its corners, with a tenth to spare.
fn reach(view: &View) -> f64 {
    let [columns, rows] = TILES;
    let mut reach: f64 = 0.0;
    // Tiles are widest in the middle or at an edge of a picture, never in between.
    for x in [0, columns / 2, columns - 1] {
        for y in [0, rows / 2, rows - 1] {
            let (x, y) = (x as f64, y as f64);
            let Some(middle) = at(view, x + 0.5, y + 0.5) else { continue };
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                reach = reach.max(at(view, x + dx, y + dy).map_or(0.0, |corner| middle.angle_between(corner)));
            }
        }
    }
    1.1 * reach + 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often each tile is covered, and by which set.
    fn covered(tiles: &Tiles) -> Vec<Vec<usize>> {
        let mut by = vec![Vec::new(); TILES[0] * TILES[1]];
        for (set, range) in tiles.ranges.iter().enumerate() {
            for index in range.clone() {
                let vector = index as usize / 4;
                let packed = tiles.rectangles[vector / 14][vector % 14][index as usize % 4];
                let [x0, y0, x1, y1] = packed.to_le_bytes().map(usize::from);
                for y in y0..y1 {
                    for x in x0..x1 {
                        by[y * TILES[0] + x].push(set);
                    }
                }
            }
        }
        by
    }

    fn light(direction: DVec3) -> TileLight {
        TileLight { direction, disc_direction: direction, reach_rad: 0.005 }
    }

    #[test]
    fn every_tile_is_drawn_once_by_what_it_needs() {
        let mut number = 1u64;
        let mut random = || {
            number = number.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (number >> 40) as f64 / (1u64 << 24) as f64
        };
        for _ in 0..200 {
            let view = View::looking(6.3 * random(), 3.0 * random() - 1.5, 0.05 + 2.5 * random(), 1.6);
            let sun = view.direction([2.0 * random() - 1.0, 2.0 * random() - 1.0]).unwrap();
            let tiles = Tiles::new(&view, DVec3::Z, -0.01, &[light(sun)]);
            let reach = reach(&view);
            for (index, by) in covered(&tiles).iter().enumerate() {
                let middle = at(&view, (index % TILES[0]) as f64 + 0.5, (index / TILES[0]) as f64 + 0.5);
                let needs = needs(middle, reach, DVec3::Z, -0.01, &[light(sun)]);
                assert_eq!(by.iter().map(|&set| Needs::SETS[set]).collect::<Vec<_>>(), [needs]);
            }
        }
    }
}
