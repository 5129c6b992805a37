//! `himmel bench`

use himmel::bench::{self, Medians, Options, Report};
use himmel::{Gpu, GpuError, Scene, bench_stars};
use serde_json::json;

use super::scene::SceneArgs;
use crate::progress::Progress;
use crate::{Failure, out};

/// Arguments of `himmel bench`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  himmel bench\n  himmel bench --size 1920x1080 --frames 51 --json\n  himmel bench --stars --fov 60\n  himmel bench --adapter swiftshader --preset mars --set light.sun.altitude_deg=-4\n\nHillaire is the approximation that most engines draw (Hillaire 2020), at its usual sizes; it redoes its tables of Sun and\ncamera in each frame, or all of its tables. Frames of all kinds are drawn in turn, the Sun moves from frame to frame, and\nthe exposure is fixed (EV100 14 unless --exposure says another).\n\nTimes are of the adapter that is named; on a software rasteriser compare ratios only. Other work on the\nmachine delays the two unequally: if fastest and median lie far apart, measure again when it is quiet."
)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames of each kind to take the median of.
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// Frames of each kind before those.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    warm_up: u32,
    /// low, medium, high, or film: as --set air.quality=NAME.
    #[arg(long, value_name = "NAME")]
    quality: Option<String>,
    /// Measure what 9,000 stars on screen add to a night instead.
    #[arg(long)]
    stars: bool,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let mut scene = args.scene.scene()?;
    if args.scene.time.is_none() && args.scene.scene.is_none() {
        scene.set("clock.time", if args.stars { "2012-01-20T22:00Z" } else { "2012-09-06T16:00Z" })?;
    }
    if let Some(quality) = &args.quality {
        scene.set("air.quality", quality)?;
    }
    let gpu = Gpu::open(args.scene.adapter.as_deref())?;
    if args.stars {
        return stars(&gpu, &scene, args, quiet);
    }
    let progress = Progress::new("measuring", quiet);
    let options = Options { frames: args.frames as usize, warm_up: args.warm_up as usize };
    let report = bench::run(&gpu, &scene, options, &mut |share| progress.update(share));
    drop(progress);
    let report = match report {
        Err(himmel::Error::Gpu(GpuError::Cancelled)) => return Err(Failure::failed("stopped: nothing was measured")),
        report => report?,
    };
    if args.json {
        let json = as_json(&report, args, &scene);
        out!("{}", serde_json::to_string_pretty(&json).map_err(|e| Failure::failed(e.to_string()))?);
    } else {
        print_table(&report, args, &scene);
    }
    Ok(())
}

