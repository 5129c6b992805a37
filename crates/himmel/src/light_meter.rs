//! A light meter: what falls on a level surface and comes from the zenith, with all orders of scattering, by wavelength.

use std::f64::consts::PI;

use glam::DVec3;
use himmel_air::irradiance::Directions;
use himmel_air::moments::{self, Moments, Quality};
use himmel_air::reference::{Effort, MOST_SAMPLES, Side, Source, Tracer, for_each_parallel};
use himmel_air::single::Ray;
use himmel_air::sun::{limb_darkening, relative_disc_brightness};
use himmel_air::{AirError, Columns, geometry};
use himmel_core::quadrature::gauss_legendre_unit;
use himmel_gpu::GpuError;

use crate::error::Result;
use crate::model::{SkyModel, SunPlace, direction_enu};
use crate::spectral::{WAVELENGTHS, wavelengths_nm, xyz_weights};

/// Independent parts that a measurement consists of, at least: its error comes from them.
const FEWEST_PARTS: u64 = 32;
/// Parts, at most, and paths of each part where there are fewer.
const MOST_PARTS: u64 = 4096;
const PATHS_PER_PART: u64 = 1024;
/// The fewest paths: 32 for each part.
const FEWEST_PATHS: u64 = 32 * FEWEST_PARTS;
/// Streams of random numbers of the zenith's parts begin here.
const ZENITH_STREAM: u64 = 1 << 32;
/// A star higher than this lights the air like one beam: what its disc adds to level surfaces and the zenith is below 1e-4.
const HIGH_DEG: f64 = 4.0;
/// Strips of the Sun's disc, and points across each.
const STRIPS: usize = 16;
const POINTS: usize = 6;

/// Cells along a ray to the zenith.
const STEPS: usize = 32;

/// What measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSolver {
    /// Light scattered once, as it is drawn: [`SkyModel::light`]. At the renderer's four wavelengths.
    First,
    /// All orders by the table of moments: without noise, within some percent by day.
    Moments,
    /// All orders by the Monte Carlo tracer, with standard errors.
    Reference {
        /// Paths for the level surface; the zenith takes as many again. At least 1024.
        samples: u64,
        /// Seed of the random numbers: the same one gives the same numbers, whatever the machine's threads.
        seed: u64,
    },
}

/// A quantity with its standard error; `None` where nothing is left to chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Its value.
    pub value: f64,
    /// Standard error of the mean over independent parts.
    pub standard_error: Option<f64>,
}

/// Spectra at some wavelengths, W m⁻² nm⁻¹ (or per sr).
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpectrum {
    /// Vacuum wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// Of the star on a surface that faces it, W m⁻² nm⁻¹.
    pub sun_normal: Vec<f64>,
    /// Of the star on a level surface, W m⁻² nm⁻¹.
    pub sun_horizontal: Vec<f64>,
    /// Of the sky on a level surface, W m⁻² nm⁻¹.
    pub sky_horizontal: Vec<f64>,
    /// Standard error of the sky's; empty where nothing is left to chance.
    pub sky_standard_error: Vec<f64>,
    /// Of the zenith, W m⁻² sr⁻¹ nm⁻¹; the star's disc is not in it.
    pub zenith: Vec<f64>,
}

/// Light at the observer.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredLight {
    /// Where the star is.
    pub sun: SunPlace,
    /// Illuminance by the star on a surface that faces it, lx.
    pub sun_normal_lx: f64,
    /// Illuminance by the star on a level surface, lx.
    pub sun_horizontal_lx: f64,
    /// Illuminance by the sky on a level surface, lx.
    pub sky_lx: Measured,
    /// Luminance of the zenith, without the star's disc, cd m⁻².
    pub zenith_cd_m2: Measured,
    /// The same light by wavelength.
    pub spectrum: LightSpectrum,
}

impl MeasuredLight {
    /// Illuminance of a level surface by star and sky, lx.
    pub fn horizontal_lx(&self) -> Measured {
        Measured { value: self.sun_horizontal_lx + self.sky_lx.value, ..self.sky_lx }
    }
}

