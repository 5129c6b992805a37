//! The Moon: a sphere in every pixel that it touches, lit by the Sun, by the Earth, and in eclipses by what the Earth's air
//! lets into its shadow.
//!
//! - **What it is**: a ray against a sphere by chords (`moon.wgsl`), the law of Lommel and Seeliger µ₀/(µ₀ + µ) over the disc, its
//!   amount by phase from the CPU (`himmel_astro::physical`), an albedo map, heights by a catalogue of craters ([`craters`],
//!   [`heights`]) or a map of normals, a table of the light in the Earth's shadow ([`himmel_air::shadow`]). Lifted and flattened by the air as the Sun's disc is; dimmed
//!   and reddened by the air's own optical depth. [`model`] is the f64 twin.
//! - **What it costs**: pixels in tiles that the disc does not touch: nothing. Others: `docs/moon.md`.
//! - **What it leaves out**: coloured rims from the air's dispersion (7″ at the horizon), the Sun's size at the terminator,
//!   the phase angle's change over the disc (0.5°), heights that are no craters'.
//! - **Known to look wrong**: all craters are fresh; beyond 70° of latitude the albedo is flat.

pub mod craters;
pub mod heights;
pub mod model;
mod params;
mod pass;

pub use craters::{Crater, CraterShape, CratersError};
pub use heights::{MoonHeights, MoonRelief};
pub use model::{EclipseMap, MoonEclipse, MoonMap, MoonMapError, MoonMaps, MoonState};
pub use params::{MoonParams, MoonPhotometry, ShadowRule};
pub use pass::MoonUniform;
pub(crate) use pass::{GroundForm, MoonTextures};
