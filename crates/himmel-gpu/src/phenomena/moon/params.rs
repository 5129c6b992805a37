//! The parameters of the Moon.

use himmel_core::{choices, params};

choices! {
    /// How bright the Moon's ground is over the phase.
    pub enum MoonPhotometry {
        /// Lommel and Seeliger over the disc, Allen's law with the opposition surge over the phase.
        Allen = "allen",
        /// Hapke, Lommel and Seeliger as in Müller 2012, with the colour and the earthshine of that thesis.
        Thesis = "thesis",
    }
}

choices! {
    /// Where the edge of the Earth's umbra lies on the Moon, and what is in it.
    pub enum ShadowRule {
        /// Light from the air's own rays, its edge put at Danjon's radius, as in almanacs.
        Danjon = "danjon",
        /// The same at Chauvenet's radius.
        Chauvenet = "chauvenet",
        /// Light and edge from the air's own rays alone.
        Air = "air",
        /// The map of colours of Müller 2012 between the radii of the bare cone.
        Thesis = "thesis",
    }
}

params! {
    /// The Moon.
    pub struct MoonParams: "body.moon" {
        /// Whether it is there: as a disc and as a light.
        enabled: bool = true;
        /// Whether the disc is drawn; its light stays.
        disc: bool = true;
        /// Whether it lights air and ground.
        light: bool = true;
        /// Factor on its apparent radius; its luminance and its light on the scene stay.
        radius_scale: f64 = 1.0, "", 0.01..=100.0;
        /// Factor on its brightness.
        brightness: f64 = 1.0, "", 0.0..=1e6;
        /// How bright its ground is over the phase.
        photometry: MoonPhotometry = MoonPhotometry::Allen;
        /// Factor on the Earth's light on it.
        earthshine: f64 = 1.0, "", 0.0..=1000.0;
        /// Whether the thesis' earthshine is by its short form (4.10) instead of (4.9).
        earthshine_short: bool = false;
        /// Picture of its albedo in latitude and longitude, 0° in the middle; empty: the built-in one; none: even ground.
        albedo_map: String = String::new();
        /// Picture of its normals (red east, green north, blue up) in latitude and longitude; empty: heights by its craters; none: smooth.
        normal_map: String = String::new();
        /// Factor on the slopes of the map of normals, or on the heights; 0: smooth ground.
        relief: f64 = 1.0, "", 0.0..=10.0;
        /// What is in the Earth's shadow, and where its edge lies.
        eclipse: ShadowRule = ShadowRule::Danjon;
        /// Factor on the disc's luminance once it is in the umbra, as an artistic exposure; 1 is nature.
        eclipse_boost: f64 = 1.0, "", 1.0..=1e6;
        /// Share of the Earth's rim that clouds hide up to their tops.
        eclipse_cloud_cover: f64 = 0.0, "", 0.0..=1.0;
        /// Altitude of those tops.
        eclipse_cloud_top_m: f64 = 8000.0, "m", 0.0..=30000.0;
        /// Vertical optical depth of volcanic dust in the stratosphere.
        eclipse_dust: f64 = 0.0, "", 0.0..=2.0;
        /// Azimuth from north through east; unset: from place and time.
        azimuth_deg: Option<f64> = None, "°", -360.0..=360.0;
        /// Altitude above the horizon, without refraction; unset: from place and time.
        altitude_deg: Option<f64> = None, "°", -90.0..=90.0;
        /// Distance from the observer; unset: from place and time.
        distance_km: Option<f64> = None, "km", 2000.0..=1e9;
    }
}