/// A meter that is prepared for the air of a model. Times and places may change between measurements, the air may not.
///
/// The star's own light comes from its refracted disc, or the part of it above the horizon, through the air along the
/// straight line there (as the renderer has it; no eclipse is in it: ask [`SkyModel::light`]); air is lit from its airless place, by moments and at first order as by a
/// parallel beam, for the reference near the horizon by the disc.
///
/// ```
/// use himmel::{LightMeter, LightSolver, Scene, SkyModel};
/// let mut scene = Scene::default();
/// scene.set("light.sun.altitude_deg", "30")?;
/// let model = SkyModel::new(&scene)?;
/// let meter = LightMeter::new(&model, LightSolver::Reference { samples: 1024, seed: 1 })?;
/// let light = meter.measure(&model, &mut |_| true)?;
/// assert!(light.horizontal_lx().value > 40_000.0);
/// # Ok::<(), himmel::Error>(())
/// ```
pub struct LightMeter {
    tracer: Tracer<WAVELENGTHS>,
    solver: Solver,
    light_w_m2_nm: [f64; WAVELENGTHS],
    xyz: [DVec3; WAVELENGTHS],
}

enum Solver {
    First,
    Moments(Box<(Columns, Moments<WAVELENGTHS>)>),
    Reference(Parts),
}

#[derive(Clone, Copy)]
struct Parts {
    count: u64,
    effort: Effort,
}

/// Per unit irradiance of the star, by wavelength.
type Relative = [f64; WAVELENGTHS];

impl LightMeter {
    /// Prepares it: a tenth of a second for first order and reference, longer for moments.
    ///
    /// Errors: too few or too many paths; a medium that the tracer refuses.
    pub fn new(model: &SkyModel, solver: LightSolver) -> Result<Self> {
        let solver = match solver {
            LightSolver::First => Solver::First,
            LightSolver::Moments => Self::moments(model),
            LightSolver::Reference { samples, seed } => {
                if !(FEWEST_PATHS..=MOST_SAMPLES).contains(&samples) {
                    let law = "lie in 1024..=1e12 (an error needs 32 parts of 32 paths)";
                    let got = samples as f64;
                    return Err(AirError::Optics { what: "number of samples".into(), law, got }.into());
                }
                let count = (samples / PATHS_PER_PART).clamp(FEWEST_PARTS, MOST_PARTS);
                let effort = Effort { samples: samples.div_ceil(count), seed, ..Effort::default() };
                Solver::Reference(Parts { count, effort })
            }
        };
        let nodes = wavelengths_nm();
        let light = model.preset().light_at_1_au_w_m2_nm();
        let xyz = xyz_weights(&light);
        let medium = model.atmosphere().medium();
        // Twilight's violet and red count for colour, too: no wavelength is left without paths of its own.
        let largest = xyz.iter().map(|weight| weight.y).fold(0.0, f64::max);
        let tracer = Tracer::new(&medium.sampled(&nodes))?.weighted(xyz.map(|w| w.y.max(0.05 * largest)));
        Ok(Self { tracer, solver, light_w_m2_nm: light.sample(&nodes), xyz })
    }

    /// The table of moments of the model's air.
    fn moments(model: &SkyModel) -> Solver {
        let medium = model.atmosphere().medium();
        let columns = Columns::new(medium);
        let moments = Moments::build(&medium.sampled(&wavelengths_nm()), &columns, &Quality::default());
        Solver::Moments(Box::new((columns, moments)))
    }

    /// Measures a model's light. `progress` is told the share done and answers whether to go on.
    ///
    /// Errors: a date that the ephemeris refuses; cancelled.
    pub fn measure(&self, model: &SkyModel, progress: &mut dyn FnMut(f64) -> bool) -> Result<MeasuredLight> {
        let place = model.sun()?;
        let star_at_1_au = model.scene().sun.brightness / place.distance_au.powi(2);
        if let Solver::First = self.solver {
            return first(model, &place, star_at_1_au);
        }
        let (normal, horizontal) = self.star(model, &place)?;
        let (sky, zenith) = match &self.solver {
            Solver::First => (vec![[0.0; WAVELENGTHS]], vec![[0.0; WAVELENGTHS]]),
            Solver::Moments(tables) => {
                let (sky, zenith) = self.by_moments(model, &place, tables)?;
                (vec![sky], vec![zenith])
            }
            Solver::Reference(parts) => self.by_reference(model, &place, parts, progress)?,
        };
        let scale = |relative: &Relative| -> Vec<f64> {
            relative.iter().zip(self.light_w_m2_nm).map(|(value, light)| value * light * star_at_1_au).collect()
        };
        let luminous = |relative: &Relative| -> f64 {
            relative.iter().zip(self.xyz).map(|(value, weight)| value * weight.y).sum::<f64>() * star_at_1_au
        };
        let measured = |parts: &[Relative]| mean_and_error(parts.iter().map(luminous).collect());
        let by_wavelength = |parts: &[Relative]| -> Vec<Measured> {
            (0..WAVELENGTHS).map(|k| mean_and_error(parts.iter().map(|part| scale(part)[k]).collect())).collect()
        };
        let sky_spectrum = by_wavelength(&sky);
        Ok(MeasuredLight {
            sun: place,
            sun_normal_lx: luminous(&normal),
            sun_horizontal_lx: luminous(&horizontal),
            sky_lx: measured(&sky),
            zenith_cd_m2: measured(&zenith),
            spectrum: LightSpectrum {
                wavelengths_nm: wavelengths_nm().to_vec(),
                sun_normal: scale(&normal),
                sun_horizontal: scale(&horizontal),
                sky_horizontal: sky_spectrum.iter().map(|m| m.value).collect(),
                sky_standard_error: sky_spectrum.iter().filter_map(|m| m.standard_error).collect(),
                zenith: by_wavelength(&zenith).iter().map(|m| m.value).collect(),
            },
        })
    }

