//! Lines over the sky, off by default: figures and borders of constellations, grids, the ecliptic.
//!
//! Lines that turn with the stars are lifted by refraction as the stars are. They are added to exposed values: in finished
//! pictures to display values, in linear ones as that many cd m⁻² times the exposure.
//!
//! - **What it costs**: two ends moved for each corner of a piece of 2°: 5,000 pieces for a grid.
//! - **What it leaves out**: names. Precession of grids: they are those of J2000.
//! - **Known to look wrong**: where lines cross they add up.

pub mod model;
mod params;
mod pass;

pub use model::{LineKind, LineList, LinePiece, Overlay};
pub use params::OverlayParams;
pub use pass::LineSegment;
pub(crate) use pass::Lines;
