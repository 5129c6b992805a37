//! `himmel light`: illuminances, luminance of the zenith, spectrum.

use std::path::{Path, PathBuf};

use himmel::{LightMeter, LightSolver, MeasuredLight, SkyModel, parse_time};
use jiff::{Span, Timestamp};

use super::scene::SceneArgs;
use crate::progress::Progress;
use crate::{Failure, out, print_bytes};

/// Arguments of `himmel light`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel light --place Potsdam --time 2012-09-06T18:00
  himmel light --set light.sun.altitude_deg=-4 --samples 200000 --json
  himmel light --place Potsdam --from 2012-09-06T19:00 --to 2012-09-06T21:00 --step 10m --solver moments -o dusk.csv

first:      light scattered once; too dark, most so in twilight.
moments:    all orders by the table of moments; half a minute for the table, then any number of times; no noise.
reference:  all orders by the Monte Carlo tracer at sixteen wavelengths, with standard errors.

Sun means the preset's first star. Its own light comes from its refracted disc, or what of it is above the horizon; the air is
lit from its airless place. A level surface looks up. The zenith is without the disc. --json adds
spectra in W m-2 nm-1 and the scene's light as a host gets it: nine harmonics of ambient radiance, what an eclipse leaves of the Sun.")]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// What measures: first, moments, or reference.
    #[arg(long, value_name = "NAME", default_value = "reference", value_parser = ["first", "moments", "reference"])]
    solver: String,
    /// Paths for the level surface, at least 1024 (below 8192 little time is saved); the zenith takes as many again. Reference only.
    #[arg(long, value_name = "N", default_value_t = 16_384)]
    samples: u64,
    /// Seed of the random numbers: the same one gives the same numbers. Reference only.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// A table over time: its first instant, written as --time.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    from: Option<String>,
    /// Its last instant.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    to: Option<String>,
    /// Time between its rows: 10m, 1h, 30s, 1h30m.
    #[arg(long, value_name = "SPAN", allow_hyphen_values = true)]
    step: Option<String>,
    /// Where the table or the JSON goes; - or none is the standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON: an object, or a list of them with --from.
    #[arg(long)]
    json: bool,
}

/// Rows of a table, at most.
const MOST_ROWS: usize = 100_000;

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let scene = args.scene.scene()?;
    let to_file = args.output.as_deref().filter(|path| *path != Path::new("-"));
    if let Some(path) = to_file {
        himmel::picture::check_writable(path)?;
    }
    let mut model = SkyModel::new(&scene)?;
    let times = args.times(&model)?;
    if times.is_none() && to_file.is_some() && !args.json {
        return Err(Failure::usage("--output goes with --json or with --from, --to and --step"));
    }
    let solver = match args.solver.as_str() {
        "first" => LightSolver::First,
        "moments" => LightSolver::Moments,
        _ => LightSolver::Reference { samples: args.samples, seed: args.seed },
    };
    let meter = LightMeter::new(&model, solver).map_err(|error| match error {
        himmel::Error::Air(himmel_air::AirError::Optics { .. }) => Failure::usage(error.to_string()),
        other => other.into(),
    })?;
    let progress = Progress::new("measuring", quiet);
    let Some(times) = times else {
        let light = meter.measure(&model, &mut |share| progress.update(share))?;
        drop(progress);
        if args.json {
            return write(&pretty(&object(args, &model, &light)?)?, to_file);
        }
        return print(args, &model, &light);
    };
    let (mut rows, count) = (Vec::new(), times.len());
    let mut table = csv::Writer::from_writer(Vec::new());
    let fail = |e: csv::Error| Failure::failed(e.to_string());
    table.write_record(COLUMNS).map_err(fail)?;
    let mut done = 0u32;
    for time in times {
        model.clock_mut().set(time);
        let share = |part: f64| (f64::from(done) + part) / count as f64;

        let light = match meter.measure(&model, &mut |part| progress.update(share(part))) {
            Ok(light) => light,
            Err(himmel::Error::Gpu(himmel::GpuError::Cancelled)) => break,
            Err(error) => return Err(error.into()),
        };
        if args.json {
            rows.push(object(args, &model, &light)?);
        } else {
            table.write_record(fields(&model, &light)).map_err(fail)?;
        }
        done += 1;
        if !progress.update(f64::from(done) / count as f64) {
            break;
        }
    }
    drop(progress);
    if done == 0 {
        return Err(Failure::failed("stopped before a row was finished; nothing is written"));
    }
    let bytes = if args.json {
        pretty(&rows.into())?
    } else {
        table.into_inner().map_err(|e| Failure::failed(e.to_string()))?
    };
    write(&bytes, to_file)?;
    if (done as usize) < count {
        return Err(Failure::failed(format!("stopped: {done} of {count} rows are measured and written")));
    }
    Ok(())
}

