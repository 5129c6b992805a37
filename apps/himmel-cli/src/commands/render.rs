//! `himmel render`

use std::path::{Path, PathBuf};
use std::time::Instant;

use himmel::picture::{FileFormat, check_writable, render_with, save};
use himmel::{Exposure, Gpu, Output, Picture, Scene, SkyModel, TablesCache};
use serde::Serialize;

use super::render_reference::{self, ReferenceArgs};
use super::scene::SceneArgs;
use crate::progress::Progress;
use crate::{Failure, out};

/// Arguments of `himmel render`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel render --place Potsdam --time 2012-09-06T20:00 -o sunset.png
  himmel render --place 52.39,13.06 --time 2012-09-06T16:00Z --look sun --fov 40 -o sun.exr
  himmel render --preset mars-reference --look sun --fov 30 -o mars.png
  himmel render --place Paranal --projection equirect --size 4096x2048 -o environment.hdr
  himmel render --altitude 400000 --look W,-20 --set light.sun.altitude_deg=5 --set light.sun.azimuth_deg=229 -o orbit.png
  himmel render --solver reference --set light.sun.altitude_deg=40 --size 320x180 -o noon.exr
  himmel render --solver reference --target-error 0.005 --resume --set light.sun.altitude_deg=40 -o noon.exr")]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// gpu: in a moment, by tables of all orders. reference: Monte Carlo without a GPU, all orders, 16 wavelengths.
    #[arg(long, value_enum, default_value = "gpu")]
    solver: Solver,
    #[command(flatten)]
    reference: ReferenceArgs,
    /// The picture: .png or .jpg (finished), .exr or .hdr (linear, cd/m² unless --exposure says otherwise).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write the scene as a file too, with the time that was shown, for --scene.
    #[arg(long, value_name = "FILE.toml")]
    save_scene: Option<PathBuf>,
    /// Where the air's finished tables are kept for the next time: a folder, or off. Unset: the platform's cache.
    #[arg(long, value_name = "DIR|off", env = "HIMMEL_CACHE")]
    cache: Option<PathBuf>,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
}

/// Who computes the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Solver {
    /// The renderer.
    Gpu,
    /// The Monte Carlo tracer.
    Reference,
}

