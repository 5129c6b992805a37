//! What glows at night between the stars: the Milky Way, zodiacal light, airglow, light of cities.
//!
//! - **What it is**: [`NightGlow`] is a frame's night in numbers and the f64 twin of `night_glow.wgsl`. Light from beyond the air
//!   comes through the transmittance T′ of extended things (what aerosols scatter forward is not lost). What the air scatters out
//!   of all lines of sight comes back as an even glow, by reciprocity the diffuse transmission of the same air
//!   ([`diffuse_transmission`]): this is why the night's effective extinction is less than that of stars [leinert1998, section 6].
//!   Airglow shines from a layer ([`Layer`]) that one can stand below, in or above. Light of cities is scattered once by air that
//!   is lit from below: it grows towards the horizon as the moonlight of [krisciunas1991] does ([`polluted_share`]).
//! - **What it costs**: four texels of the star map and of two tables for each point, two hundred operations. Perspective views in real
//!   time take it from a grid of 384 × 216 points (on a rasteriser a quarter of the cost of each pixel at 1280 × 720); nothing
//!   while [`FrameState::night`](crate::FrameState) is none.
//! - **What it leaves out**: waves and patches of airglow, its red layer at 250 km, aurorae; the cloud of dust is symmetric to the
//!   ecliptic (its own plane is tilted by 2°) and does not change with the seasons; domes of single cities; light pollution seen
//!   from above. Light scattered by dust of the Galaxy (a fifth of the Milky Way's) and the heart of its bulge above 500 S10 are
//!   not in the built-in map.
//! - **Known to look wrong**: within 15° of the Sun zodiacal light is a power law. Colours of the map are Gaia's, not the eye's.

pub mod airglow;
pub(crate) mod grid;
mod model;
pub mod params;
mod pass;
pub mod pollution;
pub mod star_map;
#[cfg(test)]
mod tests;
pub mod zodiacal;

pub use airglow::Layer;
pub use model::{
    NightGlow, NightParts, NightSettings, diffuse_transmission, four_from_rec709, four_of_light, polluted_share,
};
pub use params::{AirglowParams, Lamp, LightPollutionParams, MilkyWayParams, ZodiacalParams};
pub(crate) use pass::NightTextures;
pub use pass::NightUniform;
pub use star_map::{StarMap, StarMapError};

/// Luminance of one S10: a star of V = 10 on a square degree, of 2.54e-6 lx at V = 0   [allen1973]
pub const S10_CD_M2: f64 = 8.34e-7;

/// Luminance of a surface brightness; S10 is 27.78 mag/arcsec².
pub fn cd_m2_of_mag_arcsec2(mag: f64) -> f64 {
    S10_CD_M2 * 10f64.powf(0.4 * (S10_MAG_ARCSEC2 - mag))
}

/// Surface brightness of a luminance; infinite for 0.
pub fn mag_arcsec2_of_cd_m2(cd_m2: f64) -> f64 {
    S10_MAG_ARCSEC2 - 2.5 * (cd_m2 / S10_CD_M2).log10()
}

/// 10 + 2.5 lg 3600².
const S10_MAG_ARCSEC2: f64 = 27.781_512_503_836_44;
