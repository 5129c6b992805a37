//! What air does to light, in f64, without a GPU: the medium and its presets, optical depth, first-order
//! scattering, sky irradiance, the Sun's spectrum and limb darkening, and the matrix from four wavelengths to colour.
//! Everything here is a twin of what `himmel-gpu` draws, and the source of its tables.
//!
//! ```
//! use himmel_air::{Preset, Columns};
//! let earth = Preset::named("earth")?;
//! let columns = Columns::new(&earth.medium);
//! let air = earth.medium.sampled(&[550.0]);
//! let straight_up = columns.optical_depth(&air, 0.0, 1.0)[0];
//! assert!((0.1..0.4).contains(&straight_up));
//! # Ok::<(), himmel_air::AirError>(())
//! ```

// Sums over wavelengths index several arrays of N at once; iterators over one of them hide that.
#![allow(clippy::needless_range_loop)]

pub mod atmosphere;
pub mod colour;
pub mod columns;
pub mod disc;
pub mod eclipse;
pub mod geometry;
pub mod hillaire;
pub mod irradiance;
pub mod light;
pub mod lognormal;
pub mod medium;
pub mod mie;
pub mod moments;
pub mod params;
pub mod phase;
pub mod preset;
pub mod profile;
pub mod query;
pub mod rayleigh;
pub mod reference;
pub mod refraction;
pub mod scene_light;
pub mod shadow;
pub mod sharp;
pub mod single;
pub mod starlight;
pub mod sun;

mod error;

pub use atmosphere::Atmosphere;
pub use columns::Columns;
pub use error::AirError;
pub use medium::{Component, Medium, Sampled};
pub use params::{AirParams, AirQuality, GroundParams, SunParams};
pub use phase::Phase;
pub use preset::Preset;
pub use profile::Profile;
pub use starlight::Starlight;
