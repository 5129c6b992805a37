//! The Sun's disc, limb-darkened by wavelength, dimmed and reddened by the air's own optical depth; its eclipses.
//!
//! `sun.wgsl` draws a round disc. `disc.wgsl` draws it as bent rays show it: flattened on the horizon, with coloured rims,
//! behind an [`Occluder`], with its corona. `eclipse.wgsl` tells how much of it is left at any point of the air.
//!
//! - **What it costs**: a chord per pixel; 4 × 4 samples where the disc touches one. An eclipse: 25 operations and one
//!   texel pair a sample by the table, seven times that for the blurred one; eight arctangents without the table.
//! - **What it leaves out**: spots, the chromosphere.
//! - **Known to look wrong**: the corona is round, without streamers; the Moon's edge is smooth, so that there are no
//!   Baily's beads; no mirage, no green flash (the presets' air has no inversions). `sun.wgsl` alone is round at the horizon.

mod occluder;

pub use occluder::{BendingUniform, DiscUniform, Occluder, ShadowUniform};
