//! Parameters of `[night.*]` that glow.

use himmel_core::{choices, params};

params! {
    /// The upper air's own light.
    pub struct AirglowParams: "night.airglow" {
        /// Whether it glows; only planets of the Earth's size do.
        enabled: bool = true;
        /// Solar radio flux at 10.7 cm, which it follows: 70 to 80 at the Sun's minimum, 200 at maximum.
        solar_flux_sfu: f64 = 80.0, "sfu", 60.0..=400.0;
        /// Factor on its brightness.
        brightness: f64 = 1.0, "", 0.0..=1000.0;
        /// Altitude of the layer.
        altitude_km: f64 = 90.0, "km", 60.0..=400.0;
        /// Its thickness, where half of the brightest is left.
        thickness_km: f64 = 10.0, "km", 1.0..=50.0;
    }
}

params! {
    /// Sunlight on the dust between the planets, with the gegenschein.
    pub struct ZodiacalParams: "night.zodiacal" {
        /// Whether it is drawn.
        enabled: bool = true;
        /// Factor on its brightness.
        brightness: f64 = 1.0, "", 0.0..=1000.0;
    }
}

params! {
    /// The Milky Way: light of the stars that are not drawn one by one.
    pub struct MilkyWayParams: "night.milky_way" {
        /// Whether it is drawn.
        enabled: bool = true;
        /// Factor on its brightness.
        brightness: f64 = 1.0, "", 0.0..=1000.0;
        /// A map of your own, see docs/night-sky.md; empty: the built-in one.
        file: String = String::new();
    }
}

choices! {
    /// What lights cities.
    pub enum Lamp {
        /// High-pressure sodium: orange.
        Sodium = "sodium",
        /// White LEDs of 4,100 K.
        Led = "led",
        /// Half of each, by luminance.
        Mixed = "mixed",
    }
}

params! {
    /// Light of cities, scattered by the air.
    pub struct LightPollutionParams: "night.light_pollution" {
        /// Luminance that it adds at the zenith; 0: a dark site.
        zenith_mcd_m2: f64 = 0.0, "mcd/m²", 0.0..=1000.0;
        /// Bortle class of the place, in place of a luminance.
        bortle: Option<u32> = None, "", 1.0..=9.0;
        /// The colour of the light.
        lamp: Lamp = Lamp::Mixed;
    }
}