impl Args {
    /// The instants of a table; `None` for one measurement.
    fn times(&self, model: &SkyModel) -> Result<Option<Vec<Timestamp>>, Failure> {
        let (from, to, step) = match (&self.from, &self.to, &self.step) {
            (None, None, None) => return Ok(None),
            (Some(from), Some(to), Some(step)) => (from, to, step),
            _ => return Err(Failure::usage("a table over time takes --from, --to and --step together")),
        };
        let zone = &model.observer().time_zone;
        let (from, to) = (parse_time(from, zone)?, parse_time(to, zone)?);
        if to < from {
            return Err(Failure::usage(format!("--to ({to}) lies before --from ({from})")));
        }
        let unclear = || {
            let step = himmel::params::shorten(step);
            Failure::usage(format!("--step takes a span such as 10m, 1h or 1h30m, got \"{step}\""))
        };
        let step: Span = step.trim().parse().map_err(|_| unclear())?;
        // Days are 24 hours here; months have no length.
        let step = step.to_duration(jiff::SpanRelativeTo::days_are_24_hours()).map_err(|_| unclear())?;
        if !step.is_positive() {
            return Err(unclear());
        }
        let (mut times, mut time) = (vec![from], from);
        while let Some(next) = time.checked_add(step).ok().filter(|next| *next <= to) {
            if times.len() == MOST_ROWS {
                return Err(Failure::usage(format!("at most {MOST_ROWS} rows at once; take a longer --step")));
            }
            times.push(next);
            time = next;
        }
        Ok(Some(times))
    }
}

fn write(bytes: &[u8], to_file: Option<&Path>) -> Result<(), Failure> {
    match to_file {
        Some(path) => himmel::picture::save_bytes(bytes, path)?,
        None => print_bytes(bytes),
    }
    Ok(())
}

fn pretty(value: &serde_json::Value) -> Result<Vec<u8>, Failure> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(|e| Failure::failed(e.to_string()))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Names of what is measured; standard errors are empty (CSV) or null (JSON) where nothing is left to chance.
const COLUMNS: [&str; 12] = [
    "time_utc",
    "sun_azimuth_deg",
    "sun_altitude_deg",
    "sun_airless_altitude_deg",
    "horizontal_illuminance_lx",
    "horizontal_illuminance_standard_error_lx",
    "sun_horizontal_illuminance_lx",
    "sun_normal_illuminance_lx",
    "sky_illuminance_lx",
    "sky_illuminance_standard_error_lx",
    "zenith_luminance_cd_m2",
    "zenith_luminance_standard_error_cd_m2",
];

/// The numbers of [`COLUMNS`] after the time.
fn numbers(light: &MeasuredLight) -> [Option<f64>; 11] {
    let (sun, all, sky, zenith) = (&light.sun, light.horizontal_lx(), light.sky_lx, light.zenith_cd_m2);
    [
        Some(sun.azimuth_deg),
        Some(sun.altitude_deg),
        Some(sun.airless_altitude_deg),
        Some(all.value),
        all.standard_error,
        Some(light.sun_horizontal_lx),
        Some(light.sun_normal_lx),
        Some(sky.value),
        sky.standard_error,
        Some(zenith.value),
        zenith.standard_error,
    ]
}

fn fields(model: &SkyModel, light: &MeasuredLight) -> Vec<String> {
    let number = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
    [model.utc().to_string()].into_iter().chain(numbers(light).map(number)).collect()
}

