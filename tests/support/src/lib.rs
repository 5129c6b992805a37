//! Golden pictures for Himmel's tests: compare, propose, review, accept.
//!
//! Radiance is kept as half-float EXR and compared by relative error; looks are kept as PNG and compared by FLIP.
//!
//! ```no_run
//! use himmel_golden::{GoldenError, GoldenSet, Tolerance};
//!
//! fn twilight() -> Result<(), GoldenError> {
//!     let golden = GoldenSet::of_workspace()?; // tests/golden/accepted and target/golden
//!     let rgb: Vec<f32> = vec![0.25; 3 * 320 * 180]; // from the renderer
//!     let report = golden.check_exr("twilight", 320, 180, &rgb, Tolerance::default())?;
//!     println!("{report}");
//!     Ok(())
//! }
//! ```
//!
//! A check that fails says how far off it is and leaves its picture as a proposal:
//! `cargo xtask golden propose` makes all of them, `… review` shows them, `… accept NAME` takes them over.
//! No GPU here, and no panics on any input.

pub mod cli;
mod colour;
mod error;
mod files;
mod flip;
mod golden;
mod heat;
mod picture;
mod radiance;
mod review;

pub use error::{GoldenError, Size};
pub use files::{MAX_PIXELS, RadianceImage, Rgb8Image, RgbImage, decode_exr, decode_png, encode_exr, encode_png};
pub use flip::{DEFAULT_PIXELS_PER_DEGREE, Flip, FlipStats, flip};
pub use golden::{GoldenSet, MODE_VARIABLE, Mode, Report, Verdict};
pub use heat::{exposure_of, flip_heat, relative_heat, sheet, tone_mapped};
pub use picture::{FlipTolerance, Kind, Numbers, Tolerance};
pub use radiance::{Radiance, RadianceStats, compare_radiance};
pub use review::{Acceptance, Accepted, Review, ReviewRow};
