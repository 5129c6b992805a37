//! Parameters of `[overlay]`.

use himmel_core::params;

params! {
    /// Lines over the sky, as on a chart.
    pub struct OverlayParams: "overlay" {
        /// Figures of the constellations.
        constellations: bool = false;
        /// Borders of the constellations.
        borders: bool = false;
        /// Right ascension and declination (J2000), every hour and every 10°.
        equatorial_grid: bool = false;
        /// Azimuth and altitude, every 10°.
        horizontal_grid: bool = false;
        /// The ecliptic (J2000).
        ecliptic: bool = false;
        /// Brightness of the lines, of white.
        strength: f64 = 0.3, "", 0.0..=1.0;
        /// Their width.
        width_px: f64 = 1.5, "px", 0.5..=20.0;
    }
}

impl OverlayParams {
    /// Whether there are lines to draw.
    pub fn any(&self) -> bool {
        self.constellations || self.borders || self.equatorial_grid || self.horizontal_grid || self.ecliptic
    }
}
