//! A preset with its settings, ready to be asked and to be drawn.

use std::sync::OnceLock;

use glam::{DVec3, DVec4};
use himmel_core::colour::rec709_from_xyz;
use himmel_core::interpolate::lerp;

use crate::colour::{fit_xyz_from_four, rec709_rows};
use crate::columns::{self, Columns};
use crate::irradiance::{Directions, sky_irradiance, table_coordinate, table_elevation_rad};
use crate::medium::{Medium, Sampled};
use crate::params::{AirParams, GroundParams};
use crate::preset::Preset;
use crate::scene_light::SceneLight;
use crate::single::{March, Ray, enter, march};

/// Columns of the table of sky irradiance on the ground.
pub const IRRADIANCE_WIDTH: usize = 64;

/// An atmosphere at four wavelengths: the medium with its tables. Making one costs about 40 ms; it does not depend on
/// where the Sun is.
pub struct Atmosphere {
    medium: Medium,
    wavelengths_nm: [f64; 4],
    columns: Columns,
    xyz_from_four: [DVec4; 3],
    ground_sky_irradiance: Vec<[f64; 4]>,
    scene_light: OnceLock<SceneLight>,
}

impl Atmosphere {
    /// Applies the settings to the preset and integrates the tables.
    pub fn new(preset: &Preset, air: &AirParams, ground: &GroundParams) -> Self {
        let wavelengths_nm = air.wavelengths_nm();
        // Fitted to the preset as it is: thinner or thicker air of the same kind keeps its matrix.
        let columns = Columns::new(&preset.medium);
        let light = preset.light_at_1_au_w_m2_nm();
        let xyz_from_four = fit_xyz_from_four(&preset.medium, &columns, &light, &wavelengths_nm);
        let medium = preset.medium_with(air, ground);
        let ground_sky_irradiance = {
            let sampled = medium.sampled(&wavelengths_nm);
            let at = |x: usize| {
                let mu_s = table_elevation_rad(x as f64 / (IRRADIANCE_WIDTH - 1) as f64).sin();
                sky_irradiance(&sampled, &columns, 0.0, mu_s, Directions::TABLE)
            };
            (0..IRRADIANCE_WIDTH).map(at).collect()
        };
        Self { medium, wavelengths_nm, columns, xyz_from_four, ground_sky_irradiance, scene_light: OnceLock::new() }
    }

    /// The medium with the settings applied.
    pub fn medium(&self) -> &Medium {
        &self.medium
    }

    /// The columns of the medium's components.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// The coarse table of all orders that a scene's light is asked of; made when it is first asked for.
    pub fn scene_light(&self) -> &SceneLight {
        self.scene_light.get_or_init(|| SceneLight::build(&self.sampled(), &self.columns))
    }

    /// The medium at the four wavelengths.
    pub fn sampled(&self) -> Sampled<'_, 4> {
        self.medium.sampled(&self.wavelengths_nm)
    }

    /// The four wavelengths, nm.
    pub fn wavelengths_nm(&self) -> [f64; 4] {
        self.wavelengths_nm
    }

    /// Irradiance of the sky on the ground over Sun elevation (see [`table_elevation_rad`]), per unit irradiance of
    /// the Sun.
    pub fn ground_sky_irradiance(&self) -> &[[f64; 4]] {
        &self.ground_sky_irradiance
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

    /// Optical depth to space at a node of the table, at the four wavelengths.
    pub fn depth_at_node(&self, air: &Sampled<'_, 4>, x: usize, y: usize) -> [f64; 4] {
        let mut depth = [0.0; 4];
        for (index, component) in air.components.iter().enumerate() {
            let column = self.columns.node_m(index, x, y);
            for k in 0..4 {
                depth[k] += column * component.extinction_per_m[k];
            }
        }
        depth
    }

    /// Width and height of the optical-depth table.
    pub fn depth_size(&self) -> (usize, usize) {
        (columns::WIDTH, columns::HEIGHT)
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
        crate::single::sun_transmittance(&self.sampled(), &self.columns, altitude_m, mu)
    }

    /// What a ray through the air sees: the f64 twin of the renderer's march.
    pub fn march(&self, ray: &Ray, steps: usize) -> March<4> {
        march(&self.sampled(), &self.columns, ray, steps)
    }

    /// Radiance that leaves the ground where the Sun stands at a zenith cosine, per unit irradiance of the Sun, sr⁻¹.
    pub fn ground_radiance(&self, mu_s: f64) -> [f64; 4] {
        let through = self.sun_transmittance(0.0, mu_s);
        let u = table_coordinate(mu_s);
        let x = u * (IRRADIANCE_WIDTH - 1) as f64;
        let x0 = (x.max(0.0) as usize).min(IRRADIANCE_WIDTH - 2);
        let albedo = self.sampled().ground_albedo;
        std::array::from_fn(|k| {
            let log = |i: usize| self.ground_sky_irradiance[i][k].max(1e-30).log2();
            let sky = if u < 0.0 { 0.0 } else { lerp(log(x0), log(x0 + 1), x - x0 as f64).exp2() };
            albedo[k] / std::f64::consts::PI * (through[k] * mu_s.max(0.0) + sky)
        })
    }

    /// Irradiance from the sky on a level surface at an altitude, per unit irradiance of the Sun.
    pub fn sky_irradiance(&self, altitude_m: f64, mu_s: f64) -> [f64; 4] {
        sky_irradiance(&self.sampled(), &self.columns, altitude_m, mu_s, Directions::FINE)
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