    /// Light of the star itself on surfaces that face it and that lie level: horizontal strips of the part of its disc above
    /// the horizon, each through the air along the straight line.
    fn star(&self, model: &SkyModel, place: &SunPlace) -> Result<(Relative, Relative)> {
        let altitude_m = model.altitude_m();
        let limb = limb(model);
        let radius_m = model.atmosphere().medium().bottom_radius_m;
        let horizon_deg = geometry::horizon_cosine(radius_m, altitude_m).asin().to_degrees();
        let radius_deg = place.radius_deg.max(1e-9);
        // Heights are in radii from the disc's centre; its lowest visible one first.
        let lowest = ((horizon_deg - place.altitude_deg) / radius_deg).clamp(-1.0, 1.0);
        let (mut normal, mut horizontal) = ([0.0; WAVELENGTHS], [0.0; WAVELENGTHS]);
        for (s, w) in gauss_legendre_unit(STRIPS) {
            let height = lowest + (1.0 - lowest) * s;
            let half_chord = (1.0 - height * height).max(0.0).sqrt();
            let altitude_rad = (place.altitude_deg + height * radius_deg).to_radians();
            let mu = altitude_rad.sin();
            let through = self.tracer.transmittance(altitude_m, DVec3::new(altitude_rad.cos(), 0.0, mu))?;
            for k in 0..WAVELENGTHS {
                let across: f64 = gauss_legendre_unit(POINTS)
                    .iter()
                    .map(|(x, w)| w * relative_disc_brightness(height.hypot(half_chord * x), &limb[k]))
                    .sum();
                // A disc of even brightness 1 sums to 1.
                let part = (1.0 - lowest) * w * 2.0 * half_chord * across / PI * through[k];
                normal[k] += part;
                horizontal[k] += part * mu.max(0.0);
            }
        }
        Ok((normal, horizontal))
    }

    /// Level surface and zenith by moments.
    fn by_moments(
        &self,
        model: &SkyModel,
        place: &SunPlace,
        tables: &(Columns, Moments<WAVELENGTHS>),
    ) -> Result<(Relative, Relative)> {
        let (columns, moments) = tables;
        let (medium, altitude_m) = (model.atmosphere().medium(), model.altitude_m());
        let air = medium.sampled(&wavelengths_nm());
        let sun = direction_enu(place.azimuth_deg, place.airless_altitude_deg);
        let up = Ray { altitude_m, mu: 1.0, mu_s: sun.z, nu: sun.z };
        let zenith = moments::radiance(&air, columns, moments, &up, STEPS);
        if altitude_m >= medium.top_altitude_m {
            return Ok(([0.0; WAVELENGTHS], zenith));
        }
        let light = moments::irradiance(&air, columns, moments, altitude_m, sun.z, Directions::FINE);
        // What aerosols scatter into their forward peak is light of the sky.
        let through = self.tracer.transmittance(altitude_m, sun.normalize())?;
        let sky = std::array::from_fn(|k| (light.down[k] + light.direct[k] - through[k] * sun.z.max(0.0)).max(0.0));
        Ok((sky, zenith))
    }

    /// The star as the air sees it: a beam, or near the horizon three of them, at its centre and √½ radii above and below.
    ///
    /// What a level surface gets depends on the height h of a point of the disc alone (in radii), and smoothly: three
    /// heights with the disc's own mean of h² at each wavelength, m, are exact up to third powers; weights m, 1 − 2m, m.
    /// (Tried: [`Source`] as a disc of 24 points, which costs eight times as much.)
    fn beams(&self, model: &SkyModel, place: &SunPlace) -> Vec<Source<WAVELENGTHS>> {
        let beam = |height: f64, irradiance: Relative| {
            let altitude_deg = place.airless_altitude_deg + height * place.radius_deg;
            let direction = direction_enu(place.azimuth_deg, altitude_deg).normalize();
            Source { irradiance, ..Source::beam(direction) }
        };
        if place.airless_altitude_deg - place.radius_deg > HIGH_DEG {
            return vec![beam(0.0, [1.0; WAVELENGTHS])];
        }
        let limb = limb(model);
        let side = limb.map(|coefficients| {
            // ⟨h²⟩ = ⟨ρ²⟩/2 = ∫ρ² B(ρ) ρ dρ.
            gauss_legendre_unit(8)
                .iter()
                .map(|(x, w)| w * x.powi(3) * relative_disc_brightness(*x, &coefficients))
                .sum()
        });
        let height = 0.5f64.sqrt();
        vec![beam(-height, side), beam(0.0, side.map(|m: f64| 1.0 - 2.0 * m)), beam(height, side)]
    }

