//! Atmospheres as files for people: TOML, in km and nm, with sources. See `docs/presets.md` for the format.

use std::sync::OnceLock;

use himmel_core::constants::DOBSON_UNIT_PER_M2;
use himmel_core::params::nearest;
use himmel_core::spectrum::{Spectrum, read_columns};
use serde::Deserialize;

use crate::error::AirError;
use crate::medium::{Component, Medium};
use crate::phase::Phase;
use crate::profile::Profile;
use crate::rayleigh::{AIR_GAMMA, air_cross_section_m2};

macro_rules! embedded {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../../assets/presets/", $name, ".toml")))),+]
    };
}

/// Every preset that is compiled in: name and text.
const EMBEDDED: &[(&str, &str)] = embedded!["earth", "bruneton2017", "earth-haze", "mars-reference", "titan-reference"];

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
    /// Distance of the Sun in au; `None`: from the ephemeris (the Earth).
    pub sun_distance_au: Option<f64>,
    /// Whether the Earth's mean refraction lifts what is seen (off for other planets and for comparisons).
    pub refraction: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    version: u32,
    title: String,
    #[allow(dead_code)] // for people who read the file
    source: String,
    planet: PlanetTable,
    ground: GroundTable,
    light: Option<LightTable>,
    component: Vec<ComponentTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanetTable {
    radius_km: f64,
    top_altitude_km: Option<f64>,
    #[serde(default)]
    refraction: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GroundTable {
    albedo: SpectrumTable,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    distance_au: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ComponentTable {
    name: String,
    profile: ProfileTable,
    phase: Option<PhaseTable>,
    extinction_per_m: Option<SpectrumTable>,
    vertical_optical_depth: Option<SpectrumTable>,
    single_scattering_albedo: Option<SpectrumTable>,
    cross_section: Option<CrossSection>,
    number_density_per_m3: Option<f64>,
    column_du: Option<f64>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
enum CrossSection {
    Air,
    /// The table's averages over [λ, λ + 10 nm), each at the middle of its bin.
    Ozone,
    /// The same numbers at the printed λ, as published comparisons read them.
    OzoneAsPrinted,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a number, { wavelength_nm = […], value = […] } or { reference_nm = …, value = …, exponent = … }"
)]
enum SpectrumTable {
    Constant(f64),
    Whole(i64),
    Table { wavelength_nm: Vec<f64>, value: Vec<f64> },
    PowerLaw { reference_nm: f64, value: f64, exponent: f64 },
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum ProfileTable {
    Exponential { scale_height_km: f64 },
    Gaussian { centre_km: f64, width_km: f64 },
    Tent { bottom_km: f64, peak_km: f64, top_km: f64 },
    Table { altitude_km: Vec<f64>, value: Vec<f64> },
    OzoneUs1976 {},
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum PhaseTable {
    Rayleigh {
        #[serde(default)]
        depolarisation: f64,
    },
    HenyeyGreenstein {
        g: SpectrumTable,
    },
    CornetteShanks {
        g: SpectrumTable,
    },
}

/// Checks values and names file, key and value in its errors.
struct Check<'a> {
    file: &'a str,
}

impl Check<'_> {
    fn error(&self, what: impl Into<String>, law: &'static str, got: f64) -> AirError {
        AirError::Value { file: self.file.into(), what: what.into(), law, got }
    }

    fn positive(&self, what: &str, value: f64) -> Result<f64, AirError> {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            Err(self.error(what, "be positive and finite", value))
        }
    }

    fn within(&self, what: &str, value: f64, low: f64, high: f64, law: &'static str) -> Result<f64, AirError> {
        if (low..=high).contains(&value) { Ok(value) } else { Err(self.error(what, law, value)) }
    }

    fn ascending(&self, what: &str, nodes: &[f64], values: usize) -> Result<(), AirError> {
        if nodes.is_empty() || nodes.len() != values {
            return Err(self.error(what, "have as many values as nodes, and at least one", values as f64));
        }
        match nodes.windows(2).find(|pair| pair[0].is_nan() || pair[1].is_nan() || pair[1] <= pair[0]) {
            Some(pair) => Err(self.error(what, "ascend", pair[1])),
            None => Ok(()),
        }
    }

    fn spectrum(
        &self,
        what: &str,
        table: SpectrumTable,
        low: f64,
        high: f64,
        law: &'static str,
    ) -> Result<Spectrum, AirError> {
        let spectrum = match table {
            SpectrumTable::Constant(value) => Spectrum::Constant(value),
            SpectrumTable::Whole(value) => Spectrum::Constant(value as f64),
            SpectrumTable::Table { wavelength_nm, value } => {
                self.ascending(what, &wavelength_nm, value.len())?;
                Spectrum::Table { wavelength_nm, value }
            }
            SpectrumTable::PowerLaw { reference_nm, value, exponent } => {
                self.positive(&format!("{what}.reference_nm"), reference_nm)?;
                self.within(&format!("{what}.exponent"), exponent, -10.0, 10.0, "lie in -10..=10")?;
                Spectrum::PowerLaw { reference_nm, value, exponent }
            }
        };
        for &value in spectrum.values() {
            self.within(what, value, low, high, law)?;
        }
        // A power law has its extremes at the ends of what is rendered.
        for wavelength_nm in [360.0, 830.0] {
            self.within(what, spectrum.at(wavelength_nm), low, high, law)?;
        }
        Ok(spectrum)
    }

    fn profile(&self, what: &str, table: ProfileTable) -> Result<Profile, AirError> {
        let km = |name: &str, value: f64| {
            self.within(&format!("{what}.{name}"), value, 0.0, 1e5, "lie in 0..=1e5 km").map(|v| v * 1e3)
        };
        Ok(match table {
            ProfileTable::Exponential { scale_height_km } => {
                self.positive(&format!("{what}.scale_height_km"), scale_height_km)?;
                Profile::Exponential { scale_height_m: scale_height_km * 1e3 }
            }
            ProfileTable::Gaussian { centre_km, width_km } => {
                self.positive(&format!("{what}.width_km"), width_km)?;
                Profile::Gaussian { centre_m: km("centre_km", centre_km)?, width_m: width_km * 1e3 }
            }
            ProfileTable::Tent { bottom_km, peak_km, top_km } => {
                let (bottom_m, peak_m, top_m) =
                    (km("bottom_km", bottom_km)?, km("peak_km", peak_km)?, km("top_km", top_km)?);
                self.ascending(what, &[bottom_m, peak_m, top_m], 3)?;
                Profile::Tent { bottom_m, peak_m, top_m }
            }
            ProfileTable::Table { altitude_km, value } => {
                self.ascending(what, &altitude_km, value.len())?;
                for &value in &value {
                    self.within(what, value, 0.0, 1e30, "be zero or positive")?;
                }
                Profile::Table { altitude_m: altitude_km.iter().map(|&z| z * 1e3).collect(), value }
            }
            ProfileTable::OzoneUs1976 {} => {
                let (altitude_m, value) =
                    read_columns(include_str!("../../../assets/air/ozone_profile_us1976.csv"), 0, 1);
                let peak = value.iter().copied().fold(0.0, f64::max);
                Profile::Table { altitude_m, value: value.iter().map(|v| v / peak).collect() }
            }
        })
    }

    fn phase(&self, what: &str, table: PhaseTable) -> Result<Phase, AirError> {
        let g = |table| self.spectrum(&format!("{what}.g"), table, -0.999, 0.999, "lie in -0.999..=0.999");
        Ok(match table {
            PhaseTable::Rayleigh { depolarisation } => {
                let delta =
                    self.within(&format!("{what}.depolarisation"), depolarisation, 0.0, 0.5, "lie in 0..=0.5")?;
                Phase::Rayleigh { gamma: delta / (2.0 - delta) }
            }
            PhaseTable::HenyeyGreenstein { g: table } => Phase::HenyeyGreenstein { g: g(table)? },
            PhaseTable::CornetteShanks { g: table } => Phase::CornetteShanks { g: g(table)? },
        })
    }

    fn component(&self, index: usize, table: ComponentTable) -> Result<Component, AirError> {
        let what = |key: &str| format!("component {} (\"{}\").{key}", index + 1, table.name);
        let profile = self.profile(&what("profile"), table.profile)?;
        let column_m = profile.column_m(0.0, 1e7);
        if !(column_m.is_finite() && column_m > 0.0) {
            return Err(self.error(what("profile"), "hold something between the ground and 10,000 km", column_m));
        }
        let amounts = [table.number_density_per_m3, table.column_du];
        if let (None, Some(extra)) = (table.cross_section, amounts.into_iter().flatten().next()) {
            let law = "stand without number_density_per_m3 and column_du, which belong to cross_section";
            return Err(self.error(what("extinction_per_m"), law, extra));
        }
        let non_negative = |key: &str, spectrum| self.spectrum(&what(key), spectrum, 0.0, 1e6, "be zero or positive");
        let scaled = |spectrum: Spectrum, factor: f64| match spectrum {
            Spectrum::Constant(value) => Spectrum::Constant(value * factor),
            Spectrum::Table { wavelength_nm, value } => {
                Spectrum::Table { wavelength_nm, value: value.iter().map(|v| v * factor).collect() }
            }
            Spectrum::PowerLaw { reference_nm, value, exponent } => {
                Spectrum::PowerLaw { reference_nm, value: value * factor, exponent }
            }
        };
        let (extinction, default_phase) =
            match (table.extinction_per_m, table.vertical_optical_depth, table.cross_section) {
                (Some(per_m), None, None) => (non_negative("extinction_per_m", per_m)?, None),
                (None, Some(depth), None) => {
                    (scaled(non_negative("vertical_optical_depth", depth)?, 1.0 / column_m), None)
                }
                (None, None, Some(kind)) => {
                    let per_m3 = match (table.number_density_per_m3, table.column_du) {
                        (Some(density), None) => self.positive(&what("number_density_per_m3"), density)?,
                        (None, Some(du)) => {
                            self.within(&what("column_du"), du, 0.0, 1e6, "lie in 0..=1e6 DU")? * DOBSON_UNIT_PER_M2
                                / column_m
                        }
                        _ => {
                            return Err(self.error(
                                what("cross_section"),
                                "come with either number_density_per_m3 or column_du",
                                0.0,
                            ));
                        }
                    };
                    let spectrum = match kind {
                        CrossSection::Air => {
                            let wavelength_nm: Vec<f64> = (25..=90).map(|i| f64::from(i) * 10.0).collect();
                            let value = wavelength_nm.iter().map(|&nm| air_cross_section_m2(nm)).collect();
                            Spectrum::Table { wavelength_nm, value }
                        }
                        CrossSection::Ozone | CrossSection::OzoneAsPrinted => {
                            let csv = include_str!("../../../assets/air/ozone_cross_section.csv");
                            let (wavelength_nm, value) = read_columns(csv, 0, 1);
                            let shift = if kind == CrossSection::Ozone { 5.0 } else { 0.0 };
                            Spectrum::Table {
                                wavelength_nm: wavelength_nm.iter().map(|nm| nm + shift).collect(),
                                value,
                            }
                        }
                    };
                    let phase = (kind == CrossSection::Air).then_some(Phase::Rayleigh { gamma: AIR_GAMMA });
                    (scaled(spectrum, per_m3), phase)
                }
                _ => {
                    return Err(self.error(
                        what("extinction_per_m"),
                        "be the only amount: give one of extinction_per_m, vertical_optical_depth, cross_section",
                        0.0,
                    ));
                }
            };
        let phase = match table.phase {
            Some(phase) => Some(self.phase(&what("phase"), phase)?),
            None => default_phase,
        };
        let albedo = match table.single_scattering_albedo {
            Some(albedo) => self.spectrum(&what("single_scattering_albedo"), albedo, 0.0, 1.0, "lie in 0..=1")?,
            None => Spectrum::Constant(if phase.is_some() { 1.0 } else { 0.0 }),
        };
        if phase.is_none() && albedo.values().iter().any(|&a| a > 0.0) {
            return Err(self.error(what("phase"), "be given where something scatters", 0.0));
        }
        let (scattering_per_m, absorption_per_m) = split(&extinction, &albedo);
        Ok(Component { name: table.name, profile, scattering_per_m, absorption_per_m, phase, amount: 1.0 })
    }
}

/// Scattering and absorption from extinction and albedo, on the wavelengths of both.
fn split(extinction: &Spectrum, albedo: &Spectrum) -> (Spectrum, Spectrum) {
    if let Spectrum::Constant(a) = albedo {
        if *a == 1.0 {
            return (extinction.clone(), Spectrum::Constant(0.0));
        }
        if *a == 0.0 {
            return (Spectrum::Constant(0.0), extinction.clone());
        }
    }
    // Elsewhere on a 5 nm grid: the product of two tables is not piecewise linear.
    let wavelength_nm: Vec<f64> = (0..=140).map(|i| 250.0 + 5.0 * f64::from(i)).collect();
    let product =
        |f: &dyn Fn(f64) -> f64| wavelength_nm.iter().map(|&nm| extinction.at(nm) * f(albedo.at(nm))).collect();
    let (scattering, absorption) = (product(&|a| a), product(&|a| 1.0 - a));
    (
        Spectrum::Table { wavelength_nm: wavelength_nm.clone(), value: scattering },
        Spectrum::Table { wavelength_nm: wavelength_nm.clone(), value: absorption },
    )
}

impl Preset {
    /// One of the presets that are compiled in; see [`names`].
    pub fn named(name: &str) -> Result<Self, AirError> {
        static PARSED: OnceLock<Vec<Result<Preset, AirError>>> = OnceLock::new();
        let parsed = PARSED.get_or_init(|| EMBEDDED.iter().map(|(name, text)| Self::from_toml(text, name)).collect());
        match EMBEDDED.iter().position(|(known, _)| *known == name) {
            Some(index) => parsed[index].clone(),
            None => Err(AirError::UnknownPreset {
                name: himmel_core::params::shorten(name),
                suggestion: nearest(name, names()),
            }),
        }
    }

    /// Reads a preset's TOML. `name` stands in error messages: the file's path, or its name.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, AirError> {
        let check = Check { file: name };
        let file: File = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| text[..span.start.min(text.len())].lines().count().max(1));
            let place = line.map_or_else(String::new, |line| format!("line {line}: "));
            let message = error.message().lines().collect::<Vec<_>>().join(" ");
            AirError::Syntax { file: name.into(), message: format!("{place}{message}") }
        })?;
        if file.version != 1 {
            return Err(check.error("version", "be 1, the only version so far", f64::from(file.version)));
        }
        let radius_km = check.within("planet.radius_km", file.planet.radius_km, 1.0, 1e6, "lie in 1..=1e6 km")?;
        let components = file
            .component
            .into_iter()
            .enumerate()
            .map(|(index, table)| check.component(index, table))
            .collect::<Result<Vec<_>, _>>()?;
        if components.len() > 16 {
            return Err(check.error("component", "have at most 16 entries", components.len() as f64));
        }
        let top_altitude_m = match file.planet.top_altitude_km {
            Some(km) => check.within("planet.top_altitude_km", km, 0.1, 1e5, "lie in 0.1..=1e5 km")? * 1e3,
            None => Medium::natural_top_m(&components),
        };
        let ground_albedo = check.spectrum("ground.albedo", file.ground.albedo, 0.0, 1.0, "lie in 0..=1")?;
        let sun_distance_au = match file.light {
            Some(light) => {
                Some(check.within("light.distance_au", light.distance_au, 1e-3, 1e4, "lie in 0.001..=1e4 au")?)
            }
            None => None,
        };
        Ok(Self {
            name: name.into(),
            title: file.title,
            medium: Medium { bottom_radius_m: radius_km * 1e3, top_altitude_m, components, ground_albedo },
            sun_distance_au,
            refraction: file.planet.refraction,
        })
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
            ("column_du = 300", "colum_du = 300", vec!["colum_du"]),
            (
                "single_scattering_albedo = 0.9",
                "single_scattering_albedo = { reference_nm = 550, value = 0.9, exponent = -3 }",
                vec!["single_scattering_albedo", "0..=1"],
            ),
            ("extinction_per_m = 4.44e-6", "extinction_per_m = 4.44e-6\ncolumn_du = 3", vec!["aerosol", "column_du"]),
            (
                "exponential = { scale_height_km = 1.2 }",
                "table = { altitude_km = [0, 1], value = [0, 0] }",
                vec!["profile", "hold"],
            ),
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
