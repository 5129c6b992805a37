//! A preset with its settings, ready to be asked and to be drawn.

use std::sync::OnceLock;

use glam::{DVec3, DVec4};
use himmel_core::colour::rec709_from_xyz;

use crate::colour::{fit_xyz_from_four, rec709_rows};
use crate::columns::Columns;
use crate::irradiance::{Directions, sky_irradiance};
use crate::light::{Surface, planck_w_m2_sr_nm};
use crate::medium::{Medium, Sampled};
use crate::moments::{self, Moments, Quality, Scaled};
use crate::params::{AirParams, AirQuality, GroundParams};
use crate::preset::Preset;
use crate::scene_light::SceneLight;
use crate::single::{March, Ray, enter, march};
use crate::starlight::{SUN_LIKE_K, Starlight};

/// An atmosphere at four wavelengths, and its tables on the CPU, made when they are first asked for; it does not depend
/// on where the Sun is.
pub struct Atmosphere {
    medium: Medium,
    wavelengths_nm: [f64; 4],
    quality: Option<AirQuality>,
    steps: Option<u32>,
    columns: OnceLock<Columns>,
    moments: OnceLock<Moments<4>>,
    xyz_from_four: [DVec4; 3],
    scene_light: OnceLock<SceneLight>,
    scaled: OnceLock<Scaled>,
    /// What the matrix was fitted to.
    fitted_to: Medium,
    /// What starlight at the four wavelengths is relative to.
    star_reference: [f64; 4],
}

impl Atmosphere {
    /// Applies the settings to the preset and fits its matrix to colour (some tens of milliseconds).
    pub fn new(preset: &Preset, air: &AirParams, ground: &GroundParams) -> Self {
        let wavelengths_nm = air.wavelengths_nm();
        // Fitted to the preset as it is: thinner or thicker air of the same kind keeps its matrix.
        let columns = Columns::new(&preset.medium);
        let light = preset.light_at_1_au_w_m2_nm();
        let xyz_from_four = fit_xyz_from_four(&preset.medium, &columns, &light, &wavelengths_nm);
        Self::with_matrix(preset, air, ground, xyz_from_four)
    }

    /// The same after an edit: of the same preset at the same wavelengths it keeps the matrix, which makes it cheap.
    pub fn edited(&self, preset: &Preset, air: &AirParams, ground: &GroundParams) -> Self {
        if air.wavelengths_nm() == self.wavelengths_nm && preset.medium == self.fitted_to {
            return Self::with_matrix(preset, air, ground, self.xyz_from_four);
        }
        Self::new(preset, air, ground)
    }

    fn with_matrix(preset: &Preset, air: &AirParams, ground: &GroundParams, xyz_from_four: [DVec4; 3]) -> Self {
        Self {
            medium: preset.medium_with(air, ground),
            wavelengths_nm: air.wavelengths_nm(),
            quality: air.quality,
            steps: air.steps,
            columns: OnceLock::new(),
            moments: OnceLock::new(),
            scene_light: OnceLock::new(),
            scaled: OnceLock::new(),
            xyz_from_four,
            fitted_to: preset.medium.clone(),
            star_reference: air.wavelengths_nm().map(|nm| star_reference(preset, nm)),
        }
    }

    /// The quality that was asked for.
    pub fn quality(&self) -> Option<AirQuality> {
        self.quality
    }

    /// Cells along a ray that were asked for.
    pub fn steps(&self) -> Option<u32> {
        self.steps
    }

    /// Optical depth to space; made when first asked for (about 10 ms).
    pub fn columns(&self) -> &Columns {
        self.columns.get_or_init(|| Columns::new(&self.medium))
    }

    /// The moments of all orders of scattering; made when first asked for (seconds).
    pub fn moments(&self) -> &Moments<4> {
        self.moments.get_or_init(|| Moments::build(&self.sampled(), self.columns(), &Quality::default()))
    }

    /// The medium with the settings applied.
    pub fn medium(&self) -> &Medium {
        &self.medium
    }

    /// The coarse table of all orders that a scene's light is asked of; made when it is first asked for.
    pub fn scene_light(&self) -> &SceneLight {
        self.scene_light.get_or_init(|| SceneLight::build(&self.sampled(), self.columns()))
    }

