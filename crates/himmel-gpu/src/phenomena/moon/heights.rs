//! Heights of the Moon's ground: craters laid over each other on a map, and the horizon that they make.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use himmel_air::reference::for_each_parallel;

use super::craters::{Crater, CraterShape};

/// Mean radius of the Moon [archinal2018].
pub const RADIUS_KM: f64 = 1737.4;
/// Texels along the map of heights: 2.7 km at the equator.
pub(crate) const WIDTH: u32 = 4096;
/// Texels along the map from which craters take the level of the ground that they fell on.
const COARSE: u32 = 1024;
/// Places on a crater's rim whose mean that level is.
const RIM_POINTS: usize = 8;

/// Steps of the way to the horizon grow by this factor …
const STEP: f64 = 1.2;
/// … and see the mean of ground as wide as this share of the way.
const WIDTH_OF_STEP: f64 = 0.1;
/// Under a higher Sun (its tangent) the craters' walls cast no shadow: the steepest has 0.49.
const STEEPEST: f64 = 0.6;
/// Tangent of the Sun's apparent radius from 1 au.
pub(crate) const SUN_TAN: f64 = 0.00465;

/// Ground made of craters; its map is made when it is first asked for.
pub struct MoonRelief {
    craters: Vec<Crater>,
    heights: OnceLock<Arc<MoonHeights>>,
}

impl std::fmt::Debug for MoonRelief {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MoonRelief of {} craters", self.craters.len())
    }
}

impl PartialEq for MoonRelief {
    fn eq(&self, other: &Self) -> bool {
        self.craters == other.craters
    }
}

impl MoonRelief {
    /// Of craters, the oldest first: the widest are taken for the oldest.
    pub fn new(mut craters: Vec<Crater>) -> Self {
        craters.sort_by(|a, b| b.diameter_km.total_cmp(&a.diameter_km));
        Self { craters, heights: OnceLock::new() }
    }

    /// The craters.
    pub fn craters(&self) -> &[Crater] {
        &self.craters
    }

    /// The map.
    pub fn heights(&self) -> &Arc<MoonHeights> {
        self.heights.get_or_init(|| Arc::new(MoonHeights::of(&self.craters, WIDTH)))
    }
}

/// Heights above the mean ground in latitude and longitude: longitude −180° on the left, north at the top; with smaller levels.
pub struct MoonHeights {
    width: u32,
    /// Kilometres.
    levels: Vec<Vec<f16>>,
    lowest_km: f64,
    highest_km: f64,
}

impl std::fmt::Debug for MoonHeights {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MoonHeights of {} × {} texels", self.width, self.width / 2)
    }
}

/// A crater on its way into a map.
struct Stamp {
    crater: Crater,
    shape: CraterShape,
    /// Level of the ground that it fell on.
    ground_km: f32,
}

impl MoonHeights {
    /// Lays craters over each other in their order. `width`: texels of a row, a power of two.
    pub fn of(craters: &[Crater], width: u32) -> Self {
        let stamp = |crater: &Crater| Stamp { crater: *crater, shape: crater.shape(), ground_km: 0.0 };
        let mut stamps: Vec<Stamp> = craters.iter().map(stamp).collect();
        let (coarse_w, coarse_h) = (COARSE as usize, COARSE as usize / 2);
        let mut coarse = vec![0.0; coarse_w * coarse_h];
        for stamp in &mut stamps {
            stamp.ground_km = rim_level(&coarse, coarse_w, stamp);
            press(&mut coarse, coarse_w, coarse_h, 0, stamp);
        }
        let (w, h) = (width as usize, width as usize / 2);
        // Craters that lie in two bands are begun twice. A row of the next level has two of this one.
        let bands = (h / 2).min(32);
        let rows = h / bands;
        let band = |band: usize| {
            let mut part = vec![0.0; w * rows];
            stamps.iter().for_each(|stamp| press(&mut part, w, h, band * rows, stamp));
            (halves(&part), smaller(&part, w))
        };
        let (mut finest, mut map) = (vec![f16::ZERO; w * h], vec![0.0; w * h / 4]);
        for_each_parallel(bands, band, |band, (part, part_smaller)| {
            finest[band * part.len()..][..part.len()].copy_from_slice(&part);
            map[band * part_smaller.len()..][..part_smaller.len()].copy_from_slice(&part_smaller);
            true
        });
        let mut levels = vec![finest];
        let mut w = w / 2;
        while w > 1 {
            levels.push(halves(&map));
            map = smaller(&map, w);
            w /= 2;
        }
        levels.push(halves(&map));
        // By the level whose texels are 10 km wide at the equator.
        let level = &levels[(width / 1024).max(1).ilog2() as usize];
        let span = level.iter().fold([0.0f64; 2], |[low, high], km| [low.min(km.to_f64()), high.max(km.to_f64())]);
        let [lowest_km, highest_km] = span;
        Self { width, levels, lowest_km, highest_km }
    }

