//! Parameters of `[night.stars]`.

use himmel_core::{choices, params};

use crate::target::Output;

choices! {
    /// How the light of a point is drawn.
    pub enum PointSpread {
        /// A core of fixed size in pixels that keeps the light's flux, and glare.
        Physical = "physical",
        /// Core and glare of Müller's thesis: relative to a control magnitude, not in lx [mueller2012, §4.3.2].
        Thesis = "thesis",
    }
}

choices! {
    /// What spreads the light that a pixel cannot hold.
    pub enum Glare {
        /// Nothing.
        None = "none",
        /// The eye's own scattering [spencer1995, photopic].
        Eye = "eye",
        /// A lens: 3 % of the light, by the inverse square [king1971].
        Lens = "lens",
    }
}

params! {
    /// Stars that are drawn one by one.
    pub struct StarsParams: "night.stars" {
        /// Whether they are drawn.
        enabled: bool = true;
        /// Stars fainter than this (V, above the air) are left out.
        limiting_magnitude: f64 = 6.5, "mag", -30.0..=40.0;
        /// How their light is spread.
        psf: PointSpread = PointSpread::Physical;
        /// What spreads the light that a pixel cannot hold; unset: eye in finished pictures, none in linear ones.
        glare: Option<Glare> = None;
        /// Whether the eye's glare has fine rays.
        ciliary_corona: bool = false;
        /// Factor on how strongly they twinkle; unset: 1 in finished pictures, 0 in linear ones.
        scintillation: Option<f64> = None, "", 0.0..=10.0;
        /// Diameter of the pupil or telescope that they twinkle in.
        aperture_cm: f64 = 0.7, "cm", 0.1..=5000.0;
        /// Time over which their light is gathered while they twinkle.
        integration_s: f64 = 0.05, "s", 0.001..=1000.0;
        /// Full width of a star at the zenith by seeing; a pixel of some size hides it.
        seeing_arcsec: f64 = 1.0, "″", 0.0..=60.0;
        /// Control magnitude m_a of the thesis: a star of this magnitude is white in the middle.
        thesis_magnitude: f64 = 4.0, "mag", -30.0..=40.0;
        /// Path of a catalogue (CSV), relative to the scene file; empty: the one that is built in.
        catalogue: String = String::new();
    }
}

impl StarsParams {
    /// The glare that a kind of output gets.
    pub fn glare_for(&self, output: Output) -> Glare {
        self.glare.unwrap_or(match output {
            Output::Display => Glare::Eye,
            Output::Radiance => Glare::None,
        })
    }

    /// The factor on scintillation that a kind of output gets.
    pub fn scintillation_for(&self, output: Output) -> f64 {
        self.scintillation.unwrap_or(match output {
            Output::Display => 1.0,
            Output::Radiance => 0.0,
        })
    }
}
