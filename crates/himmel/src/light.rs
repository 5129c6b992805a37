//! The sky as a light for the host's scene.

use glam::DVec3;
use himmel_air::scene_light::irradiance_of;

use crate::night::NightZenith;

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

impl SunLight {
    /// Illuminance as linear Rec. 709 whose luminance is [`illuminance_lx`](Self::illuminance_lx): times albedo / π and
    /// the cosine it is what a matt surface shows, in cd m⁻².
    pub fn rgb_lx(&self) -> DVec3 {
        with_luminance(self.colour, self.illuminance_lx)
    }
}

/// Name of the Moon among the sources.
pub(crate) const MOON: &str = "Moon";

/// A light far away: the Sun, the Moon.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSource {
    /// What it is.
    pub name: String,
    /// Unit vector towards it as the air shows it, east-north-up.
    pub direction_enu: DVec3,
    /// Linear Rec. 709, the largest channel 1; black where it does not shine.
    pub colour: [f64; 3],
    /// On a surface that faces it, lx.
    pub illuminance_lx: f64,
}

/// Light from everywhere but the sources' own discs, as nine real harmonics of radiance.
///
/// Linear Rec. 709 in cd m⁻². The basis (order, signs, normalisation) is that of [`himmel_air::scene_light`], over
/// (east, north, up).
///
/// ```
/// use himmel::{AmbientLight, glam::DVec3};
/// // An even sky of 1000 cd/m² in all directions, the ground too: π times that on every surface.
/// let mut harmonics = [[0.0; 3]; 9];
/// harmonics[0] = [1000.0 * (4.0 * std::f64::consts::PI).sqrt(); 3];
/// let light = AmbientLight { harmonics_cd_m2: harmonics };
/// assert!((light.irradiance_lx(DVec3::X).x - 3141.6).abs() < 0.1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientLight {
    /// L_i of red, green and blue.
    pub harmonics_cd_m2: [[f64; 3]; 9],
}

impl AmbientLight {
    /// Illuminance of a surface with a unit normal (east-north-up) as linear Rec. 709: times albedo / π it is what a matt
    /// surface shows, in cd m⁻². Exact for surfaces that face up or down; walls turned
    /// away from a low Sun get up to 15 % too much.
    pub fn irradiance_lx(&self, normal: DVec3) -> DVec3 {
        DVec3::from_array(irradiance_of(&self.harmonics_cd_m2, normal))
    }
}

/// All light at the observer, with all orders of scattering.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The Sun.
    pub sun: SunLight,
    /// Every light that casts shadows, the Sun first.
    pub sources: Vec<LightSource>,
    /// From the sky on a level surface, lx.
    pub sky_illuminance_lx: f64,
    /// Of that light: linear Rec. 709, the largest channel 1.
    pub sky_colour: [f64; 3],
    /// From ground and air below on a surface that faces down, lx.
    pub ground_illuminance_lx: f64,
    /// Luminance of the zenith, cd m⁻²; the Sun's disc is not in it.
    pub zenith_luminance_cd_m2: f64,
    /// Its parts at night; `None` by day.
    pub night: Option<NightZenith>,
    /// Sky and ground in all directions.
    pub ambient: AmbientLight,
    /// What of the Sun's disc the Moon leaves (1: no eclipse), by its illuminance.
    pub eclipse_fraction: f64,
}

/// The faintest star that a good eye sees before a background, in magnitudes.
///
/// m = −16.57 − 2.5 lg[C (1 + √(K B))²], B in nanolamberts (3.183e-6 cd m⁻²), C = 10^−9.80, K = 10^−1.90 for rods
/// (B below 1,500), C = 10^−8.35, K = 10^−5.90 for cones   [schaefer1990]
///
/// As the star is seen through the air: extinction is not taken off. Where the two branches meet they differ by 0.1.
/// Laws tested: 6.4 to 6.8 at night, about −4 by day; falls with the background.
pub fn limiting_magnitude(background_cd_m2: f64) -> f64 {
    let nanolamberts = background_cd_m2.max(0.0) / 3.183e-6;
    let (c, k) = if nanolamberts < 1500.0 { (-9.80, -1.90) } else { (-8.35, -5.90) };
    let threshold = 10f64.powf(c) * (1.0 + (10f64.powf(k) * nanolamberts).sqrt()).powi(2);
    -16.57 - 2.5 * threshold.log10()
}

impl Light {
    /// The faintest star that a good eye sees at the zenith: [`limiting_magnitude`] of its luminance.
    pub fn limiting_magnitude(&self) -> f64 {
        limiting_magnitude(self.zenith_luminance_cd_m2)
    }

    /// The sky's illuminance of a level surface as linear Rec. 709; see [`SunLight::rgb_lx`].
    pub fn sky_rgb_lx(&self) -> DVec3 {
        with_luminance(self.sky_colour, self.sky_illuminance_lx)
    }

    /// On a level surface, from Sun, Moon and sky, lx.
    pub fn horizontal_illuminance_lx(&self) -> f64 {
        let level = |source: &LightSource| source.illuminance_lx * source.direction_enu.z.max(0.0);
        self.sources.iter().map(level).sum::<f64>() + self.sky_illuminance_lx
    }

    /// The Moon, while it shines.
    pub fn moon(&self) -> Option<&LightSource> {
        self.sources.iter().find(|source| source.name == MOON)
    }
}

/// A colour scaled to a luminance (Rec. 709's weights); black stays black.
fn with_luminance(colour: [f64; 3], luminance: f64) -> DVec3 {
    let colour = DVec3::from_array(colour);
    let own = colour.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    if own > 0.0 { colour * (luminance / own) } else { DVec3::ZERO }
}

/// Linear Rec. 709 with its largest channel 1; negative channels (colours outside Rec. 709) become 0.
pub(crate) fn pure_colour(rec709: DVec3) -> [f64; 3] {
    let largest = rec709.max_element();
    if largest > 0.0 { (rec709 / largest).max(DVec3::ZERO).to_array() } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_fade_with_the_day() {
        let (night, dusk, day) = (limiting_magnitude(1.9e-4), limiting_magnitude(1.0), limiting_magnitude(3000.0));
        println!("{night:.2} {dusk:.2} {day:.2}");
        assert!((6.4..6.8).contains(&night) && (-5.0..-2.5).contains(&day) && (0.0..4.0).contains(&dusk));
        let mut before = f64::INFINITY;
        for i in 0..120 {
            let m = limiting_magnitude(1e-5 * 1.2f64.powi(i));
            assert!(m < before + 0.15, "{i}");
            before = m;
        }
    }

    #[test]
    fn rgb_has_the_illuminance_as_its_luminance() {
        let colour = pure_colour(DVec3::new(4.0, 2.0, -1.0));
        assert_eq!(colour, [1.0, 0.5, 0.0]);
        let rgb = with_luminance(colour, 1000.0);
        assert!((rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722)) - 1000.0).abs() < 1e-9);
        assert_eq!(with_luminance(pure_colour(DVec3::ZERO), 0.0), DVec3::ZERO);
    }
}
