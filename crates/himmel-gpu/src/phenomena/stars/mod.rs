//! Stars: points of light, and all other points that are drawn like them.
//!
//! One list of points lies on the GPU; a frame uploads only uniforms. For each view one invocation moves a star by its
//! proper motion, by parallax, aberration, precession and nutation, lifts it by the air's refraction, dims and reddens it by
//! the air's optical depth, lets it twinkle, and drops it behind ground, Sun and Moon. Points are then sorted into bins of the
//! picture, which the sky's own pixels read: their light is tone mapped with the sky's. Those that are wide (glare, strong seeing,
//! comets, poles of an equirectangular picture, all of the thesis' mode) are drawn over it as squares.
//!
//! - **The core** is a cubic B-spline four pixels wide ([`model::core_weight`]): whatever the projection, field of view or
//!   resolution, luminance times solid angle sums to the star's illuminance, and its centroid is its place, exactly.
//!   Seeing widens it where a pixel is finer.
//! - **Glare** spreads the light that a pixel cannot hold as an eye or a lens does ([`model::glare_coefficients`]); what it
//!   takes the core lacks. It ends where it falls to 2 % of middle grey.
//! - **Finished pictures** get what a wide point changes: tonemap(sky + point) − tonemap(sky), with the sky of the same tables.
//! - **What it costs**: `docs/night-sky.md`.
//! - **What it leaves out**: deflection by the Sun (0.01″ at 45°), dispersion (a star at the horizon is no spectrum, though its
//!   colours twinkle apart), radial velocities, variable stars.
//! - **Known to look wrong**: a wide point in a finished picture and what stands within it add up in display values; a star
//!   vanishes at once at the horizon and at the Moon's edge; targets that cannot blend (32-bit floats on some adapters) show no
//!   wide points.

mod bins;
mod cells;
pub mod model;
mod params;
mod pass;

pub(crate) use bins::{bins_of_view, bins_texel, read_layout};
pub use model::{Hider, PointBody, StarField, StarList, StarPoint};
pub use params::{Glare, PointSpread, StarsParams};
pub(crate) use pass::{ADDED, Points, PointsScene, glare_of, pipeline_over_sky, view_of_points};
pub use pass::{MOST_BODIES, MOST_HIDERS, PointLight, PointsUniform, SeenPoint};