    /// Level surface and zenith by the tracer, in independent parts on all threads.
    fn by_reference(
        &self,
        model: &SkyModel,
        place: &SunPlace,
        parts: &Parts,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Result<(Vec<Relative>, Vec<Relative>)> {
        let altitude_m = model.altitude_m();
        let sources = self.beams(model, place);
        let count = parts.count as usize;
        let work = |index: usize| {
            let stream = (index % count) as u64;
            let found = if index < count {
                self.tracer.irradiance(&sources, altitude_m, Side::Above, &parts.effort, stream)
            } else {
                self.tracer.radiance(&sources, altitude_m, DVec3::Z, &parts.effort, ZENITH_STREAM + stream)
            };
            found.map(|estimate| estimate.value)
        };
        let (mut done, mut failure) = (0, None);
        let mut values = vec![[0.0; WAVELENGTHS]; 2 * count];
        let all = for_each_parallel(2 * count, work, |index, value| {
            match value {
                Ok(value) => values[index] = value,
                Err(error) => failure = Some(error),
            }
            done += 1;
            failure.is_none() && progress(done as f64 / (2 * count) as f64)
        });
        if let Some(error) = failure {
            return Err(error.into());
        }
        if !all {
            return Err(GpuError::Cancelled.into());
        }
        let zenith = values.split_off(count);
        Ok((values, zenith))
    }
}

/// Light scattered once, as the renderer has it.
fn first(model: &SkyModel, place: &SunPlace, star_at_1_au: f64) -> Result<MeasuredLight> {
    let (air, light, altitude_m) = (model.atmosphere(), model.light()?, model.altitude_m());
    let mu_s = place.airless_altitude_deg.to_radians().sin();
    let up = Ray { altitude_m, mu: 1.0, mu_s, nu: mu_s };
    let zenith = air.march(&up, STEPS).radiance_per_sr;
    let sky = match altitude_m < air.medium().top_altitude_m {
        true => air.sky_irradiance(altitude_m, mu_s),
        false => [0.0; 4],
    };
    let star = model.beam()?;
    let spectrum = model.preset().light_at_1_au_w_m2_nm().sample(&air.wavelengths_nm());
    let scale = |relative: [f64; 4]| -> Vec<f64> {
        relative.iter().zip(spectrum).map(|(value, light)| value * light * star_at_1_au).collect()
    };
    let exact = |value: f64| Measured { value: value.max(0.0), standard_error: None };
    let height = light.sun.direction_enu.z.max(0.0);
    Ok(MeasuredLight {
        sun: *place,
        sun_normal_lx: light.sun.illuminance_lx,
        sun_horizontal_lx: light.sun.illuminance_lx * height,
        sky_lx: exact(air.xyz(sky).y * star_at_1_au),
        zenith_cd_m2: exact(air.xyz(zenith).y * star_at_1_au),
        spectrum: LightSpectrum {
            wavelengths_nm: air.wavelengths_nm().to_vec(),
            sun_normal: scale(star),
            sun_horizontal: scale(star.map(|value| value * height)),
            sky_horizontal: scale(sky),
            sky_standard_error: Vec::new(),
            zenith: scale(zenith),
        },
    })
}

/// Limb darkening at each wavelength, or an even disc.
fn limb(model: &SkyModel) -> [[f64; 6]; WAVELENGTHS] {
    match model.scene().sun.limb_darkening {
        true => wavelengths_nm().map(limb_darkening),
        false => [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]; WAVELENGTHS],
    }
}

