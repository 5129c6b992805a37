//! `himmel render --solver reference`

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use himmel::picture::{FileFormat, save_bytes, save_with_errors};
use himmel::spectral::{Noise, PATHS_PER_PASS, ReferencePicture, WAVELENGTHS};
use himmel::{Output, SkyModel};
use serde::Serialize;

use super::render::Done;
use crate::progress::Progress;
use crate::{Failure, out};

/// Paths of each pixel where nothing else is asked: two passes, the fewest that have an error.
const PATHS: u64 = 64;
/// Most paths where an error is asked for.
const MOST_PATHS: u64 = 1 << 17;
/// Passes before an error is believed.
const LEAST_PASSES: u64 = 4;
/// How often the samples so far are written, at least.
const SAVE_EVERY: Duration = Duration::from_secs(30);
/// Rays for the illuminance of the report.
const ILLUMINANCE_RAYS: u32 = 128;

/// Options of the reference solver.
#[derive(clap::Args)]
pub struct ReferenceArgs {
    /// Paths through each pixel, rounded up to whole passes of 32 [default: 64; with --target-error at most 131072].
    #[arg(long, value_name = "N")]
    samples: Option<u64>,
    /// Go on until half of the pixels have this relative standard error of luminance, such as 0.01.
    #[arg(long, value_name = "SHARE")]
    target_error: Option<f64>,
    /// Seed of the random numbers [default: 1].
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Go on from the samples beside the picture (FILE.partial) if there are any, and leave them there for next time.
    #[arg(long)]
    resume: bool,
}

/// About the samples.
#[derive(Serialize)]
pub struct Report {
    wavelengths: usize,
    paths_per_pixel: u64,
    median_relative_error: Option<f64>,
    percentile_95_relative_error: Option<f64>,
    seed: u64,
    /// Of this run.
    paths_per_second: f64,
}

impl ReferenceArgs {
    /// Refuses options that the other solver does not know.
    pub fn refuse(&self) -> Result<(), Failure> {
        let given = [
            ("--samples", self.samples.is_some()),
            ("--target-error", self.target_error.is_some()),
            ("--seed", self.seed.is_some()),
            ("--resume", self.resume),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(Failure::usage(format!("{name} belongs to --solver reference"))),
            None => Ok(()),
        }
    }

    fn check(&self) -> Result<(), Failure> {
        match (self.samples, self.target_error) {
            (Some(samples), _) if !(1..=1 << 32).contains(&samples) => {
                Err(Failure::usage(format!("--samples takes 1 to 4294967296 paths per pixel, got {samples}")))
            }
            (_, Some(target)) if !(1e-6..=1.0).contains(&target) => Err(Failure::usage(format!(
                "--target-error takes a share of the luminance in 0.000001..=1, such as 0.01 for 1 %; got {target}"
            ))),
            _ => Ok(()),
        }
    }
}

