//! One file for each subcommand.

pub mod almanac;
pub mod bench;
pub mod eclipses;
pub mod ephemeris;
pub mod info;
pub mod level;
pub mod light;
pub mod optics;
pub mod params;
pub mod radiance;
pub mod render;
mod render_reference;
pub mod scene;
pub mod table;