/// What stars add to a night.
fn stars(gpu: &Gpu, scene: &Scene, args: &Args, quiet: bool) -> Result<(), Failure> {
    let progress = Progress::new("measuring", quiet);
    let options = Options { frames: args.frames as usize, warm_up: args.warm_up as usize };
    let report = bench_stars::run(gpu, scene, options, &mut |share| progress.update(share));
    drop(progress);
    let report = match report {
        Err(himmel::Error::Gpu(GpuError::Cancelled)) => return Err(Failure::failed("stopped: nothing was measured")),
        report => report?,
    };
    if args.json {
        let json = json!({
            "adapter": { "name": report.adapter.name },
            "width_px": scene.output.width_px,
            "height_px": scene.output.height_px,
            "stars": report.stars,
            "frame_median_ms": { "without": report.without.frame_ms, "with": report.with.frame_ms },
            "frame_fastest_ms": { "without": report.without.fastest_ms, "with": report.with.fastest_ms },
            "stars_ms": report.cost_ms(),
        });
        out!("{}", serde_json::to_string_pretty(&json).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    out!("adapter   {}", report.adapter);
    out!("frame     {}×{}, {} stars on screen", scene.output.width_px, scene.output.height_px, report.stars);
    for (name, medians) in [("without stars", &report.without), ("with stars", &report.with)] {
        out!("{name:<14} {:>8.2} ms, fastest {:>8.2} ms", medians.frame_ms, medians.fastest_ms);
        for (label, ms) in &medians.passes.passes {
            out!("  {label:<18} {ms:>8.2} ms");
        }
    }
    out!("stars add {:.2} ms by the fastest frames", report.cost_ms());
    Ok(())
}

/// The four kinds of frames: key in JSON, name in the table.
fn kinds(report: &Report) -> [(&'static str, &'static str, &Medians); 4] {
    [
        ("empty", "empty", &report.empty),
        ("sky", "Himmel", &report.sky),
        ("hillaire", "Hillaire, Sun moves", &report.hillaire),
        ("hillaire_every_table", "Hillaire, every table", &report.hillaire_everything),
    ]
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

fn pixels(scene: &Scene) -> f64 {
    f64::from(scene.output.width_px) * f64::from(scene.output.height_px)
}

fn as_json(report: &Report, args: &Args, scene: &Scene) -> serde_json::Value {
    let adapter = &report.adapter;
    let frames: serde_json::Map<_, _> =
        kinds(report).map(|(key, _, medians)| (key.to_string(), json!(medians.frame_ms))).into_iter().collect();
    let fastest: serde_json::Map<_, _> =
        kinds(report).map(|(key, _, medians)| (key.to_string(), json!(medians.fastest_ms))).into_iter().collect();
    let passes: serde_json::Map<_, _> = kinds(report)
        .map(|(key, _, medians)| {
            let passes = medians.passes.passes.iter().map(|(label, ms)| ((*label).to_string(), json!(ms)));
            (key.to_string(), passes.collect::<serde_json::Map<_, _>>().into())
        })
        .into_iter()
        .collect();
    json!({
        "adapter": {
            "name": adapter.name, "back_end": adapter.back_end, "kind": adapter.kind, "driver": adapter.driver,
        },
        "preset": scene.preset,
        "width_px": scene.output.width_px,
        "height_px": scene.output.height_px,
        "quality": report.quality.word(),
        "samples_per_ray": report.samples_per_ray,
        "samples_per_pixel": report.samples_per_pixel(pixels(scene)),
        "frames": args.frames,
        "warm_up_frames": args.warm_up,
        "frame_median_ms": frames,
        "frame_fastest_ms": fastest,
        "pass_median_ms": passes,
        "ratio": {
            "sky_to_hillaire": report.ratio(&report.hillaire),
            "sky_to_hillaire_above_empty": report.ratio_above_empty(&report.hillaire),
            "sky_to_hillaire_every_table": report.ratio(&report.hillaire_everything),
            "sky_to_hillaire_every_table_above_empty": report.ratio_above_empty(&report.hillaire_everything),
        },
        "edit": {
            "first_frame_ms": report.edit.first_frame_ms,
            "first_frame_in_frames": report.edit_ratio(),
            "complete_frames": report.edit.complete_frames,
            "complete_ms": report.edit.complete_ms,
        },
        "tables_mib": { "sky": mib(report.table_bytes), "hillaire": mib(report.hillaire_table_bytes) },
    })
}

fn print_table(report: &Report, args: &Args, scene: &Scene) {
    out!("adapter   {}", report.adapter);
    out!(
        "frame     {}×{}, {}; medians of {} frames of each kind",
        scene.output.width_px,
        scene.output.height_px,
        scene.preset,
        args.frames
    );
    let rays =
        report.sky_view.map_or("each pixel".into(), |[across, up]| format!("each of the {across}×{up} of a table"));
    out!(
        "quality   {}: {} samples on the ray of {rays}, {:.2} per pixel",
        report.quality.word(),
        report.samples_per_ray,
        report.samples_per_pixel(pixels(scene))
    );
    out!("");
    out!("                                   ms   above empty     fastest");
    for (_, name, medians) in kinds(report) {
        let above = medians.frame_ms - report.empty.frame_ms;
        let above = if name == "empty" { " ".repeat(11) } else { format!("{above:>11.2}") };
        out!("{name:<26} {:>10.2}   {above}  {:>10.2}", medians.frame_ms, medians.fastest_ms);
        for (label, ms) in &medians.passes.passes {
            out!("  {label:<28} {ms:>6.2}");
        }
    }
    if report.sky.passes.passes.is_empty() {
        out!("(no passes: the adapter offers no time stamps)");
    }
    out!("");
    for (name, other) in [("Sun moves", &report.hillaire), ("every table", &report.hillaire_everything)] {
        out!(
            "Himmel is {:.2} Hillaire frames ({name}), {:.2} above an empty frame",
            report.ratio(other),
            report.ratio_above_empty(other)
        );
    }
    out!(
        "edit      of the air: first frame after {:.1} ms, {:.1} normal frames; complete after {} in {:.1} ms",
        report.edit.first_frame_ms,
        report.edit_ratio(),
        if report.edit.complete_frames == 1 {
            "that one".into()
        } else {
            format!("{} frames", report.edit.complete_frames)
        },
        report.edit.complete_ms
    );
    out!("tables    Himmel {:.2} MiB, Hillaire {:.2} MiB", mib(report.table_bytes), mib(report.hillaire_table_bytes));
}
