//! The end of the picture: exposure, tone mapping, dithering. All of it happens once, after every phenomenon.

pub mod dither;
mod finish;
pub(crate) mod meter;
pub mod params;
pub mod tonemap;

pub use finish::display_rgb;
pub use meter::metered_ev100;
