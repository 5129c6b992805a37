//! Parameters of `[overlay.names]`.

use himmel_core::{choices, params};

choices! {
    /// Colour of names.
    pub enum NameColour {
        /// Each kind its own.
        Kinds = "kinds",
        /// White.
        White = "white",
        /// Amber.
        Amber = "amber",
        /// Red, which spares eyes that are used to the dark.
        Red = "red",
    }
}

params! {
    /// Names over the sky, as on a chart.
    pub struct NamesParams: "overlay.names" {
        /// Whether there are any.
        enabled: bool = false;
        /// Names of stars.
        stars: bool = true;
        /// Bayer's letters and Flamsteed's numbers of stars that have no name.
        letters: bool = true;
        /// Names of constellations.
        constellations: bool = true;
        /// Names of the Sun, the Moon, planets, a comet and the scene's own bodies.
        bodies: bool = true;
        /// Cardinal points on the horizon.
        cardinal_points: bool = true;
        /// Degrees and hours of the grids that are drawn.
        degrees: bool = true;
        /// Faintest star with a name in a picture of 60°; in others it is 4 lg(60°/field) fainter.
        magnitude: f64 = 3.5, "mag", -10.0..=30.0;
        /// Height of the letters from line to line.
        size_px: f64 = 14.0, "px", 4.0..=400.0;
        /// Brightness of the letters, of white.
        strength: f64 = 0.8, "", 0.0..=1.0;
        /// Their colour.
        colour: NameColour = NameColour::Kinds;
        /// Path of a font (TrueType, OpenType), relative to the scene file; empty: the one that is built in.
        font: String = String::new();
    }
}
