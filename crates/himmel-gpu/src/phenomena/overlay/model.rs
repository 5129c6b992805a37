//! Lines over the sky: where they run.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::names::Names;
use super::params::OverlayParams;

/// What a line is; its colour follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// A figure of a constellation.
    Figure,
    /// A border of one.
    Border,
    /// Right ascension and declination.
    Equatorial,
    /// Azimuth and altitude.
    Horizontal,
    /// The ecliptic.
    Ecliptic,
}

/// A piece of a line between two unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePiece {
    /// Its ends.
    pub ends: [DVec3; 2],
    /// What it belongs to.
    pub kind: LineKind,
}

/// All lines of a sky.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineList {
    /// Those that turn with the stars, ICRS axes.
    pub fixed: Vec<LinePiece>,
    /// Those that stay with the observer, east-north-up, as seen.
    pub local: Vec<LinePiece>,
}

/// The overlay of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Uploaded when it is another one than before.
    pub lines: Arc<LineList>,
    /// Names; `None` where there are none.
    pub names: Option<Names>,
    /// How lines are drawn.
    pub params: OverlayParams,
    /// Rotation.
    pub enu_from_icrs: DMat3,
}

/// Longest piece, rad: great circles and refraction bend no more in between than a hundredth of a degree.
const LONGEST_RAD: f64 = 2.0 * PI / 180.0;

impl LineList {
    /// A great circle's arc between two directions, in pieces.
    pub fn arc(pieces: &mut Vec<LinePiece>, from: DVec3, to: DVec3, kind: LineKind) {
        let angle = from.angle_between(to);
        let steps = (angle / LONGEST_RAD).ceil().max(1.0) as usize;
        let axis = from.cross(to).normalize_or(from.any_orthonormal_vector());
        let at = |i: usize| glam::DQuat::from_axis_angle(axis, angle * i as f64 / steps as f64) * from;
        pieces.extend((0..steps).map(|i| LinePiece { ends: [at(i), at(i + 1)], kind }));
    }

    /// Circles of longitude and latitude; `across`: circles of longitude.
    pub fn grid(pieces: &mut Vec<LinePiece>, across: u32, step_deg: u32, kind: LineKind) {
        let at = |longitude: f64, latitude: f64| {
            let (sin_a, cos_a) = longitude.sin_cos();
            let (sin_h, cos_h) = latitude.sin_cos();
            DVec3::new(cos_h * cos_a, cos_h * sin_a, sin_h)
        };
        let cells = (PI / LONGEST_RAD).ceil() as u32;
        for i in 0..across {
            let longitude = TAU * f64::from(i) / f64::from(across);
            let latitude = |j: u32| -FRAC_PI_2 + PI * f64::from(j) / f64::from(cells);
            pieces.extend(
                (0..cells)
                    .map(|j| LinePiece { ends: [at(longitude, latitude(j)), at(longitude, latitude(j + 1))], kind }),
            );
        }
        let step_deg = step_deg.clamp(1, 90);
        for degrees in (0..180).step_by(step_deg as usize).skip(1) {
            let latitude = (f64::from(degrees) - 90.0).to_radians();
            let longitude = |j: u32| TAU * f64::from(j) / f64::from(2 * cells);
            pieces.extend(
                (0..2 * cells)
                    .map(|j| LinePiece { ends: [at(longitude(j), latitude), at(longitude(j + 1), latitude)], kind }),
            );
        }
    }

    /// A great circle about a pole.
    pub fn circle(pieces: &mut Vec<LinePiece>, pole: DVec3, kind: LineKind) {
        let x = pole.any_orthonormal_vector();
        let y = pole.cross(x);
        for (from, to) in [(x, y), (y, -x), (-x, -y), (-y, x)] {
            Self::arc(pieces, from, to, kind);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_short_joined_and_on_their_circle() {
        let mut pieces = Vec::new();
        let pole = DVec3::new(0.2, -0.5, 0.8).normalize();
        LineList::circle(&mut pieces, pole, LineKind::Ecliptic);
        for (piece, next) in pieces.iter().zip(pieces.iter().cycle().skip(1)) {
            assert!(piece.ends[0].angle_between(piece.ends[1]) <= LONGEST_RAD + 1e-9);
            assert!((piece.ends[1] - next.ends[0]).length() < 1e-9 && piece.ends[0].dot(pole).abs() < 1e-9);
        }
        let mut grid = Vec::new();
        LineList::grid(&mut grid, 24, 10, LineKind::Equatorial);
        assert_eq!(grid.len(), 24 * 90 + 17 * 180);
        assert!(grid.iter().flat_map(|piece| piece.ends).all(|end| (end.length() - 1.0).abs() < 1e-12));
    }
}