/// Mean and its standard error; a single part has none.
fn mean_and_error(parts: Vec<f64>) -> Measured {
    let count = parts.len().max(1) as f64;
    let mean = parts.iter().sum::<f64>() / count;
    let standard_error = (parts.len() > 1).then(|| {
        let variance = parts.iter().map(|part| (part - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (variance / count).sqrt()
    });
    Measured { value: mean, standard_error }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    fn model(settings: &[(&str, &str)]) -> SkyModel {
        let mut scene = Scene::default();
        for (key, value) in settings {
            scene.set(key, value).unwrap();
        }
        SkyModel::new(&scene).unwrap()
    }

    fn measure(model: &SkyModel, solver: LightSolver) -> MeasuredLight {
        LightMeter::new(model, solver).unwrap().measure(model, &mut |_| true).unwrap()
    }

    const FEW: LightSolver = LightSolver::Reference { samples: 4096, seed: 1 };

    /// Without air the Sun gives what its spectrum sums to, all of it from the disc; the sky gives nothing.
    #[test]
    fn without_air_the_sun_keeps_its_illuminance() {
        let model = model(&[("air.enabled", "off"), ("light.sun.altitude_deg", "30"), ("light.sun.distance_au", "1")]);
        let light = measure(&model, FEW);
        let full = himmel_core::colour::Observer::cie1931().xyz_of(|nm| himmel_air::sun::irradiance_w_m2_nm().at(nm)).y;
        assert!((light.sun_normal_lx / full - 1.0).abs() < 1e-3, "{} {full}", light.sun_normal_lx);
        assert!((light.sun_horizontal_lx / light.sun_normal_lx - 0.5).abs() < 1e-4);
        assert_eq!((light.sky_lx.value, light.zenith_cd_m2.value), (0.0, 0.0));
    }

    /// Half of the disc above the horizon gives half of the light; none below.
    #[test]
    fn a_setting_sun_fades() {
        let at = |altitude: &str| {
            let settings = [("air.enabled", "off"), ("light.sun.altitude_deg", altitude), ("observer.altitude_m", "0")];
            measure(&model(&settings), FEW).sun_normal_lx
        };
        assert!((at("0") / at("1") - 0.5).abs() < 2e-3, "{} {}", at("0"), at("1"));
        assert_eq!(at("-0.3"), 0.0);
    }

    /// Direct light agrees with the renderer's four wavelengths; all orders are more than one, and the two solvers for
    /// them agree.
    #[test]
    fn solvers_agree_where_they_should() {
        let model = model(&[("light.sun.altitude_deg", "30"), ("observer.altitude_m", "100")]);
        let (once, all, table) =
            (measure(&model, LightSolver::First), measure(&model, FEW), measure(&model, LightSolver::Moments));
        assert!((once.sun_normal_lx / all.sun_normal_lx - 1.0).abs() < 0.01);
        assert_eq!(table.sun_normal_lx, all.sun_normal_lx);
        assert!(all.sky_lx.value > 1.15 * once.sky_lx.value);
        for (a, b) in [(all.sky_lx, table.sky_lx), (all.zenith_cd_m2, table.zenith_cd_m2)] {
            let error = a.standard_error.unwrap() / a.value;
            assert!((b.value / a.value - 1.0).abs() < 0.03 + 4.0 * error, "{a:?} {b:?}");
        }
        assert_eq!(measure(&model, FEW), all);
    }

    /// The light of the scene (four wavelengths, a coarse table, harmonics) against the meter with the whole table at
    /// sixteen: 2 %, which is mostly what four wavelengths cost.
    #[test]
    fn the_lights_of_a_scene_are_what_the_meter_measures() {
        let at = |altitude: &str| model(&[("light.sun.altitude_deg", altitude), ("observer.altitude_m", "10")]);
        let meter = LightMeter::new(&at("30"), LightSolver::Moments).unwrap();
        for altitude in ["60", "30", "10", "0", "-4"] {
            let model = at(altitude);
            let (light, measured) = (model.light().unwrap(), meter.measure(&model, &mut |_| true).unwrap());
            let level = light.horizontal_illuminance_lx() / measured.horizontal_lx().value - 1.0;
            let sky = light.sky_illuminance_lx / measured.sky_lx.value - 1.0;
            let zenith = light.zenith_luminance_cd_m2 / measured.zenith_cd_m2.value - 1.0;
            println!("{altitude}°: level {level:+.4}, sky {sky:+.4}, zenith {zenith:+.4}");
            assert!(level.abs() < 0.02 && sky.abs() < 0.03 && zenith.abs() < 0.06, "{altitude}");
        }
    }

    #[test]
    fn too_few_paths_and_cancelling_are_errors() {
        let model = model(&[]);
        let few = LightMeter::new(&model, LightSolver::Reference { samples: 1023, seed: 1 });
        assert!(few.err().unwrap().to_string().contains("1024"));
        let meter = LightMeter::new(&model, FEW).unwrap();
        assert!(meter.measure(&model, &mut |_| false).is_err());
    }
}
