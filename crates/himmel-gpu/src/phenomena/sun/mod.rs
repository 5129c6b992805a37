//! The Sun's disc, limb-darkened by wavelength, dimmed and reddened by the air's own optical depth.
//!
//! - **What it costs**: a chord per pixel; the brightness only within the disc.
//! - **What it leaves out**: spots, corona, eclipses.
//! - **Known to look wrong**: at the horizon it is round; refraction should flatten it by a sixth.