/// Renders, writes the picture, and says what was done. Ctrl-C: the passes so far are written as a picture and as samples.
pub fn run(
    args: &ReferenceArgs,
    model: &SkyModel,
    output: &Path,
    format: FileFormat,
    quiet: bool,
) -> Result<Done, Failure> {
    args.check()?;
    let seed = args.seed.unwrap_or(1);
    let mut reference = ReferencePicture::new(model, seed)?;
    let partial = PathBuf::from(format!("{}.partial", output.display()));
    if args.resume && partial.exists() {
        let bytes = std::fs::read(&partial).map_err(|source| himmel::Error::Read { path: partial.clone(), source })?;
        reference.resume(&bytes).map_err(|error| {
            Failure::failed(format!("{error}; delete it, or leave out --resume to begin anew: {}", partial.display()))
        })?;
    }
    let default = if args.target_error.is_some() { MOST_PATHS } else { PATHS };
    let passes = args.samples.unwrap_or(default).div_ceil(u64::from(PATHS_PER_PASS));
    let (started, first) = (Instant::now(), reference.passes());
    let progress = Progress::new("tracing", quiet);
    let mut saved = Instant::now();
    while reference.passes() < passes && !reached(&reference, args.target_error) {
        let before = share(&reference, passes, args.target_error);
        let of_pass = 1.0 / (passes - first) as f64;
        let none_yet = reference.passes() == 0;
        let whole = reference.add_pass(&mut |done| {
            progress.update((before + of_pass * done).min(1.0));
            // A picture needs one pass; who does not want to wait for it presses again.
            progress.presses() < if none_yet { 2 } else { 1 }
        })?;
        if let Some(noise) = reference.noise() {
            progress.say(format!("tracing, noise {:.2} %", 100.0 * noise.median));
        }
        if !whole || progress.presses() > 0 {
            break;
        }
        if saved.elapsed() > SAVE_EVERY {
            save_bytes(&reference.state(), &partial)?;
            saved = Instant::now();
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    if reference.passes() == 0 {
        return Err(Failure::failed("interrupted before the first pass was done; nothing was written"));
    }
    let finished = reference.passes() >= passes || reached(&reference, args.target_error);
    drop(progress);
    let picture = reference.picture(&model.scene().output, format.output());
    let errors: Option<Vec<f32>> = (reference.passes() > 1 && format.output() == Output::Radiance)
        .then(|| reference.error_cd_m2().iter().map(|error| (error * picture.exposure) as f32).collect());
    save_with_errors(&picture, errors.as_deref(), output)?;
    if args.resume || !finished {
        save_bytes(&reference.state(), &partial)?;
    } else if saved > started || partial.exists() {
        // The samples of an unfinished run: the picture is whole now.
        let _ = std::fs::remove_file(&partial);
    }
    let (width, height) = reference.size();
    let paths = (reference.passes() - first) * u64::from(PATHS_PER_PASS) * u64::from(width) * u64::from(height);
    let noise = reference.noise();
    let (direct_lx, sky_lx) = reference.illuminance_lx(ILLUMINANCE_RAYS)?;
    let sun_lx = reference.sun_illuminance_lx()?;
    Ok(Done {
        picture,
        lux: [sun_lx, sky_lx, direct_lx + sky_lx],
        adapter: None,
        reference: Some(Report {
            wavelengths: WAVELENGTHS,
            paths_per_pixel: reference.paths_per_pixel(),
            median_relative_error: noise.map(|noise| noise.median),
            percentile_95_relative_error: noise.map(|noise| noise.percentile_95),
            seed,
            paths_per_second: if seconds > 0.0 { paths as f64 / seconds } else { 0.0 },
        }),
        unfinished: (!finished).then(|| {
            format!(
                "interrupted after {} of {} paths per pixel: {} shows what there is; the same command with --resume goes on",
                reference.paths_per_pixel(),
                passes * u64::from(PATHS_PER_PASS),
                output.display()
            )
        }),
    })
}

/// Whether the picture is as good as was asked.
fn reached(reference: &ReferencePicture, target: Option<f64>) -> bool {
    let enough = |noise: Noise| target.is_some_and(|target| noise.median <= target);
    reference.passes() >= LEAST_PASSES && reference.noise().is_some_and(enough)
}

/// The share of the work that is done: the error falls with the square root of the passes.
fn share(reference: &ReferencePicture, passes: u64, target: Option<f64>) -> f64 {
    let by_passes = reference.passes() as f64 / passes as f64;
    match (target, reference.noise()) {
        (Some(target), Some(noise)) => (target / noise.median).powi(2).clamp(by_passes, 1.0),
        _ => by_passes,
    }
}

impl Report {
    /// For people.
    pub fn print(&self) {
        let percent = |error: Option<f64>| error.map_or("unknown".into(), |error| format!("{:.2} %", 100.0 * error));
        out!(
            "samples      {} paths per pixel, seed {}, {:.0} paths/s",
            self.paths_per_pixel,
            self.seed,
            self.paths_per_second
        );
        out!(
            "noise        standard error of luminance: median {}, 95 % of pixels below {}",
            percent(self.median_relative_error),
            percent(self.percentile_95_relative_error)
        );
    }
}
