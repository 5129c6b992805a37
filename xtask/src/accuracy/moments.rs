//! The moment solver (in f64, or the renderer's on the GPU) and the usual approximation against the tracer.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use himmel::{Gpu, RayMeter};
use himmel_air::hillaire::{Hillaire, Settings};
use himmel_air::medium::Sampled;
use himmel_air::moments::{Moments, Quality, radiance};
use himmel_air::reference::for_each_parallel;
use himmel_air::single::{Ray, march};
use himmel_air::{AirParams, Atmosphere, Columns, GroundParams, Preset};

use super::class::{Class, Truth, WAVELENGTHS_NM};
use super::{Choice, quantile};

/// The classes of the table, in its order.
fn classes(choice: &Choice) -> Vec<Class> {
    let (up, low) = ((0.0, 89.5), (0.0, 10e3));
    let clear = "bruneton2017";
    [
        ("day", "day: Sun zenith ≤ 85°, ≤ 10 km", clear, (0.0, 85.0), up, low, 0.1),
        ("horizon", "horizon: 85–92°", clear, (85.0, 92.0), up, low, 0.1),
        ("94", "−4°: 94°", clear, (93.5, 94.5), up, low, 0.25),
        ("96", "−6°: 96°", clear, (95.5, 96.5), up, low, 0.35),
        ("30km", "from 30 km", clear, (0.0, 90.0), (0.0, 180.0), (30e3, 30e3), 0.1),
        // From 400 km the Earth and its air begin at a zenith angle of 108°.
        ("space", "from space, 400 km", clear, (0.0, 90.0), (108.5, 180.0), (400e3, 400e3), 0.1),
        ("haze", "`earth-haze`, ≤ 85°", "earth-haze", (0.0, 85.0), up, (0.0, 5e3), 0.25),
        ("mars", "`mars-reference`, ≤ 92°", "mars-reference", (0.0, 92.0), up, low, 0.3),
        ("titan", "`titan-reference`, ≤ 90°", "titan-reference", (0.0, 90.0), up, (0.0, 100e3), 0.3),
        ("earth", "`earth`, ≤ 92°", "earth", (0.0, 92.0), up, low, 0.15),
    ]
    .into_iter()
    .enumerate()
    .map(|(i, (key, name, preset, sun_deg, view_deg, altitude_m, error))| Class {
        key: key.into(),
        name: name.into(),
        preset,
        sun_deg,
        view_deg,
        altitude_m,
        error,
        most_samples: choice.work.count(1 << 20),
        seed: 1000 + i as u64,
    })
    .collect()
}

/// A question at three wavelengths and its answers.
pub struct Point {
    pub ray: Ray,
    pub truth: Truth,
    pub ours: [f64; 3],
    single: [f64; 3],
    pub usual: [f64; 3],
    pub usual_converged: [f64; 3],
}

impl Point {
    /// Relative errors of an answer.
    pub fn errors(&self, answer: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| answer[k] / self.truth.value[k] - 1.0)
    }
}

/// Median and 95th percentile of the size of relative errors.
pub fn spread(points: &[Point], of: impl Fn(&Point) -> [f64; 3]) -> (f64, f64) {
    let mut errors: Vec<f64> = points.iter().flat_map(|point| point.errors(&of(point)).map(f64::abs)).collect();
    (quantile(&mut errors, 0.5), quantile(&mut errors, 0.95))
}

/// Median and 95th percentile of the tracer's relative standard errors.
pub fn noise(points: &[Point]) -> (f64, f64) {
    let each =
        |point: &Point| -> [f64; 3] { std::array::from_fn(|k| point.truth.standard_error[k] / point.truth.value[k]) };
    let mut errors: Vec<f64> = points.iter().flat_map(each).collect();
    (quantile(&mut errors, 0.5), quantile(&mut errors, 0.95))
}

/// `gpu`: the renderer's own tables and shaders instead of the f64 twin. `partial` gets the table after each class.
pub fn table(
    choice: &Choice,
    gpu: Option<&Gpu>,
    partial: impl Fn(&str) -> Result<(), String>,
) -> Result<String, String> {
    let classes = classes(choice);
    // In the order that was asked for; the rows keep the table's.
    let mut order = Vec::new();
    for key in &choice.classes {
        let unknown = || {
            let keys: Vec<&str> = classes.iter().map(|class| class.key.as_str()).collect();
            format!("no class \"{key}\"; there are {}", keys.join(", "))
        };
        order.push(classes.iter().position(|class| class.key == *key).ok_or_else(unknown)?);
    }
    if order.is_empty() {
        order.extend(0..classes.len());
    }
    let mut rows: BTreeMap<usize, (String, String)> = BTreeMap::new();
    let mut solvers = Solvers::default();
    let mut text = String::new();
    for index in order {
        let class = &classes[index];
        let points = solvers.points(class, choice, gpu)?;
        rows.insert(index, (row(class, &points), worst(class, &points)));
        text = whole(gpu.is_some(), &rows, &solvers.notes);
        eprintln!("{}", rows[&index].0);
        partial(&text)?;
    }
    Ok(text)
}