fn object(args: &Args, model: &SkyModel, light: &MeasuredLight) -> Result<serde_json::Value, Failure> {
    let mut object = serde_json::Map::new();
    let (observer, spectrum) = (model.observer(), &light.spectrum);
    object.insert(COLUMNS[0].into(), model.utc().to_string().into());
    for (name, number) in COLUMNS[1..].iter().zip(numbers(light)) {
        object.insert((*name).into(), number.into());
    }
    for (name, value) in [
        ("place", observer.name.clone().into()),
        ("latitude_deg", observer.latitude_deg.into()),
        ("longitude_deg", observer.longitude_deg.into()),
        ("altitude_m", model.altitude_m().into()),
        ("preset", model.scene().preset.clone().into()),
        ("solver", args.solver.clone().into()),
    ] {
        object.insert(name.into(), value);
    }
    if args.solver == "reference" {
        object.insert("samples".into(), args.samples.into());
        object.insert("seed".into(), args.seed.into());
    }
    let spectrum = serde_json::json!({
        "wavelength_nm": spectrum.wavelengths_nm,
        "sun_normal_w_m2_nm": spectrum.sun_normal,
        "sun_horizontal_w_m2_nm": spectrum.sun_horizontal,
        "sky_horizontal_w_m2_nm": spectrum.sky_horizontal,
        "sky_standard_error_w_m2_nm": if spectrum.sky_standard_error.is_empty() { None } else { Some(&spectrum.sky_standard_error) },
        "zenith_w_m2_sr_nm": spectrum.zenith,
    });
    object.insert("spectrum".into(), spectrum);
    let scene = model.light()?;
    let ambient = serde_json::json!({
        "basis": "real harmonics l <= 2 of (east, north, up): 1, y, z, x, xy, yz, 3zz-1, xz, xx-yy, orthonormal; linear Rec. 709",
        "harmonics_cd_m2": scene.ambient.harmonics_cd_m2,
    });
    object.insert("ambient".into(), ambient);
    object.insert("ground_illuminance_lx".into(), scene.ground_illuminance_lx.into());
    object.insert("eclipse_fraction".into(), scene.eclipse_fraction.into());
    if let Some(moon) = model.moon()? {
        let direct = scene.moon().map_or(0.0, |moon| moon.illuminance_lx);
        let moon = serde_json::json!({
            "azimuth_deg": moon.azimuth_deg,
            "altitude_deg": moon.altitude_deg,
            "airless_altitude_deg": moon.airless_altitude_deg,
            "phase_angle_deg": moon.phase_angle_deg,
            "illuminated_fraction": moon.illuminated_fraction,
            "illuminance_above_air_lx": moon.illuminance_lx,
            "normal_illuminance_lx": direct,
            "eclipse_fraction": moon.eclipse_fraction,
        });
        object.insert("moon".into(), moon);
    }
    let night = scene.night.map(|night| {
        serde_json::json!({
            "zenith_cd_m2": night.sum_cd_m2(),
            "zenith_mag_arcsec2": night.mag_arcsec2(),
            "airglow_cd_m2": night.airglow_cd_m2,
            "zodiacal_light_cd_m2": night.zodiacal_cd_m2,
            "starlight_cd_m2": night.starlight_cd_m2,
            "scattered_cd_m2": night.scattered_cd_m2,
            "light_pollution_cd_m2": night.pollution_cd_m2,
            "twilight_cd_m2": night.twilight_cd_m2,
            "drawn_stars_mean_cd_m2": night.drawn_stars_cd_m2,
        })
    });
    object.insert("night".into(), night.into());
    object.insert("limiting_magnitude".into(), scene.limiting_magnitude().into());
    Ok(object.into())
}

