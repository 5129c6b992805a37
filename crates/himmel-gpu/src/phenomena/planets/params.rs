//! Parameters of `[night.planets]`.

use himmel_core::params;

params! {
    /// Planets with their moons, satellites, and what else moves.
    pub struct PlanetsParams: "night.planets" {
        /// Whether planets are drawn: points, and discs with phase where they are wider than three pixels.
        enabled: bool = true;
        /// Whether Jupiter's four great moons are drawn.
        moons: bool = true;
        /// Path of a file of two-line elements (TLE), relative to the scene file; empty: no satellites.
        satellites: String = String::new();
        /// Magnitude of satellites at 1000 km, half lit.
        satellite_magnitude: f64 = 4.0, "mag", -10.0..=20.0;
        /// A comet's elements as in docs/astronomy.md, such as Halley q=0.5748 e=0.9679 i=162.19 node=59.07 peri=112.24 tp=2446469.97 m1=5.5 k1=8; empty: none.
        comet: String = String::new();
        /// Length of the comet's tail, away from the Sun.
        comet_tail_au: f64 = 0.1, "au", 0.0..=5.0;
    }
}