    /// Texels along a row; half as many rows.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Heights in km by level, the finest first.
    pub fn levels(&self) -> &[Vec<f16>] {
        &self.levels
    }

    /// The lowest ground, and the highest as a mean of 10 km: single peaks above it cast their shadows as far as it would.
    pub fn span_km(&self) -> [f64; 2] {
        [self.lowest_km, self.highest_km]
    }

    /// Height in km. `uv`: in the map, 0..=1, x without end; `level`: between maps.
    pub fn sample(&self, uv: DVec2, level: f64) -> f64 {
        let level = level.clamp(0.0, (self.levels.len() - 1) as f64);
        let finer = self.bilinear(uv, level as usize);
        match level.fract() {
            0.0 => finer,
            part => finer + part * (self.bilinear(uv, level as usize + 1) - finer),
        }
    }

    fn bilinear(&self, uv: DVec2, level: usize) -> f64 {
        let (w, h) = ((self.width as usize >> level).max(1), ((self.width as usize / 2) >> level).max(1));
        let x = uv.x * w as f64 - 0.5;
        let y = (uv.y * h as f64 - 0.5).clamp(0.0, (h - 1) as f64);
        let (fx, fy) = (x - x.floor(), y.fract());
        let at = |dx: i64, dy: usize| {
            let column = (x.floor() as i64 + dx).rem_euclid(w as i64) as usize;
            self.levels[level][(y as usize + dy).min(h - 1) * w + column].to_f64()
        };
        let (above, below) = (at(0, 0) + fx * (at(1, 0) - at(0, 0)), at(0, 1) + fx * (at(1, 1) - at(0, 1)));
        above + fy * (below - above)
    }

    /// Slopes to east and north, heights times `relief`. `own`: unit vector in the Moon's frame; `level`: of the map.
    /// Twin of `moon_slopes`.
    pub fn slopes(&self, own: DVec3, level: f64, relief: f64) -> DVec2 {
        let arc = self.arc(level);
        let (uv, cos_lat) = (map_uv(own), cos_latitude(own));
        let [east, north] = [DVec2::new(arc / (TAU * cos_lat), 0.0), DVec2::new(0.0, -arc / PI)];
        let here = self.sample(uv, level);
        let rise = |step: DVec2| self.sample(uv + step, level) - here;
        DVec2::new(rise(east), rise(north)) * (relief / RADIUS_KM) / arc
    }

    /// Tangent of the elevation of the horizon. `towards`: unit vector, its parts to east and north; `tan`: of the Sun's elevation,
    /// beyond which nothing is looked for; below `darkest_tan` the horizon is above it. Twin of `moon_horizon`.
    ///
    /// max over the way s of (h(s) − h₀) / s − s / 2, lengths in radii of the Moon
    pub fn horizon(&self, own: DVec3, level: f64, relief: f64, towards: DVec2, tan: f64) -> f64 {
        let k = relief / RADIUS_KM;
        let (uv, cos_lat) = (map_uv(own), cos_latitude(own));
        let here = k * self.sample(uv, level);
        let darkest = darkest_tan(self.span_km(), relief);
        let mut horizon = towards.dot(self.slopes(own, level, relief));
        let rise = (k * self.highest_km - here).max(0.0);
        let furthest = (tan * tan + 2.0 * rise).sqrt() - tan;
        let texel = TAU / f64::from(self.width);
        let tan_lat = own.z / cos_lat;
        let mut way = self.arc(level);
        let looked_for = tan < STEEPEST * relief && tan > darkest;
        while looked_for && way < furthest {
            // The great circle to second order.
            let east = towards.x * (1.0 + way * towards.y * tan_lat) / cos_lat;
            let north = towards.y - 0.5 * way * towards.x * towards.x * tan_lat;
            let there = uv + way * DVec2::new(east / TAU, -north / PI);
            let level = level.max((WIDTH_OF_STEP * way / texel).log2()).round();
            horizon = horizon.max((k * self.sample(there, level) - here) / way - 0.5 * way);
            way *= STEP;
        }
        if tan > darkest { horizon } else { horizon.max(darkest) }
    }

