//! Lines and names over the sky, off by default: figures and borders of constellations, grids, the ecliptic; names of stars,
//! constellations and bodies, cardinal points, degrees of the grids.
//!
//! Lines that turn with the stars are lifted by refraction as the stars are. They are added to exposed values: in finished
//! pictures to display values, in linear ones as that many cd m⁻² times the exposure.
//!
//! Names stand beside what they name, which the GPU moves as it moves stars: a list and an atlas of letters are uploaded when they
//! change, per frame only uniforms. They cover what is behind them, letters over a thin dark halo. Of two that are in each other's way
//! the fainter one waits until the field is narrow enough: that hangs on the scale alone, not on where the camera looks.
//!
//! - **What it costs**: two ends moved for each corner of a piece of 2°: 5,000 pieces for a grid. A direction moved for each corner
//!   of a letter.
//! - **What it leaves out**: precession of grids: they are those of J2000. Names of satellites. What is fixed to the sky and what is
//!   fixed to the horizon do not make room for each other.
//! - **Known to look wrong**: where lines cross they add up. Names end at the seam of an equirectangular picture. A name stays when the
//!   Moon hides its star, and by day.

pub mod model;
pub mod names;
mod names_params;
mod names_pass;
mod params;
mod pass;
pub mod typeface;

pub use model::{LineKind, LineList, LinePiece, Overlay};
pub use names::{Anchor, Label, LabelKind, LabelList, MOST_NAMED_BODIES, NamedBody, Names};
pub use names_params::{NameColour, NamesParams};
pub use names_pass::{NameLabel, NameLetter, NamesUniform};
pub use params::OverlayParams;
pub use pass::LineSegment;
pub(crate) use pass::Lines;
pub use typeface::Typeface;
