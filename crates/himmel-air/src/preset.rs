//! Atmospheres as files for people: TOML, in km and nm, with sources. See `docs/air.md` for the format.

mod check;
mod file;

use std::sync::OnceLock;

use himmel_core::params::nearest;
use himmel_core::spectrum::Spectrum;

use crate::error::AirError;
use crate::light::Star;
use crate::medium::{Class, Medium};
use crate::params::{AirParams, GroundParams};
use check::Check;
use file::File;

macro_rules! embedded {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../../assets/presets/", $name, ".toml")))),+]
    };
}

/// Every preset that is compiled in: name and text.
const EMBEDDED: &[(&str, &str)] = embedded![
    "earth",
    "bruneton2017",
    "earth-haze",
    "mars-reference",
    "titan-reference",
    "earth-clean",
    "earth-urban",
    "earth-maritime",
    "earth-volcanic",
    "earth-klupiec",
    "earth-mueller-clean",
    "earth-mueller-polluted",
    "mars",
    "mars-dusty",
    "mars-collienne",
    "titan",
    "venus",
    "moonlet",
    "giant",
    "m-dwarf-ocean",
];

/// The names of the presets that are compiled in.
pub fn names() -> impl Iterator<Item = &'static str> {
    EMBEDDED.iter().map(|(name, _)| *name)
}

/// An atmosphere with its planet and what is said about its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// File stem or the name it is asked for by.
    pub name: String,
    /// One line about it.
    pub title: String,
    /// The planet and its air.
    pub medium: Medium,
    /// What lights it, at least one; the first is the one that colours are fitted to.
    pub stars: Vec<Star>,
    /// Distance of the first star in au; `None`: from the ephemeris (the Earth).
    pub sun_distance_au: Option<f64>,
    /// Whether the Earth's mean refraction lifts what is seen (off for other planets and for comparisons).
    pub refraction: bool,
}

impl Preset {
    /// One of the presets that are compiled in; see [`names`].
    pub fn named(name: &str) -> Result<Self, AirError> {
        // Each is read when it is first asked for: some compute their spheres.
        static PARSED: [OnceLock<Result<Preset, AirError>>; EMBEDDED.len()] =
            [const { OnceLock::new() }; EMBEDDED.len()];
        match EMBEDDED.iter().position(|(known, _)| *known == name) {
            Some(index) => PARSED[index].get_or_init(|| Self::from_toml(EMBEDDED[index].1, name)).clone(),
            None => Err(AirError::UnknownPreset {
                name: himmel_core::params::shorten(name),
                suggestion: nearest(name, names()),
            }),
        }
    }

    /// Reads a preset's TOML. `name` stands in error messages: the file's path, or its name.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, AirError> {
        let file: File = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| text[..span.start.min(text.len())].lines().count().max(1));
            let place = line.map_or_else(String::new, |line| format!("line {line}: "));
            let message = error.message().lines().collect::<Vec<_>>().join(" ");
            AirError::Syntax { file: name.into(), message: format!("{place}{message}") }
        })?;
        let mut check = Check { file: name, text, gravity_m_s2: None };
        if let Some(gravity) = file.planet.gravity_m_s2 {
            check.gravity_m_s2 =
                Some(check.within("planet.gravity_m_s2", gravity, 1e-4, 1e4, "lie in 0.0001..=1e4 m/s²")?);
        }
        if file.version != 1 {
            return Err(check.error("version", "be 1, the only version so far", f64::from(file.version)));
        }
        let radius_km = check.within("planet.radius_km", file.planet.radius_km, 1.0, 1e6, "lie in 1..=1e6 km")?;
        if file.component.is_empty() || file.component.len() > 16 {
            return Err(check.error("component", "have 1..=16 entries", file.component.len() as f64));
        }
        let components = file
            .component
            .into_iter()
            .enumerate()
            .map(|(index, table)| check.component(index, table))
            .collect::<Result<Vec<_>, _>>()?;
        let top_altitude_m = match file.planet.top_altitude_km {
            Some(km) => {
                check.within("planet.top_altitude_km", km, 0.1, 1e5, "lie above the ground: 0.1..=1e5 km")? * 1e3
            }
            None => Medium::natural_top_m(&components),
        };
        let ground_albedo = check.spectrum("ground.albedo", file.ground.albedo, 0.0, 1.0, "lie in 0..=1")?;
        let stars_given = !file.star.is_empty();
        check.within("star", file.star.len() as f64, 0.0, 8.0, "have at most 8 entries")?;
        let mut stars =
            file.star.into_iter().enumerate().map(|(i, star)| check.star(i, star)).collect::<Result<Vec<_>, _>>()?;
        let light_distance_au = match file.light {
            Some(light) if stars_given => {
                let law = "be left out where [[star]] gives distances";
                return Err(check.error("light.distance_au", law, light.distance_au));
            }
            Some(light) => {
                Some(check.within("light.distance_au", light.distance_au, 1e-3, 1e4, "lie in 0.001..=1e4 au")?)
            }
            None => None,
        };
        if stars.is_empty() {
            stars.push(Star { distance_au: light_distance_au, ..Star::sun() });
        }
        let sun_distance_au = stars[0].distance_au;
        Ok(Self {
            name: name.into(),
            title: file.title,
            medium: Medium { bottom_radius_m: radius_km * 1e3, top_altitude_m, components, ground_albedo },
            stars,
            sun_distance_au,
            refraction: file.planet.refraction,
        })
    }
}