fn whole(on_gpu: bool, rows: &BTreeMap<usize, (String, String)>, notes: &str) -> String {
    let ours = if on_gpu { "ours on the GPU" } else { "this solver, 32 cells" };
    let mut text = format!(
        "| class | points × λ | reference ± | {ours} | without multiple scattering | Hillaire 2020, converged | Hillaire 2020, usual sizes |\n|---|---|---|---|---|---|---|\n",
    );
    rows.values().for_each(|(row, _)| text.push_str(row));
    text.push_str(
        "\nMedian / 95th percentile of the relative error in %, at 680, 550, 440 nm; fresh random points, parallel Sun, all views \
         upwards except from 30 km and space. \"Reference ±\": the tracer's standard errors, likewise.\n\n",
    );
    rows.values().for_each(|(_, worst)| text.push_str(worst));
    let _ = write!(text, "\n{notes}");
    text
}

fn row(class: &Class, points: &[Point]) -> String {
    let both = |(median, most): (f64, f64)| format!("{} / {}", percent(median), percent(most));
    format!(
        "| {} | {} × 3 | {} | {} | {} | {} | {} |\n",
        class.name,
        points.len(),
        both(noise(points)),
        both(spread(points, |point| point.ours)),
        both(spread(points, |point| point.single)),
        both(spread(points, |point| point.usual_converged)),
        both(spread(points, |point| point.usual)),
    )
}

/// The mean error and the points of the largest ones.
fn worst(class: &Class, points: &[Point]) -> String {
    let mut errors: Vec<(f64, usize, &Point)> = points
        .iter()
        .flat_map(|point| point.errors(&point.ours).into_iter().enumerate().map(move |(k, error)| (error, k, point)))
        .collect();
    let mean = errors.iter().map(|(error, ..)| error).sum::<f64>() / (errors.len() as f64).max(1.0);
    errors.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let say = |(error, k, point): &(f64, usize, &Point)| {
        let deg = |cosine: f64| cosine.acos().to_degrees();
        format!(
            "{:+.1} % ± {:.1} at {} nm: Sun {:.1}°, view {:.1}°, {:.1}° apart, {:.1} km",
            100.0 * error,
            100.0 * point.truth.standard_error[*k] / point.truth.value[*k],
            WAVELENGTHS_NM[*k],
            deg(point.ray.mu_s),
            deg(point.ray.mu),
            deg(point.ray.nu),
            point.ray.altitude_m / 1e3
        )
    };
    let three: Vec<String> = errors.iter().take(3).map(say).collect();
    format!("- {}: mean {:+.2} %; worst {}\n", class.name, 100.0 * mean, three.join("; "))
}

/// Everything that is compared, made once for each preset.
#[derive(Default)]
pub struct Solvers {
    made: BTreeMap<&'static str, (Preset, Solver)>,
    /// What each cost.
    pub notes: String,
}

impl Solvers {
    /// All answers to the questions of a class.
    pub fn points(&mut self, class: &Class, choice: &Choice, gpu: Option<&Gpu>) -> Result<Vec<Point>, String> {
        if !self.made.contains_key(class.preset) {
            let preset = Preset::named(class.preset).map_err(|error| error.to_string())?;
            let columns = Columns::new(&preset.medium);
            let air = preset.medium.sampled(&WAVELENGTHS_NM);
            let ours = Ours::build(&preset, &air, &columns, gpu, class.preset, &mut self.notes)?;
            let usual = Hillaire::build(&air, &columns, &Settings::USUAL);
            let usual_converged = Hillaire::build(&air, &columns, &Settings::CONVERGED);
            drop(air);
            self.made.insert(class.preset, (preset, Solver { columns, ours, usual, usual_converged }));
        }
        let Some((preset, solver)) = self.made.get_mut(class.preset) else { return Ok(Vec::new()) };
        let truths = class.truths(preset, choice.points, &choice.kept)?;
        let rays: Vec<Ray> = class.questions(truths.len()).iter().map(|question| question.ray).collect();
        let air = preset.medium.sampled(&WAVELENGTHS_NM);
        let ours = solver.ours.answer(&air, &solver.columns, &rays)?;
        let solver = &*solver;
        let mut points: Vec<(usize, Point)> = Vec::new();
        for_each_parallel(
            rays.len(),
            |i| Point {
                ray: rays[i],
                truth: truths[i],
                ours: ours[i],
                single: march(&air, &solver.columns, &rays[i], 64).radiance_per_sr,
                usual: solver.usual.radiance(&air, &solver.columns, &rays[i]),
                usual_converged: solver.usual_converged.radiance(&air, &solver.columns, &rays[i]),
            },
            |i, point| {
                // Where the reference shows nothing (space beside the air) there is no relative error.
                if point.truth.value.iter().all(|value| *value > 0.0) {
                    points.push((i, point));
                }
                true
            },
        );
        points.sort_by_key(|(i, _)| *i);
        Ok(points.into_iter().map(|(_, point)| point).collect())
    }
}

struct Solver {
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

/// A share in %, in about two digits.
pub fn percent(value: f64) -> String {
    match 100.0 * value {
        v if v < 1.0 => format!("{v:.2}"),
        v if v < 10.0 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}
