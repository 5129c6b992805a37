//! Other planets and moons with air: lit spheres in the sky, or below a camera in space.
//!
//! - **What it is**: rays against spheres by chords (`bodies.wgsl`), in rectangles over the finished sky, in which pixels are drawn
//!   anew with all bodies along their ray, the nearest first. Air before a sphere is marched as the sky's own is, with tables
//!   of its own ([`SkyRenderer::set_far_airs`](crate::SkyRenderer::set_far_airs)): all orders of scattering, twilight, the bright
//!   limb. Ground is Lambert's with an albedo map, under its sun and its sky. Behind the air that the camera is in, a body is
//!   dimmed, reddened and lifted; before the planet that the camera is above, it hides that.
//! - **What it costs**: frames without bodies: nothing. Pixels of a body with air: a march for each of its suns and one more look
//!   at the sky (34 marches on its limb). Tables: 1.9 MB for each air, and 4.9 MB while they are built.
//! - **What it leaves out**: eclipses (shadows of bodies on each other), rings, flattening, clouds, their light on the home planet's
//!   air and ground, what the haze of the home planet scatters forward of a wide disc, stars dimmed by a limb's air (the ground
//!   hides them), the air before a host's picture (`apply_air`).
//! - **Known to look wrong**: the Moon, planets and the Sun's disc are always behind bodies.

mod model;
mod pass;

pub use model::{AlbedoMap, AlbedoMapError, FarBody, FarLight, MOST_FAR_BODIES};
pub(crate) use pass::{Bodies, apparent};
pub use pass::{BodiesUniform, FarBodyUniform, FarLightUniform};
