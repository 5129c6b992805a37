//! The end of the picture: exposure, tone mapping, dithering. All of it happens once, after every phenomenon.

pub mod dither;
pub(crate) mod meter;
pub mod params;
pub mod tonemap;
