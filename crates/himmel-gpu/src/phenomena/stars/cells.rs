//! Cells of the sky: which stars of a list a view may show is told of some hundred stars at once.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::model::{PointBody, StarField, StarPoint};
use crate::error::GpuError;
use crate::view::{Projection, View};

/// Cells along a side of a face of the cube.
const SIDE: usize = 4;
/// Cells of the sky: the most runs of a list that a frame draws.
pub(super) const CELLS: usize = 6 * SIDE * SIDE;

/// A part of the sky and its stars in the list, brightest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell {
    /// Number of its first star.
    pub first: usize,
    /// Its stars.
    pub count: usize,
    /// Unit vector to the middle of its stars at J2000.0.
    centre: DVec3,
    /// None of them is farther from there, rad.
    radius_rad: f64,
    /// None of them moves faster: by itself, rad a year, …
    motion_rad: f64,
    /// … and by parallax, rad.
    parallax_rad: f64,
}

/// The cell of a direction.
pub(super) fn cell_of(place: DVec3) -> usize {
    let a = place.abs();
    let (axis, major) = match a {
        _ if a.x >= a.y && a.x >= a.z => (0, place.x),
        _ if a.y >= a.z => (1, place.y),
        _ => (2, place.z),
    };
    let [u, v] = match axis {
        0 => [place.y, place.z],
        1 => [place.x, place.z],
        _ => [place.x, place.y],
    };
    // A line at a time, back and forth: neighbours in the list are neighbours in the sky.
    let step = |x: f64| (((x / major.abs().max(1e-300)).clamp(-1.0, 1.0) + 1.0) * 0.5 * SIDE as f64) as usize;
    let (column, row) = (step(u).min(SIDE - 1), step(v).min(SIDE - 1));
    let column = if row % 2 == 1 { SIDE - 1 - column } else { column };
    ((2 * axis + usize::from(major < 0.0)) * SIDE + row) * SIDE + column
}

/// The cells of stars that lie in their order.
pub(super) fn cells_of(stars: &[StarPoint]) -> Vec<Cell> {
    let mut first = 0;
    stars
        .chunk_by(|a, b| cell_of(a.place) == cell_of(b.place))
        .map(|own| {
            let centre = own.iter().map(|star| star.place).sum::<DVec3>().normalize_or(own[0].place);
            let most = |of: &dyn Fn(&StarPoint) -> f64| own.iter().map(of).fold(0.0, f64::max);
            let cell = Cell {
                first,
                count: own.len(),
                centre,
                radius_rad: most(&|star| star.place.angle_between(centre)),
                motion_rad: most(&|star| star.velocity_per_year.length()),
                parallax_rad: most(&|star| star.parallax_rad.abs()),
            };
            first += own.len();
            cell
        })
        .collect()
}

/// What a view can show, with a margin, east-north-up.
pub(super) struct Sight {
    /// Inward normals of the sides of a linear picture.
    sides: Vec<DVec3>,
    /// Axis and half the span of a fisheye.
    axis: Option<(DVec3, f64)>,
    /// The lowest true elevation of what stands above the ground, rad.
    lowest_rad: f64,
    margin_rad: f64,
    /// The least solid angle of a pixel, sr; 0 where it is not known.
    pub(super) pixel_sr: f64,
}