    /// The medium at the four wavelengths.
    pub fn sampled(&self) -> Sampled<'_, 4> {
        self.medium.sampled(&self.wavelengths_nm)
    }

    /// The four wavelengths, nm.
    pub fn wavelengths_nm(&self) -> [f64; 4] {
        self.wavelengths_nm
    }

    /// Rows R, G, B that turn radiance per unit irradiance of the Sun at 1 au (sr⁻¹) into linear Rec. 709 in cd m⁻².
    pub fn rec709_from_four(&self) -> [DVec4; 3] {
        rec709_rows(&self.xyz_from_four)
    }

    /// Photometric XYZ of four values per unit irradiance of the Sun at 1 au: cd m⁻² or lx.
    pub fn xyz(&self, four: [f64; 4]) -> DVec3 {
        let four = DVec4::from_array(four);
        DVec3::from_array(self.xyz_from_four.map(|row| row.dot(four)))
    }

    /// Linear Rec. 709 of four values per unit irradiance of the Sun at 1 au: cd m⁻² or lx.
    pub fn rec709(&self, four: [f64; 4]) -> DVec3 {
        rec709_from_xyz() * self.xyz(four)
    }

    /// How light of stars is carried here.
    pub fn starlight(&self) -> Starlight {
        let one = |k: usize| std::array::from_fn(|i| f64::from(u8::from(i == k)));
        Starlight {
            wavelengths_nm: self.wavelengths_nm,
            reference: self.star_reference,
            luminance: std::array::from_fn(|k| self.xyz(one(k)).y),
        }
    }

    /// Transmittance from an altitude, within the air or above it, to space. `mu`: cosine of the zenith angle; 0 below
    /// the horizon.
    pub fn sun_transmittance(&self, altitude_m: f64, mu: f64) -> [f64; 4] {
        if altitude_m > self.medium.top_altitude_m {
            let ray = Ray { altitude_m, mu, mu_s: mu, nu: 1.0 };
            return match enter(self.medium.bottom_radius_m, self.medium.top_altitude_m, &ray) {
                Some(ray) => self.sun_transmittance(ray.altitude_m, ray.mu),
                None => [1.0; 4],
            };
        }
        crate::single::sun_transmittance(&self.sampled(), self.columns(), altitude_m, mu)
    }

    /// The same for extended things: what aerosols scatter forward is not lost to them.
    pub fn extended_transmittance(&self, altitude_m: f64, mu: f64) -> [f64; 4] {
        let (radius_m, top_m) = (self.medium.bottom_radius_m, self.medium.top_altitude_m);
        if mu < crate::geometry::horizon_cosine(radius_m, altitude_m) {
            return [0.0; 4];
        }
        match enter(radius_m, top_m, &Ray { altitude_m, mu, mu_s: mu, nu: 1.0 }) {
            Some(ray) => {
                let scaled = self.scaled.get_or_init(|| Scaled::new(&self.sampled()));
                scaled.transmittance(self.columns(), ray.altitude_m, ray.mu)
            }
            None => [1.0; 4],
        }
    }

    /// What a ray through the air sees of light scattered once.
    pub fn march(&self, ray: &Ray, steps: usize) -> March<4> {
        march(&self.sampled(), self.columns(), ray, steps)
    }

    /// What a ray through the air sees of light scattered any number of times, with the lit ground where it ends: the
    /// f64 twin of the renderer's march, per unit irradiance of the Sun, sr⁻¹.
    pub fn radiance(&self, ray: &Ray, steps: usize) -> [f64; 4] {
        moments::radiance(&self.sampled(), self.columns(), self.moments(), ray, steps)
    }

    /// The same of the first `limit_m` metres alone: what the air before something at that distance adds.
    pub fn radiance_to(&self, ray: &Ray, steps: usize, limit_m: f64) -> [f64; 4] {
        moments::radiance_to(&self.sampled(), self.columns(), self.moments(), ray, steps, limit_m)
    }

    /// Irradiance from the sky on a level surface at an altitude, per unit irradiance of the Sun.
    pub fn sky_irradiance(&self, altitude_m: f64, mu_s: f64) -> [f64; 4] {
        sky_irradiance(&self.sampled(), self.columns(), altitude_m, mu_s, Directions::FINE)
    }
}

/// The light that the preset's star stands for among black bodies, at a wavelength.
fn star_reference(preset: &Preset, wavelength_nm: f64) -> f64 {
    match preset.stars.first().map(|star| star.surface) {
        Some(Surface::BlackBody { temperature_k }) => planck_w_m2_sr_nm(wavelength_nm, temperature_k),
        Some(Surface::Sun) | None => planck_w_m2_sr_nm(wavelength_nm, SUN_LIKE_K),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_air_the_sun_keeps_its_illuminance() {
        let air = AirParams { enabled: false, ..AirParams::default() };
        let preset = Preset::named("earth").unwrap();
        let space = Atmosphere::new(&preset, &air, &GroundParams::default());
        assert_eq!(space.sun_transmittance(0.0, 0.5), [1.0; 4]);
        assert_eq!(space.sky_irradiance(0.0, 0.5), [0.0; 4]);
        let lux = space.xyz([1.0; 4]).y;
        assert!((lux / 1.33e5 - 1.0).abs() < 0.02, "{lux}");
    }

    #[test]
    fn from_orbit_the_sun_shines_until_it_meets_the_limb() {
        let preset = Preset::named("earth").unwrap();
        let air = Atmosphere::new(&preset, &AirParams::default(), &GroundParams::default());
        let at = |degrees: f64| air.sun_transmittance(400e3, degrees.to_radians().sin())[1];
        // The limb lies at −19.8°, the top of the air some 2° above it.
        assert_eq!(at(-10.0), 1.0);
        assert!(at(-18.5) > 0.9 && at(-19.6) < at(-18.5) && at(-19.6) > 0.0);
        assert_eq!(at(-21.0), 0.0);
    }

    #[test]
    fn adding_nothing_changes_nothing() {
        let preset = Preset::named("earth").unwrap();
        let mut more = preset.clone();
        let mut nothing = more.medium.components[1].clone();
        nothing.amount = 0.0;
        more.medium.components.push(nothing);
        let (air, ground) = (AirParams::default(), GroundParams::default());
        let ray = Ray { altitude_m: 0.0, mu: 0.3, mu_s: 0.4, nu: 0.2 };
        let (a, b) = (Atmosphere::new(&preset, &air, &ground), Atmosphere::new(&more, &air, &ground));
        assert_eq!(a.march(&ray, 32).radiance_per_sr, b.march(&ray, 32).radiance_per_sr);
    }
}
