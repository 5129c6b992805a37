//! `himmel bench`

use std::time::Instant;

use himmel::{Gpu, Output, SkyModel};

use super::scene::SceneArgs;
use crate::{Failure, out};

/// Arguments of `himmel bench`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  himmel bench\n  himmel bench --size 1920x1080 --frames 50 --json\n\nTimes are of the adapter that is named; on a software rasteriser compare ratios only."
)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames to take the median of.
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args, _quiet: bool) -> Result<(), Failure> {
    let mut scene = args.scene.scene()?;
    if args.scene.time.is_none() && args.scene.scene.is_none() {
        scene.set("clock.time", "2012-09-06T16:00Z")?;
    }
    let started = Instant::now();
    let model = SkyModel::new(&scene)?;
    let tables_s = started.elapsed().as_secs_f64();
    let gpu = Gpu::open(args.scene.adapter.as_deref())?;
    let started = Instant::now();
    let times = himmel::picture::pass_medians(&gpu, &model, Output::Display, args.frames as usize)?;
    let wall_s = started.elapsed().as_secs_f64();
    let table_bytes = himmel::Still::new(&gpu, Output::Display, model.atmosphere())?.renderer().table_bytes();
    let (width, height) = (scene.output.width_px, scene.output.height_px);
    if args.json {
        let passes: serde_json::Map<_, _> =
            times.passes.iter().map(|(label, ms)| ((*label).to_string(), serde_json::json!(ms))).collect();
        let json = serde_json::json!({
            "adapter": gpu.report().to_string(),
            "width_px": width, "height_px": height, "frames": args.frames,
            "pass_median_ms": passes,
            "table_bytes": table_bytes,
            "tables_cpu_s": tables_s,
        });
        out!("{}", serde_json::to_string_pretty(&json).map_err(|e| Failure::failed(e.to_string()))?);
        return Ok(());
    }
    out!("adapter   {}", gpu.report());
    out!("frame     {width}×{height}, median of {} frames", args.frames);
    if times.passes.is_empty() {
        out!(
            "passes    not measured: the adapter offers no time stamps; {:.1} ms a frame with read-back",
            wall_s * 1e3 / f64::from(args.frames + 1)
        );
    }
    for (label, ms) in &times.passes {
        out!("  {label:<18} {ms:>8.3} ms");
    }
    out!(
        "tables    {:.2} MiB on the GPU; {:.0} ms of CPU after an edit of the air, none when the Sun moves",
        table_bytes as f64 / f64::from(1 << 20),
        tables_s * 1e3
    );
    Ok(())
}
