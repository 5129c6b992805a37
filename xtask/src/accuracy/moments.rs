//! The moment solver (in f64, or the renderer's on the GPU) and the usual approximation against the tracer.

use std::fmt::Write as _;

use himmel::{Gpu, RayMeter};
use himmel_air::hillaire::{Hillaire, Settings};
use himmel_air::medium::Sampled;
use himmel_air::moments::{Moments, Quality, radiance};
use himmel_air::reference::{Effort, Source, Tracer, for_each_parallel};
use himmel_air::single::Ray;
use himmel_air::{AirParams, Atmosphere, Columns, GroundParams, Preset};

use super::{Random, Work, quantile, view};

const WAVELENGTHS_NM: [f64; 3] = [680.0, 550.0, 440.0];

/// Questions of one kind.
struct Class {
    name: &'static str,
    preset: &'static str,
    /// Ranges of the Sun's zenith angle, the view's zenith angle (degrees) and the altitude (m).
    sun_deg: (f64, f64),
    view_deg: (f64, f64),
    altitude_m: (f64, f64),
    /// Standard error of the tracer that is asked for, %.
    error: f64,
}

const CLASSES: [Class; 10] = {
    const fn class(
        name: &'static str,
        preset: &'static str,
        sun_deg: (f64, f64),
        view_deg: (f64, f64),
        altitude_m: (f64, f64),
        error: f64,
    ) -> Class {
        Class { name, preset, sun_deg, view_deg, altitude_m, error }
    }
    let (up, low) = ((0.0, 89.5), (0.0, 10e3));
    [
        class("day: Sun zenith ≤ 85°, ≤ 10 km", "bruneton2017", (0.0, 85.0), up, low, 0.1),
        class("horizon: 85–92°", "bruneton2017", (85.0, 92.0), up, low, 0.1),
        class("−4°: 94°", "bruneton2017", (93.5, 94.5), up, low, 0.25),
        class("−6°: 96°", "bruneton2017", (95.5, 96.5), up, low, 0.35),
        class("from 30 km", "bruneton2017", (0.0, 90.0), (0.0, 180.0), (30e3, 30e3), 0.1),
        // From 400 km the Earth and its air begin at a zenith angle of 108°.
        class("from space, 400 km", "bruneton2017", (0.0, 90.0), (108.5, 180.0), (400e3, 400e3), 0.1),
        class("`earth-haze`, ≤ 85°", "earth-haze", (0.0, 85.0), up, (0.0, 5e3), 0.25),
        class("`mars-reference`, ≤ 92°", "mars-reference", (0.0, 92.0), up, low, 0.3),
        class("`titan-reference`, ≤ 90°", "titan-reference", (0.0, 90.0), up, (0.0, 100e3), 0.3),
        class("`earth`, ≤ 92°", "earth", (0.0, 92.0), up, low, 0.15),
    ]
};

/// A question at three wavelengths and its answers.
struct Point {
    ray: Ray,
    reference: [f64; 3],
    relative_error: f64,
    ours: [f64; 3],
    usual: [f64; 3],
    usual_converged: [f64; 3],
}

