//! How bodies look: phases, brightness, the Moon's face, Saturn's rings, Jupiter's moons.

mod appearance;
mod jupiter_moons;
mod libration_table;
mod magnitude;
mod moon;
pub mod moonlight;
mod saturn;

pub(crate) use appearance::angle_between;
pub use appearance::{Appearance, Earthshine, parallactic_angle_rad, position_angle_rad};
pub use jupiter_moons::{GalileanMoon, GalileanView, galilean_moons_m};
pub use magnitude::{moon_surge, planet_magnitude};
pub use moon::{Libration, MoonOrientation};
pub use saturn::{RingAspect, SATURN_RING_EDGES_M, pole_icrs};

/// Illuminance in lx of a light of visual magnitude V: 2.54e-6 lx · 10^(−0.4 V)   [allen1973].
pub fn illuminance_lx(v_magnitude: f64) -> f64 {
    himmel_core::constants::ILLUMINANCE_OF_V_0_LX * 10f64.powf(-0.4 * v_magnitude)
}
