//! Where everything in the sky is, and how bright. f64, no GPU, no I/O.
//!
//! ```
//! use himmel_astro::{AirAtObserver, Body, Fast, Instant, Place, observe};
//!
//! let potsdam = Place::from_degrees(52.4, 13.06, 35.0)?;
//! let instant = Instant::parse("2012-09-06T18:00Z")?;
//! let sun = observe(&Fast, Body::Sun, &instant, &potsdam)?;
//! assert!(sun.altitude_rad.to_degrees() < -1.0);
//! println!("seen at {:.2}°", sun.refracted_altitude_rad(&AirAtObserver::default()).to_degrees());
//! # Ok::<(), himmel_astro::AstroError>(())
//! ```
//!
//! Angles are radians, lengths metres, times Julian dates whose scale is in the type. `[key]` in a comment names an entry
//! of `references.bib`.

mod apparent;
mod body;
pub mod constants;
pub mod earth;
pub mod ephemeris;
mod error;
pub mod events;
pub mod orbits;
pub mod physical;
mod place;
pub mod query;
mod refraction;
pub mod satellites;
mod series;
pub mod stars;
pub mod time;

pub use apparent::{Apparent, Observer, observe};
pub use body::Body;
pub use ephemeris::{Cached, Ephemeris, Fast, Manual, Precise, State};
pub use error::{AstroError, Result};
pub use place::Place;
pub use refraction::AirAtObserver;
pub use stars::{Catalogue, Star};
pub use time::Instant;
