//! What our sky is measured against: the usual approximation on the GPU, and a stage on which both are timed.
//!
//! - [`Hillaire`]: the tables and the picture of [hillaire2020], which most engines draw, made as fast as we could.
//! - [`Stage`]: one frame after another into the same target, each timed until the device is idle.
//!
//! Nothing of the renderer uses this; `himmel bench` does.

mod hillaire;
mod medium;
mod passes;
mod stage;

pub use hillaire::{Hillaire, HillaireUniform, Redo};
pub use stage::{Stage, TimedFrame};

#[cfg(test)]
mod tests;