/// `gpu`: the renderer's own tables and shaders instead of the f64 twin.
pub fn table(work: Work, gpu: Option<&Gpu>) -> Result<String, String> {
    let ours = if gpu.is_some() { "ours on the GPU" } else { "this solver, 32 cells" };
    let mut text = format!(
        "| class | points × λ | reference ± | {ours} | without multiple scattering | Hillaire 2020, converged | Hillaire 2020, usual sizes |\n|---|---|---|---|---|---|---|\n",
    );
    let mut notes = String::new();
    let mut worst_text = String::new();
    let mut last: Option<(&str, Solvers)> = None;
    for (index, class) in CLASSES.iter().enumerate() {
        let preset = Preset::named(class.preset).map_err(|error| error.to_string())?;
        let air = preset.medium.sampled(&WAVELENGTHS_NM);
        let tracer = Tracer::new(&air).map_err(|error| error.to_string())?;
        let mut solvers = match last.take() {
            Some((name, solvers)) if name == class.preset => solvers,
            _ => {
                let columns = Columns::new(&preset.medium);
                let ours = Ours::build(&preset, &air, &columns, gpu, class.preset, &mut notes)?;
                let usual = Hillaire::build(&air, &columns, &Settings::USUAL);
                let usual_converged = Hillaire::build(&air, &columns, &Settings::CONVERGED);
                Solvers { columns, ours, usual, usual_converged }
            }
        };
        let mut random = Random::new(1000 + index as u64);
        let questions: Vec<(Ray, glam::DVec3, f64)> = (0..work.count(60))
            .map(|_| {
                let sun_deg = random.within(class.sun_deg.0, class.sun_deg.1);
                let direction = view(random.within(class.view_deg.0, class.view_deg.1), random.within(0.0, 180.0));
                let altitude_m = random.within(class.altitude_m.0, class.altitude_m.1);
                let sun = view(sun_deg, 0.0);
                let ray = Ray { altitude_m, mu: direction.z, mu_s: sun.z, nu: direction.dot(sun) };
                (ray, direction, sun_deg)
            })
            .collect();
        let effort = Effort {
            samples: 4096,
            target_relative_error: Some(class.error / 100.0),
            most_samples: work.count(1 << 20),
            seed: 77,
        };
        let rays: Vec<Ray> = questions.iter().map(|(ray, ..)| *ray).collect();
        let ours = solvers.ours.answer(&air, &solvers.columns, &rays)?;
        let solvers_now = &solvers;
        let mut points = Vec::new();
        for_each_parallel(
            questions.len(),
            |i| {
                let (ray, direction, sun_deg) = questions[i];
                let sources = [Source::at_zenith_angle(sun_deg.to_radians())];
                tracer.radiance(&sources, ray.altitude_m, direction, &effort, i as u64).map(|answer| Point {
                    ray,
                    reference: answer.value,
                    relative_error: answer.relative_error(),
                    ours: ours[i],
                    usual: solvers_now.usual.radiance(&air, &solvers_now.columns, &ray),
                    usual_converged: solvers_now.usual_converged.radiance(&air, &solvers_now.columns, &ray),
                })
            },
            |_, point| {
                if let Ok(point) = point {
                    // Where the reference shows nothing (space beside the air) there is no relative error.
                    if point.reference.iter().all(|value| *value > 0.0) {
                        points.push(point);
                    }
                }
                true
            },
        );
        let mut noise: Vec<f64> = points.iter().map(|point| point.relative_error).collect();
        let column = |of: &dyn Fn(&Point) -> [f64; 3]| {
            let mut errors: Vec<f64> = points
                .iter()
                .flat_map(|point| {
                    let value = of(point);
                    (0..3).map(move |k| (value[k] / point.reference[k] - 1.0).abs()).collect::<Vec<_>>()
                })
                .collect();
            format!("{} / {}", percent(quantile(&mut errors, 0.5)), percent(quantile(&mut errors, 0.95)))
        };
        let single = |point: &Point| himmel_air::single::march(&air, &solvers.columns, &point.ray, 64).radiance_per_sr;
        let _ = writeln!(
            text,
            "| {} | {} × 3 | {} | {} | {} | {} | {} |",
            class.name,
            points.len(),
            percent(quantile(&mut noise, 0.5)),
            column(&|point| point.ours),
            column(&single),
            column(&|point| point.usual_converged),
            column(&|point| point.usual),
        );
        eprintln!("{}", text.lines().last().unwrap_or_default());
        let mut worst: Vec<(f64, String)> = points
            .iter()
            .flat_map(|point| {
                (0..3).map(move |k| {
                    let error = point.ours[k] / point.reference[k] - 1.0;
                    let deg = |cosine: f64| cosine.acos().to_degrees();
                    let line = format!(
                        "{:+.1} % at {} nm: Sun {:.1}°, view {:.1}°, {:.1}° apart, {:.1} km",
                        100.0 * error,
                        WAVELENGTHS_NM[k],
                        deg(point.ray.mu_s),
                        deg(point.ray.mu),
                        deg(point.ray.nu),
                        point.ray.altitude_m / 1e3
                    );
                    (error.abs(), line)
                })
            })
            .collect();
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mean: f64 =
            points.iter().flat_map(|point| (0..3).map(move |k| point.ours[k] / point.reference[k] - 1.0)).sum::<f64>()
                / (3.0 * points.len() as f64).max(1.0);
        let _ = writeln!(
            worst_text,
            "- {}: mean {:+.2} %; worst {}",
            class.name,
            100.0 * mean,
            worst.first().map_or("", |(_, line)| line)
        );
        last = Some((class.preset, solvers));
    }
    let _ = write!(
        text,
        "\nMedian / 95th percentile of the relative error in %, at 680, 550, 440 nm; fresh random points, parallel Sun, all views \
         upwards except from 30 km and space. \"Reference ±\": median standard error of the tracer.\n\n{worst_text}\n{notes}"
    );
    Ok(text)
}

