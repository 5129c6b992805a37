//! One file for each subcommand.

pub mod bench;
pub mod info;
pub mod optics;
pub mod params;
pub mod render;
pub mod scene;
