//! The sky as a light for the host's scene.

use glam::DVec3;

/// Direct light of the Sun at the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunLight {
    /// Unit vector towards its refracted disc, east-north-up.
    pub direction_enu: DVec3,
    /// From north through east, degrees.
    pub azimuth_deg: f64,
    /// Above the horizon with refraction, degrees.
    pub altitude_deg: f64,
    /// Linear Rec. 709, the largest channel 1; black once it has set.
    pub colour: [f64; 3],
    /// On a surface that faces it, lx; 0 once it has set.
    pub illuminance_lx: f64,
}

/// All light at the observer. The sky's part counts sunlight that is scattered once; the rest comes with multiple scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The Sun.
    pub sun: SunLight,
    /// From the sky on a level surface, lx.
    pub sky_illuminance_lx: f64,
}

impl Light {
    /// On a level surface, from Sun and sky, lx.
    pub fn horizontal_illuminance_lx(&self) -> f64 {
        self.sun.illuminance_lx * self.sun.direction_enu.z.max(0.0) + self.sky_illuminance_lx
    }
}