    /// Width of a texel of a level at the equator, in radii of the Moon.
    fn arc(&self, level: f64) -> f64 {
        TAU / f64::from(self.width) * level.exp2()
    }
}

/// Tangent of the lowest horizon, that of the highest ground over the lowest.
pub(crate) fn darkest_tan([lowest_km, highest_km]: [f64; 2], relief: f64) -> f64 {
    -(2.0 * relief * (highest_km - lowest_km) / RADIUS_KM).sqrt()
}

/// What of the Sun's disc stands above a horizon; tangents of elevations. Twin of `sun_above`.
pub fn sun_above(tan: f64, horizon: f64) -> f64 {
    let x = ((tan - horizon) / SUN_TAN * 0.5 + 0.5).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Where a unit vector of the Moon's frame lies in its maps.
pub(crate) fn map_uv(own: DVec3) -> DVec2 {
    DVec2::new(own.y.atan2(own.x) / TAU + 0.5, own.z.clamp(-1.0, 1.0).acos() / PI)
}

/// Cosine of the latitude; near the poles, where maps have no east, that of 88°.
fn cos_latitude(own: DVec3) -> f64 {
    (1.0 - own.z * own.z).max(0.0).sqrt().max(0.035)
}

fn halves(map: &[f32]) -> Vec<f16> {
    let mut halves = vec![f16::ZERO; map.len()];
    halves.convert_from_f32_slice(map);
    halves
}

/// Means of four texels, of two where there is one row.
fn smaller(map: &[f32], w: usize) -> Vec<f32> {
    let rows = map.len() / w;
    let mut means = Vec::with_capacity(map.len() / 4 + 1);
    for y in 0..rows.div_ceil(2) {
        let [a, b] = [2 * y, (2 * y + 1).min(rows - 1)].map(|row| map[row * w..][..w].chunks_exact(2));
        means.extend(a.zip(b).map(|(a, b)| 0.25 * (a[0] + a[1] + b[0] + b[1])));
    }
    means
}

/// Mean of a map along a crater's rim.
fn rim_level(map: &[f32], w: usize, stamp: &Stamp) -> f32 {
    let own = stamp.crater.own();
    let side = own.any_orthonormal_vector();
    let up = own.cross(side);
    let (sin, cos) = (stamp.shape.radius_km / RADIUS_KM).sin_cos();
    let at = |i: usize| {
        let (s, c) = (TAU * i as f64 / RIM_POINTS as f64).sin_cos();
        let uv = map_uv(own * cos + (side * c + up * s) * sin);
        let (x, y) = ((uv.x * w as f64) as usize % w, (uv.y * (w / 2) as f64) as usize);
        map[y.min(w / 2 - 1) * w + x]
    };
    (0..RIM_POINTS).map(at).sum::<f32>() / RIM_POINTS as f32
}

/// Presses a crater into some rows of a map. `h`: rows of the whole map; `first`: the part's first.
fn press(part: &mut [f32], w: usize, h: usize, first: usize, stamp: &Stamp) {
    let Stamp { crater, shape, ground_km } = stamp;
    let reach = shape.reach_km() / RADIUS_KM;
    let rows = part.len() / w;
    let row_of = |latitude: f64| (0.5 - latitude / PI) * h as f64;
    let from = (row_of(crater.latitude_rad + reach).floor().max(0.0) as usize).max(first);
    let to = (row_of(crater.latitude_rad - reach).ceil().max(0.0) as usize).min(first + rows);
    if from >= to {
        return;
    }
    let (sin_0, cos_0) = crater.latitude_rad.sin_cos();
    let middle = (crater.longitude_rad / TAU + 0.5) * w as f64;
    let latitude = |row: usize| (0.5 - (row as f64 + 0.5) / h as f64) * PI;
    // Half the columns that the crater spans in a row; none where the row passes it.
    let span = |row: usize| {
        let (sin, cos) = latitude(row).sin_cos();
        let cos_span = (reach.cos() - sin * sin_0) / (cos * cos_0).max(1e-12);
        (cos_span < 1.0).then(|| cos_span.max(-1.0).acos() / TAU * w as f64)
    };
    let widest = (from..to).filter_map(span).fold(0.0, f64::max);
    let left = (middle - widest).ceil() as i64;
    let columns = ((middle + widest).floor() as i64 - left + 1).clamp(0, w as i64) as usize;
    // sin² of half the difference in longitude.
    let across: Vec<f32> =
        (0..columns).map(|i| ((left as f64 + i as f64 + 0.5 - middle) * PI / w as f64).sin().powi(2) as f32).collect();
    // As in CraterShape::at, in f32 and with the diameter of the Moon for unit.
    let unit = 1.0 / (2.0 * RADIUS_KM);
    let radius = (shape.radius_km * unit) as f32;
    let floor = (shape.floor_radius_km * unit) as f32;
    let per_wall = 1.0 / (radius - floor);
    let foot = (shape.radius_km / shape.reach_km()).powi(3) as f32;
    let depth_km = shape.depth_km as f32;
    // At the crest and within the flank is as high as the rim.
    let per_ejecta = shape.rim_height_km as f32 / (1.0 - foot);
    for row in from..to {
        let Some(half) = span(row) else { continue };
        let skip = (((middle - half).ceil() as i64 - left).max(0) as usize).min(columns);
        let until = (((middle + half).floor() as i64 - left + 1).max(0) as usize).min(columns);
        let along = (0.5 * (latitude(row) - crater.latitude_rad)).sin().powi(2) as f32;
        let scale = (latitude(row).cos() * cos_0) as f32;
        // Without branches, so that it is done for several texels at once.
        let texel = |(km, across): (&mut f32, &f32)| {
            let chord_2 = along + scale * across;
            // asin x = x (1 + x² / 6) to 2e-4 at 300 km.
            let distance = chord_2.sqrt() * (1.0 + chord_2 / 6.0);
            let down = 1.0 - ((distance - floor) * per_wall).clamp(0.0, 1.0);
            let ejecta = radius / distance.max(radius);
            let flank = per_ejecta * (ejecta * ejecta * ejecta - foot).max(0.0);
            *km += flank + (ground_km - *km - depth_km) * down;
        };
        let across = &across[skip.min(until)..until];
        let line = &mut part[(row - first) * w..][..w];
        let x = (left + skip as i64).rem_euclid(w as i64) as usize;
        let (before, after) = across.split_at(across.len().min(w - x));
        line[x..].iter_mut().zip(before).for_each(texel);
        line.iter_mut().zip(after).for_each(texel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crater(latitude_deg: f64, longitude_deg: f64, diameter_km: f64) -> Crater {
        Crater {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: longitude_deg.to_radians(),
            diameter_km,
            lava: false,
        }
    }

    /// A place at a distance from a crater's middle. `azimuth_rad`: from north through east.
    fn beside(crater: &Crater, azimuth_rad: f64, km: f64) -> DVec3 {
        let own = crater.own();
        let north = (DVec3::Z - own * own.z).normalize();
        let way = north * azimuth_rad.cos() + north.cross(own) * azimuth_rad.sin();
        own * (km / RADIUS_KM).cos() + way * (km / RADIUS_KM).sin()
    }

    /// Profiles of lonely craters against their shape, where the shape does not change faster than the map's texels.
    #[test]
    fn the_map_has_the_craters_shape() {
        let craters = [
            crater(9.62, 339.92, 96.07),
            crater(-43.3, 348.78, 85.3),
            crater(70.0, 179.9, 60.0),
            crater(-88.0, 10.0, 90.0),
        ];
        let heights = MoonHeights::of(&craters, 4096);
        for crater in &craters {
            let shape = crater.shape();
            for azimuth in 0..12 {
                for share in [0.0, 0.2, 0.45, 0.75, 0.9, 1.15, 1.3, 2.5] {
                    let km = share * shape.radius_km;
                    let own = beside(crater, f64::from(azimuth) * PI / 6.0, km);
                    let (got, expected) = (heights.sample(map_uv(own), 0.0), shape.at(km).0);
                    assert!((got - expected).abs() < 0.06, "{crater:?} {azimuth} {share}: {got} {expected}");
                }
            }
            // Half way up the wall: depth over the wall's width, falling towards the middle.
            let wall = 0.5 * (shape.floor_radius_km + shape.radius_km);
            let east = beside(crater, 0.5 * PI, wall);
            let slope = shape.depth_km / (shape.radius_km - shape.floor_radius_km);
            let slopes = heights.slopes(east, 0.0, 1.0);
            if crater.latitude_rad.abs() < 1.4 {
                assert!((slopes.x / slope - 1.0).abs() < 0.03, "{crater:?}: {slopes} {slope}");
                assert!(slopes.y.abs() < 0.1 * slope, "{crater:?}: {slopes}");
            }
        }
        assert!((heights.span_km()[1] - craters[0].shape().rim_height_km).abs() < 0.15);
    }

    /// A younger crater levels what was there.
    #[test]
    fn the_younger_crater_lies_over_the_older() {
        let (old, young) = (crater(0.0, 0.0, 120.0), crater(0.0, 2.0, 60.0));
        let heights = MoonHeights::of(&[old, young], 4096);
        let at = |crater: &Crater, azimuth, km| heights.sample(map_uv(beside(crater, azimuth, km)), 0.0);
        let floor = young.shape().floor_radius_km;
        let [east, west, middle] =
            [at(&young, 0.5 * PI, 0.7 * floor), at(&young, 1.5 * PI, 0.7 * floor), at(&young, 0.0, 0.0)];
        assert!((east - west).abs() < 0.02 && (east - middle).abs() < 0.02, "{east} {west} {middle}");
        assert!(middle < young.shape().at(0.0).0, "its ground is partly the older's floor");
    }

    /// The shadow of a rim ends where the Sun touches the crest: s tan e₀ = h + s²/2, e₀ the Sun's elevation over the crest.
    #[test]
    fn shadows_are_as_long_as_the_rim_is_high() {
        // Somewhere there is higher ground.
        let giant = crater(0.0, 120.0, 300.0);
        for (diameter_km, latitude_deg) in [(96.07, 0.0), (60.0, -40.0), (30.0, 20.0)] {
            let crater = crater(latitude_deg, 300.0, diameter_km);
            let shape = crater.shape();
            let heights = MoonHeights::of(&[giant, crater], 4096);
            for sun_deg in [3.0f64, 4.0] {
                let sun = sun_deg.to_radians();
                // Westwards the Sun sinks by the way.
                let lit = |km: f64| {
                    let own = beside(&crater, 1.5 * PI, shape.radius_km + km);
                    let tan = (sun - km / RADIUS_KM).tan();
                    let back = (crater.own() - own * own.dot(crater.own())).normalize();
                    let north = (DVec3::Z - own * own.z).normalize();
                    let towards = DVec2::new(back.dot(north.cross(own)), back.dot(north));
                    sun_above(tan, heights.horizon(own, 0.0, 1.0, towards, tan))
                };
                let h = shape.rim_height_km / RADIUS_KM;
                let expected_km = (sun.tan() - (sun.tan().powi(2) - 2.0 * h).sqrt()) * RADIUS_KM;
                let edge_km =
                    (0..2000).map(|i| shape.rim_width_km + 0.1 * f64::from(i)).find(|km| lit(*km) > 0.5).unwrap();
                println!(
                    "{diameter_km} km, Sun {sun_deg}° over the crest: {edge_km:.1} km of shadow, expected {expected_km:.1}"
                );
                // Too short, never too long by more than a texel: steps of a fifth meet the crest within a tenth of the way, and
                // half a texel beside it a rim of 30 km is a quarter lower; 2.6 km beside Copernicus' as well.
                let ratio = edge_km / expected_km;
                assert!(expected_km < shape.rim_width_km || (0.7..1.1).contains(&ratio), "{ratio}");
            }
        }
    }

    /// Flat ground under the Sun has none; the night is dark; peaks beyond the terminator are lit.
    #[test]
    fn plains_cast_no_shadow() {
        let heights = MoonHeights::of(&[crater(0.0, 0.0, 96.07)], 1024);
        let plain = DVec3::new(0.0, 1.0, 0.0);
        let lit = |own: DVec3, tan: f64| sun_above(tan, heights.horizon(own, 0.0, 1.0, DVec2::X, tan));
        assert_eq!(lit(plain, 0.01), 1.0);
        assert_eq!(lit(plain, -0.01), 0.0);
        assert!((lit(plain, 0.0) - 0.5).abs() < 0.1);
        let flank = beside(&crater(0.0, 0.0, 96.07), 0.5 * PI, 50.0);
        assert_eq!(lit(flank, -0.02), 1.0, "1.4 km high: lit until the Sun is 2.3° below");
    }
}
