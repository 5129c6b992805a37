//! The Sun's disc, limb-darkened by wavelength, dimmed and reddened by the air's own optical depth.
//!
//! - **What it costs**: a chord per pixel; 4 × 4 samples where the disc touches one.
//! - **What it leaves out**: spots, corona, eclipses.
//! - **Known to look wrong**: at the horizon it is round; refraction should flatten it by a sixth.