/// What was shown.
#[derive(Serialize)]
struct Report {
    file: String,
    width_px: u32,
    height_px: u32,
    place: String,
    latitude_deg: f64,
    longitude_deg: f64,
    altitude_m: f64,
    local_time: String,
    utc: String,
    preset: String,
    look_azimuth_deg: f64,
    look_altitude_deg: f64,
    sun_azimuth_deg: f64,
    sun_altitude_deg: f64,
    sun_airless_altitude_deg: f64,
    horizontal_illuminance_lx: f64,
    sun_illuminance_lx: f64,
    sky_illuminance_lx: f64,
    exposure_ev100: Option<f64>,
    exposure_factor: f64,
    tonemap: Option<&'static str>,
    solver: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    adapter: Option<String>,
    #[serde(flatten)]
    reference: Option<render_reference::Report>,
    seconds: f64,
}

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let started = Instant::now();
    let scene = args.scene.scene()?;
    let format = FileFormat::of(&args.output)?;
    format.check_size(scene.output.width_px, scene.output.height_px)?;
    check_writable(&args.output)?;
    if let Some(path) = &args.save_scene {
        check_writable(path)?;
    }
    let model = SkyModel::new(&scene)?;
    model.view()?;
    let done = match args.solver {
        Solver::Gpu => {
            args.reference.refuse()?;
            let gpu = Gpu::open(args.scene.adapter.as_deref())?;
            let progress = Progress::new("rendering", quiet);
            let cache = cache(args.cache.as_deref());
            let picture =
                render_with(&gpu, &model, format.output(), cache.as_ref(), &mut |share| progress.update(share))?;
            if !progress.update(1.0) {
                return Err(himmel::GpuError::Cancelled.into());
            }
            drop(progress);
            save(&picture, &args.output)?;
            let light = model.light()?;
            let lux = [light.sun.illuminance_lx, light.sky_illuminance_lx, light.horizontal_illuminance_lx()];
            Done { picture, lux, adapter: Some(gpu.report().to_string()), reference: None, unfinished: None }
        }
        Solver::Reference => render_reference::run(&args.reference, &model, &args.output, format, quiet)?,
    };
    let picture = done.picture;
    if let Some(path) = &args.save_scene {
        himmel::picture::save_bytes(reproducible(&scene, &model).to_toml().as_bytes(), path)?;
    }
    let unfinished = done.unfinished.map_or(Ok(()), |message| Err(Failure::failed(message)));
    if quiet && !args.json {
        return unfinished;
    }
    let exposure = scene.output.exposure_for(format.output());
    let (sun, look) = (model.sun()?, model.look_deg()?);
    let [sun_lx, sky_lx, level_lx] = done.lux;
    let report = Report {
        file: args.output.display().to_string(),
        width_px: picture.width,
        height_px: picture.height,
        place: model.observer().name.clone(),
        latitude_deg: model.observer().latitude_deg,
        longitude_deg: model.observer().longitude_deg,
        altitude_m: model.altitude_m(),
        local_time: model.local_time(),
        utc: model.utc().to_string(),
        preset: scene.preset.clone(),
        look_azimuth_deg: look.0,
        look_altitude_deg: look.1,
        sun_azimuth_deg: sun.azimuth_deg,
        sun_altitude_deg: sun.altitude_deg,
        sun_airless_altitude_deg: sun.airless_altitude_deg,
        horizontal_illuminance_lx: level_lx,
        sun_illuminance_lx: sun_lx,
        sky_illuminance_lx: sky_lx,
        exposure_ev100: (exposure != Exposure::None).then_some(picture.ev100),
        exposure_factor: picture.exposure,
        tonemap: (format.output() == Output::Display).then(|| scene.output.tonemap.word()),
        solver: match &done.reference {
            None => "gpu, first-order scattering".into(),
            Some(_) => format!("reference, {} wavelengths, all orders", himmel::spectral::WAVELENGTHS),
        },
        adapter: done.adapter,
        reference: done.reference,
        seconds: started.elapsed().as_secs_f64(),
    };
    if args.json {
        out!("{}", serde_json::to_string_pretty(&report).map_err(|e| Failure::failed(e.to_string()))?);
        return unfinished;
    }
    out!(
        "place        {} ({:.4}°, {:.4}°), {:.0} m",
        report.place,
        report.latitude_deg,
        report.longitude_deg,
        report.altitude_m
    );
    out!("time         {} · {}", report.local_time, report.utc);
    out!(
        "sun          azimuth {:.2}°, altitude {:.2}° ({:.2}° without air)",
        sun.azimuth_deg,
        sun.altitude_deg,
        sun.airless_altitude_deg
    );
    out!(
        "illuminance  {} lx on level ground ({} from Sun and Moon, {} from the sky)",
        lux(report.horizontal_illuminance_lx),
        lux(report.horizontal_illuminance_lx - report.sky_illuminance_lx),
        lux(report.sky_illuminance_lx),
    );
    let how = if exposure == Exposure::Auto { "metered" } else { "fixed" };
    match (report.exposure_ev100, report.tonemap) {
        (Some(ev100), Some(tonemap)) => out!("exposure     EV {ev100:.2} ({how}), {tonemap}"),
        (Some(ev100), None) => out!("exposure     EV {ev100:.2} ({how}), linear"),
        (None, _) => out!("exposure     none: cd/m²"),
    }
    out!("atmosphere   {} — {}", report.preset, model.preset().title);
    if let Some(adapter) = &report.adapter {
        out!("adapter      {adapter}");
    }
    if let Some(reference) = &report.reference {
        out!("solver       {}", report.solver);
        reference.print();
    }
    out!("picture      {} ({}×{}) in {:.2} s", report.file, report.width_px, report.height_px, report.seconds);
    unfinished
}

/// The cache that `--cache` names.
fn cache(wanted: Option<&Path>) -> Option<TablesCache> {
    match wanted {
        None => TablesCache::platform(),
        Some(word) if word.as_os_str() == "off" => None,
        Some(folder) => Some(TablesCache::in_folder(folder)),
    }
}

/// What a solver hands back.
pub struct Done {
    /// The picture, which is written already.
    pub picture: Picture,
    /// Illuminance in lx: of a surface that faces the Sun, by it; of level ground by the sky; of level ground by both.
    pub lux: [f64; 3],
    /// The GPU, where there was one.
    pub adapter: Option<String>,
    /// About the samples, where there were some.
    pub reference: Option<render_reference::Report>,
    /// Why the picture is not all that was asked for.
    pub unfinished: Option<String>,
}

/// The scene with its time fixed and its preset findable from anywhere.
fn reproducible(scene: &Scene, model: &SkyModel) -> Scene {
    let mut scene = scene.clone();
    scene.clock.time = model.utc().to_string();
    if scene.preset.ends_with(".toml")
        && let Ok(path) = scene.folder.join(&scene.preset).canonicalize()
    {
        scene.preset = path.display().to_string();
    }
    scene
}

/// Three digits, for people.
fn lux(value: f64) -> String {
    match value {
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 0.01 || v == 0.0 => format!("{v:.2}"),
        v => format!("{v:.1e}"),
    }
}
