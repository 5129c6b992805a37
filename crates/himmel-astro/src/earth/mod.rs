//! How the Earth stands in space: precession, nutation, rotation, polar motion.

mod nutation;
mod orientation;
mod precession;

pub use nutation::{Nutation, NutationModel};
pub use orientation::{EarthOrientation, earth_rotation_angle_rad, mean_sidereal_time_rad};
pub use precession::{PrecessionAngles, ecliptic_j2000_from_gcrs, mean_obliquity_rad};

use glam::DMat3;

/// Turns the axes (not the vectors) about x: R₁ of the textbooks.
pub(crate) fn axes_turned_x(angle_rad: f64) -> DMat3 {
    DMat3::from_rotation_x(-angle_rad)
}

/// Turns the axes about y: R₂.
pub(crate) fn axes_turned_y(angle_rad: f64) -> DMat3 {
    DMat3::from_rotation_y(-angle_rad)
}

/// Turns the axes about z: R₃.
pub(crate) fn axes_turned_z(angle_rad: f64) -> DMat3 {
    DMat3::from_rotation_z(-angle_rad)
}