impl Sight {
    /// `lowest_rad`: the lowest true elevation that is seen.  `margin_rad`: how far a star outside the picture reaches in, and by
    /// how much refraction may lift it.  `rows`: of the picture, in pixels.
    pub(super) fn new(view: &View, lowest_rad: f64, margin_rad: f64, rows: f64) -> Result<Self, GpuError> {
        let mut sight = Self { sides: Vec::new(), axis: None, lowest_rad, margin_rad, pixel_sr: 0.0 };
        let per_ndc = 4.0 / (rows * rows);
        match view.projection {
            Projection::Matrix(_) => {
                let rays = view.rays()?;
                let [left, bottom, width, height] = view.part;
                let (right, top) = (left + width, bottom + height);
                let ndc =
                    [[left, bottom], [right, bottom], [right, top], [left, top]].map(|c| c.map(|x| 2.0 * x - 1.0));
                let [origin, x, y] = rays;
                let middle = view.along(&rays, [left + right - 1.0, bottom + top - 1.0]).unwrap_or(DVec3::Z);
                let corners = ndc.map(|ndc| view.along(&rays, ndc).unwrap_or(middle));
                for i in 0..4 {
                    let normal = corners[i].cross(corners[(i + 1) % 4]).normalize_or_zero();
                    sight.sides.push(if normal.dot(middle) < 0.0 { -normal } else { normal });
                }
                let farthest = ndc.iter().map(|&[u, v]| (origin + x * u + y * v).length()).fold(0.0, f64::max);
                let aspect = x.length() / y.length();
                sight.pixel_sr = origin.dot(x.cross(y)).abs() / farthest.powi(3) * per_ndc / aspect;
            }
            Projection::Fisheye(span) => {
                let half = (0.5 * span).min(PI);
                let forward = view.enu_from_view.transform_vector3(-DVec3::Z).normalize_or(DVec3::Z);
                sight.axis = Some((forward, half));
                sight.pixel_sr = (0.5 * span).powi(2) * half.sin() / half * per_ndc;
            }
            Projection::Equirectangular => {}
        }
        Ok(sight)
    }

    /// Whether anything may be seen that is no farther than `reach_rad` from a direction.
    fn reaches(&self, centre: DVec3, reach_rad: f64) -> bool {
        let reach = reach_rad + self.margin_rad;
        if reach.is_nan() || reach > FRAC_PI_2 {
            return true;
        }
        // Negative: out of sight.
        let above = |sine: f64| sine.clamp(-1.0, 1.0).asin() + reach;
        above(centre.z) >= self.lowest_rad
            && self.sides.iter().all(|side| above(side.dot(centre)) >= 0.0)
            && self.axis.is_none_or(|(axis, half)| centre.angle_between(axis) <= half + reach)
    }

