//! The end of the picture: exposure, tone mapping, dithering. All of it happens once, after every phenomenon.

pub mod bloom;
pub mod dither;
pub mod eye;
mod finish;
pub(crate) mod meter;
pub mod params;
pub mod tonemap;

pub use finish::display_rgb;
pub use meter::{adapted, metered_ev100, metered_factor};
