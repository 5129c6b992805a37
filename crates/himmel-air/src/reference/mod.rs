//! The reference: light followed backwards through spherical shells of air, all orders, with a standard error beside each
//! number. No table that an answer depends on: optical depths are quadratures along each line. `docs/reference.md` says how
//! it works and how right it is.
//!
//! ```
//! use himmel_air::reference::{Effort, Source, Tracer};
//! let earth = himmel_air::Preset::named("bruneton2017")?;
//! let tracer = Tracer::new(&earth.medium.sampled(&[680.0, 440.0]))?; // any number of wavelengths on the same paths
//! let sun = [Source::at_zenith_angle(60f64.to_radians())]; // any number of lights, beams or discs
//! let zenith = tracer.radiance(&sun, 2.0, glam::DVec3::Z, &Effort::default(), 0)?;
//! // Red and blue, per sr and unit irradiance: the sky is blue.
//! assert!(zenith.value[1] > 3.0 * zenith.value[0] && zenith.relative_error() < 0.01);
//! # Ok::<(), himmel_air::AirError>(())
//! ```
//!
//! Left out: polarisation, refraction, terrain. The ground is a Lambertian sphere, with a map of its albedo if one likes.

mod first;
mod flight;
mod flux;
mod forward;
mod importance;
mod line;
mod lobe;
mod optics;
mod parallel;
mod path;
mod random;
mod source;
#[cfg(test)]
mod tests;
mod tracer;

pub use flux::Side;
pub use forward::Photons;
pub use parallel::for_each_parallel;
pub use path::ORDERS;
pub use source::Source;
pub use tracer::{BATCHES, Effort, Estimate, MOST_SAMPLES, Tracer};