    /// The bodies that may be seen, as runs of their list. `always`: of each, whether it is kept anyway.
    pub(super) fn bodies(&self, bodies: &[PointBody], always: &dyn Fn(usize) -> bool) -> Vec<(usize, usize)> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (index, body) in bodies.iter().enumerate() {
            // The core of what is wide reaches over twice its width.
            if !always(index) && !self.reaches(body.direction.normalize_or(DVec3::Z), 2.0 * body.width_rad) {
                continue;
            }
            let full = runs.len() == CELLS;
            match runs.last_mut() {
                Some((first, count)) if *first + *count == index || full => *count = index + 1 - *first,
                _ => runs.push((index, 1)),
            }
        }
        runs
    }

    /// Whether any of a cell's stars may be seen.
    fn shows(&self, cell: &Cell, field: &StarField) -> bool {
        let centre = field.enu_from_icrs * cell.centre;
        let moved = cell.motion_rad * field.years_since_j2000.abs() + cell.parallax_rad * field.observer_au.length();
        self.reaches(centre, cell.radius_rad + moved + field.beta.length())
    }

    /// The stars that may be seen, as runs of the list: first, count. `faintest`: V magnitude.
    pub(super) fn runs(&self, field: &StarField, faintest: f64) -> Vec<(usize, usize)> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for cell in field.list.cells() {
            let count = field.list.count_in(cell, faintest);
            if count == 0 || !self.shows(cell, field) {
                continue;
            }
            match runs.last_mut() {
                Some((first, so_far)) if *first + *so_far == cell.first => *so_far += count,
                _ => runs.push((cell.first, count)),
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DMat3;

    use super::super::model::StarList;
    use super::super::params::StarsParams;
    use super::*;

    fn field() -> StarField {
        // An even spiral over the sphere.
        let stars = (0..20_000).map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 20_000.0;
            let (sine, cosine) = (2.399_963_229_7 * f64::from(i)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            StarPoint {
                place: DVec3::new(r * cosine, r * sine, z),
                velocity_per_year: DVec3::ZERO,
                parallax_rad: 0.0,
                v_magnitude: f64::from(i % 11),
                illuminance_lx: 1.0,
                temperature_k: 0.0,
            }
        });
        StarField {
            list: Arc::new(StarList::new(stars.collect())),
            params: StarsParams::default(),
            years_since_j2000: 12.0,
            beta: DVec3::ZERO,
            observer_au: DVec3::X,
            enu_from_icrs: DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0),
            time_s: 0.0,
            darkest_sky_cd_m2: 0.0,
        }
    }

    /// Law: whatever a view shows above its horizon is in the runs, and little else; runs keep order and share nothing.
    #[test]
    fn runs_have_all_that_a_view_shows() {
        let field = field();
        let mut views: Vec<View> = Vec::new();
        for (azimuth, altitude) in [(0.3, 0.2), (2.0, 1.5), (4.0, -0.4)] {
            for fov in [1e-3, 0.1, 1.0, 2.0, 3.0] {
                views.push(View::looking(azimuth, altitude, fov, 1.6));
            }
            views.push(View { part: [0.5, 0.25, 0.125, 0.25], ..View::looking(azimuth, altitude, 1.0, 1.6) });
            for span in [1.0, 3.1, 6.0] {
                views.push(View::with_projection(azimuth, altitude, Projection::Fisheye(span), 1.0));
            }
            views.push(View::with_projection(azimuth, altitude, Projection::Equirectangular, 2.0));
        }
        for view in views {
            let sight = Sight::new(&view, -0.02, 0.0, 720.0).unwrap();
            let runs = sight.runs(&field, 5.0);
            assert!(runs.len() <= CELLS && runs.windows(2).all(|pair| pair[0].0 + pair[0].1 < pair[1].0));
            let drawn = |index: usize| runs.iter().any(|&(first, count)| (first..first + count).contains(&index));
            let rays = view.rays().unwrap();
            let turn = DMat3::from_mat4(view.enu_from_view).transpose();
            for (index, star) in field.list.stars().iter().enumerate() {
                let direction = field.enu_from_icrs * star.place;
                let seen = match view.projection {
                    Projection::Matrix(_) => {
                        let local = turn * direction;
                        let [origin, x, y] = rays;
                        let at = local / -local.z * -origin.z;
                        let ndc = [at.x / x.x, at.y / y.y].map(|v| 0.5 * v + 0.5);
                        let [left, bottom, width, height] = view.part;
                        local.z < 0.0
                            && (left..left + width).contains(&ndc[0])
                            && (bottom..bottom + height).contains(&ndc[1])
                    }
                    Projection::Fisheye(span) => (turn * direction).angle_between(-DVec3::Z) < 0.5 * span,
                    Projection::Equirectangular => true,
                };
                if seen && star.v_magnitude <= 5.0 && direction.z > 0.0 {
                    assert!(drawn(index), "{view:?} leaves out {direction}");
                }
            }
        }
        let few: usize = Sight::new(&View::looking(0.3, 0.8, 0.1, 1.6), 0.0, 0.0, 720.0)
            .unwrap()
            .runs(&field, 20.0)
            .iter()
            .map(|run| run.1)
            .sum();
        assert!(few < 2000, "{few} of 20,000 for six degrees");
    }

    #[test]
    fn a_cell_holds_its_stars() {
        let field = field();
        let cells = field.list.cells();
        assert_eq!(cells.len(), CELLS);
        assert_eq!(cells.iter().map(|cell| cell.count).sum::<usize>(), 20_000);
        assert!(cells.iter().all(|cell| cell.radius_rad < 0.5));
        assert_eq!(field.list.count_to(4.5), 20_000 / 11 * 5 + 2);
    }
}