/// For people.
fn print(args: &Args, model: &SkyModel, light: &MeasuredLight) -> Result<(), Failure> {
    let (sun, observer, spectrum) = (&light.sun, model.observer(), &light.spectrum);
    let error = |measured: himmel::Measured| {
        measured
            .standard_error
            .filter(|_| measured.value > 0.0)
            .map_or_else(String::new, |error| format!(" ± {:.2} %", 100.0 * error / measured.value))
    };
    out!(
        "place        {} ({:.4}°, {:.4}°), {:.0} m",
        observer.name,
        observer.latitude_deg,
        observer.longitude_deg,
        model.altitude_m()
    );
    out!("time         {} · {}", model.local_time(), model.utc());
    out!(
        "sun          azimuth {:.2}°, altitude {:.2}° ({:.2}° without air)",
        sun.azimuth_deg,
        sun.altitude_deg,
        sun.airless_altitude_deg
    );
    let total = light.horizontal_lx();
    out!("on a level surface");
    out!(
        "  sun        {} lx ({} lx on a surface that faces it)",
        digits(light.sun_horizontal_lx),
        digits(light.sun_normal_lx)
    );
    out!("  sky        {} lx{}", digits(light.sky_lx.value), error(light.sky_lx));
    out!("  together   {} lx{}", digits(total.value), error(total));
    out!("zenith       {} cd/m²{}", digits(light.zenith_cd_m2.value), error(light.zenith_cd_m2));
    let scene = model.light()?;
    if let Some(moon) = model.moon()? {
        let direct = scene.moon().map_or(0.0, |moon| moon.illuminance_lx);
        out!(
            "moon         azimuth {:.2}°, altitude {:.2}°, {:.1} % lit (phase angle {:.1}°)",
            moon.azimuth_deg,
            moon.altitude_deg,
            100.0 * moon.illuminated_fraction,
            moon.phase_angle_deg
        );
        let level = direct * moon.altitude_deg.to_radians().sin().max(0.0);
        out!("  direct     {} lx on a level surface ({} lx on one that faces it)", digits(level), digits(direct));
        out!("  above air  {} lx", digits(moon.illuminance_lx));
        if moon.eclipse_fraction < 1.0 {
            out!("  eclipse    {:.3e} of its light is left", moon.eclipse_fraction);
        }
        out!("all lights   {} lx on a level surface", digits(scene.horizontal_illuminance_lx()));
    }
    if let Some(night) = &scene.night {
        print_night(night);
    }
    out!("stars        to magnitude {:.1} there", scene.limiting_magnitude());
    if scene.eclipse_fraction < 1.0 {
        // The solvers' skies are lit by a whole Sun: the scene's light is the one that knows.
        out!("eclipse      {:.2} % of the Sun's light is left; in it", 100.0 * scene.eclipse_fraction);
        out!("  sun        {} lx on a surface that faces it", digits(scene.sun.illuminance_lx));
        out!(
            "  sky        {} lx (the sky above, and the spectrum, are those of a whole Sun)",
            digits(scene.sky_illuminance_lx)
        );
    }
    out!("spectrum, W m⁻² nm⁻¹ on a level surface");
    out!("  {:>8}  {:>10}  {:>10}", "nm", "sun", "sky");
    for ((nm, sun), sky) in spectrum.wavelengths_nm.iter().zip(&spectrum.sun_horizontal).zip(&spectrum.sky_horizontal) {
        out!("  {nm:>8.1}  {sun:>10.3e}  {sky:>10.3e}");
    }
    out!("atmosphere   {} — {}", model.scene().preset, model.preset().title);
    match args.solver.as_str() {
        "first" => out!("solver       first: light scattered once"),
        "moments" => out!("solver       moments"),
        _ => out!("solver       reference, {} paths, seed {}", args.samples, args.seed),
    }
    Ok(())
}

/// The zenith of a night, part by part.
fn print_night(night: &himmel::NightZenith) {
    out!("night        zenith {} cd/m², {:.2} mag/arcsec²", digits(night.sum_cd_m2()), night.mag_arcsec2());
    for (name, cd_m2) in NIGHT_PARTS.iter().zip(night_parts(night)) {
        let s10 = cd_m2 / himmel::parts::gpu::phenomena::night_glow::S10_CD_M2;
        out!("  {name:<15} {:>9} cd/m², {s10:>7.1} S10", digits(cd_m2));
    }
    let share = digits(night.drawn_stars_cd_m2);
    out!("  (stars that are drawn one by one: {share} cd/m² on the mean over the sky, not in the sum)");
}

/// Names of [`night_parts`].
const NIGHT_PARTS: [&str; 6] =
    ["airglow", "zodiacal light", "starlight", "their scattering", "cities", "twilight, Moon"];

fn night_parts(night: &himmel::NightZenith) -> [f64; 6] {
    [
        night.airglow_cd_m2,
        night.zodiacal_cd_m2,
        night.starlight_cd_m2,
        night.scattered_cd_m2,
        night.pollution_cd_m2,
        night.twilight_cd_m2,
    ]
}

/// Four digits, for people.
fn digits(value: f64) -> String {
    match value {
        v if v >= 1000.0 => format!("{v:.0}"),
        v if v >= 0.01 || v == 0.0 => format!("{v:.3}"),
        v => format!("{v:.3e}"),
    }
}