struct Solvers {
    columns: Columns,
    ours: Ours,
    usual: Hillaire<3>,
    usual_converged: Hillaire<3>,
}

/// What is compared.
enum Ours {
    Moments(Box<Moments<3>>),
    Gpu(Box<RayMeter>),
}

impl Ours {
    fn build(
        preset: &Preset,
        air: &Sampled<'_, 3>,
        columns: &Columns,
        gpu: Option<&Gpu>,
        name: &str,
        notes: &mut String,
    ) -> Result<Self, String> {
        let started = std::time::Instant::now();
        let Some(gpu) = gpu else {
            let moments = Moments::build(air, columns, &Quality::default());
            let build_s = started.elapsed().as_secs_f64();
            let _ = writeln!(
                notes,
                "- `{name}`: {} orders, last change {:.1e}, built in {build_s:.1} s at three wavelengths",
                moments.orders(),
                moments.last_change()
            );
            return Ok(Self::Moments(Box::new(moments)));
        };
        let [first, second, third] = WAVELENGTHS_NM;
        let params = AirParams {
            wavelength_1_nm: first,
            wavelength_2_nm: second,
            wavelength_3_nm: third,
            wavelength_4_nm: third,
            ..AirParams::default()
        };
        let atmosphere = Atmosphere::new(preset, &params, &GroundParams::default());
        let meter = RayMeter::new(gpu, &atmosphere, &mut |_| true).map_err(|error| error.to_string())?;
        let _ = writeln!(
            notes,
            "- `{name}`: {:.2} MiB of tables, filled in {:.1} s",
            meter.table_bytes() as f64 / 1048576.0,
            started.elapsed().as_secs_f64()
        );
        Ok(Self::Gpu(Box::new(meter)))
    }

    fn answer(&mut self, air: &Sampled<'_, 3>, columns: &Columns, rays: &[Ray]) -> Result<Vec<[f64; 3]>, String> {
        match self {
            Self::Moments(moments) => Ok(rays.iter().map(|ray| radiance(air, columns, moments, ray, 32)).collect()),
            Self::Gpu(meter) => {
                let answers = meter.answer(rays).map_err(|error| error.to_string())?;
                let three = |four: [f32; 4]| [0, 1, 2].map(|k| f64::from(four[k]));
                Ok(answers.iter().map(|answer| three(answer.radiance_per_sr)).collect())
            }
        }
    }
}

fn percent(value: f64) -> String {
    match 100.0 * value {
        v if v < 1.0 => format!("{v:.2}"),
        v if v < 10.0 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}
