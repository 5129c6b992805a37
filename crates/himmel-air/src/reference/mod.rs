//! The reference: light followed backwards through spherical shells of air, all orders, without tables.

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
