//! Planets: points where their discs are small, else discs with phase; Saturn's rings, Jupiter's moons, satellites.
//!
//! Points go through `phenomena/stars` and do not twinkle. A disc wider than three pixels is a square of its own: a sphere
//! that scatters as Lambert's law says, flattened, lit from where the Sun stands, its whole light that of the planet's
//! magnitude. Saturn's rings hide, shine, shade and are shaded ([`model::planet_shade`]).
//!
//! - **What it costs**: 16 evaluations of the shade for each pixel of a disc, nothing while discs are points.
//! - **What it leaves out**: markings, belts, limb darkening other than Lambert's, flattening of discs at the horizon, seeing on
//!   discs, shadows of Jupiter's moons.
//! - **Known to look wrong**: a planet jumps from point to disc at three pixels; its rings' brightness relative to the globe is
//!   a rounded model, so that rings seen nearly edge-on are too dark.

pub mod model;
mod params;
mod pass;

pub use model::PlanetDisc;
pub use params::PlanetsParams;
pub use pass::PlanetUniform;
pub(crate) use pass::{Discs, MOST_DISCS, disc_slots};