impl Preset {
    /// The medium with the settings applied: factors on what the air is made of, the ground's albedo.
    pub fn medium_with(&self, air: &AirParams, ground: &GroundParams) -> Medium {
        let mut medium = self.medium.clone();
        for component in &mut medium.components {
            let factor = match component.class() {
                Class::Molecules => air.molecules,
                Class::Aerosols => air.aerosols,
                Class::Absorbers => air.absorbers,
            };
            component.amount *= if air.enabled { factor } else { 0.0 };
        }
        if !ground.enabled {
            medium.ground_albedo = Spectrum::Constant(0.0);
        } else if let Some(albedo) = ground.albedo {
            medium.ground_albedo = Spectrum::Constant(albedo);
        }
        medium
    }

    /// Spectral irradiance of the first star at one astronomical unit, W m⁻² nm⁻¹: what the colour matrix is fitted to.
    pub fn light_at_1_au_w_m2_nm(&self) -> Spectrum {
        match self.stars.first() {
            // The Sun itself keeps its own table, to the last bit.
            Some(Star { surface: crate::light::Surface::Sun, radius_suns: 1.0, .. }) | None => {
                crate::sun::irradiance_w_m2_nm().clone()
            }
            Some(star) => star.irradiance_at_1_au_w_m2_nm(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_embedded_preset_reads() {
        for name in names() {
            let preset = Preset::named(name).unwrap();
            assert!(preset.medium.top_altitude_m > 1e4, "{name}");
            assert!(!preset.medium.components.is_empty());
        }
    }

    /// A measured phase function, by angle and wavelength: scaled to integrate to 1; errors as everywhere.
    #[test]
    fn a_phase_function_may_be_a_table() {
        let good = EMBEDDED[1].1;
        let read = |table: &str| Preset::from_toml(&good.replacen("cornette_shanks = { g = 0.8 }", table, 1), "t");
        let table = "table = { wavelength_nm = [400, 700], angle_deg = [0, 90, 180], value = [[2, 2, 2], [3, 1, 3]] }";
        let phase = read(table).unwrap().medium.components[1].phase.clone().unwrap();
        assert!((phase.at(0.3, 400.0) - 0.25 / std::f64::consts::PI).abs() < 1e-6);
        assert!(
            phase.at(1.0, 700.0) > phase.at(0.0, 700.0) && (phase.legendre_moments(1, 550.0)[0] - 1.0).abs() < 1e-9
        );
        assert!(read(&table.replace("180", "170")).unwrap_err().to_string().contains("run from 0 to 180"));
        assert!(read(&table.replace("[3, 1, 3]", "[3, -1, 3]")).unwrap_err().to_string().contains("-1"));
        assert!(read(&table.replace("[3, 1, 3]", "[3, 1]")).is_err());
    }

    #[test]
    fn mistakes_name_file_line_value_and_bound() {
        let good = EMBEDDED[1].1;
        for (from, to, parts) in [
            ("radius_km = 6360", "radius_km = -1", vec!["test.toml", "planet.radius_km", "1..=1e6 km", "-1"]),
            ("radius_km", "radius_kn", vec!["line", "radius_kn"]),
            ("albedo = 0.1", "albedo = 1.5", vec!["ground.albedo", "0..=1", "1.5"]),
            ("albedo = 0.1", "albedo = nan", vec!["ground.albedo", "NaN"]),
            ("scale_height_km = 8.0", "scale_height_km = 0.0", vec!["(\"air\").profile.scale_height_km", "positive"]),
            ("version = 1", "version = 7", vec!["version", "7"]),
            (
                "single_scattering_albedo = 0.9",
                "single_scattering_albedo = 1.2",
                vec!["single_scattering_albedo", "1.2"],
            ),
            ("number_density_per_m3", "number_densty_per_m3", vec!["number_densty_per_m3"]),
            (
                "single_scattering_albedo = 0.9",
                "single_scattering_albedo = { reference_nm = 550, value = 0.9, exponent = -3 }",
                vec!["single_scattering_albedo", "0..=1"],
            ),
            ("extinction_per_m = 4.44e-6", "extinction_per_m = 4.44e-6\ncolumn_du = 3", vec!["aerosol"]),
            (
                "exponential = { scale_height_km = 1.2 }",
                "table = { altitude_km = [0, 1], value = [0, 0] }",
                vec!["profile"],
            ),
            // Line, value and bound; contradictions; gaps; nothing at all.
            (
                "number_density_per_m3 = 5",
                "number_density_per_m3 = -5",
                vec!["line 29:", "number_density_per_m3", "-5", "positive"],
            ),
            ("scale_height_km = 1.2", "scale_height_km = -1.2", vec!["line 23:", "component 2", "-1.2"]),
            ("top_altitude_km = 60", "top_altitude_km = -3", vec!["line 8:", "above the ground", "-3"]),
            ("number_density_per_m3", "column_du = 300\nnumber_density_per_m3", vec!["exactly one amount"]),
            (
                "extinction_per_m = 4.44e-6",
                "extinction_per_m = 4.44e-6\nvertical_optical_depth = 0.1",
                vec!["be said once"],
            ),
            ("extinction_per_m = 4.44e-6", "pressure_hpa = 3\nextinction_per_m = 4.44e-6", vec!["not be given twice"]),
            ("extinction_per_m = 4.44e-6", "", vec!["be said once"]),
            (
                "albedo = 0.1",
                "albedo = { wavelength_nm = [440, 680], value = [0.1, 0.2] }",
                vec!["line 11:", "cover 380 to 780", "440"],
            ),
            ("exponential = { scale_height_km = 1.2 }", "exponential = {}", vec!["scale_height_km", "temperature_k"]),
            (
                "exponential = { scale_height_km = 1.2 }",
                "table = { altitude_km = [0, 1], value = [0, 0] }",
                vec!["hold something"],
            ),
            (
                "exponential = { scale_height_km = 1.2 }",
                "table = { altitude_km = [1, 0], value = [1, 0] }",
                vec!["ascend"],
            ),
            ("g = 0.8", "g = 0.8, haze = 0.7", vec!["either g or haze"]),
        ] {
            assert!(good.contains(from), "{from}");
            let error = Preset::from_toml(&good.replacen(from, to, 1), "test.toml").unwrap_err().to_string();
            for part in parts {
                assert!(error.contains(part), "{error} lacks {part}");
            }
            assert!(!error.contains('\n'), "{error}");
        }
        assert!(Preset::from_toml(&good[..good.len() / 2], "half").is_err());
        let unknown = Preset::named("erth").unwrap_err().to_string();
        assert!(unknown.contains("did you mean earth?"), "{unknown}");
    }

    /// The standard atmosphere of `earth`: Rayleigh depth by Bodhaine within 1 %, aerosol 0.105, ozone 300 DU.
    #[test]
    fn earth_holds_what_it_says() {
        let earth = Preset::named("earth").unwrap();
        let depth = |name: &str, nm: f64| {
            let c = earth.medium.components.iter().find(|c| c.name == name).unwrap();
            (c.scattering_per_m.at(nm) + c.absorption_per_m.at(nm)) * c.profile.column_m(0.0, 1e6)
        };
        for (nm, published) in [(440.0, 0.2426), (550.0, 0.0971), (680.0, 0.0410)] {
            assert!((depth("air", nm) / published - 1.0).abs() < 0.01, "{nm}: {}", depth("air", nm));
        }
        assert!((depth("aerosol", 550.0) - 0.10).abs() < 1e-4);
        assert!((depth("stratospheric aerosol", 550.0) - 0.005).abs() < 1e-5);
        assert!((depth("ozone", 600.0) - 0.040).abs() < 0.001, "{}", depth("ozone", 600.0));
    }
}
