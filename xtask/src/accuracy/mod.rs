//! `cargo xtask accuracy`: how far results are from those of others, as tables for `docs/`.

mod class;
mod colour;
mod day;
mod dusk;
mod elevation;
mod moments;
mod reference;

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::DVec3;

/// What it does.
pub const USAGE: &str =
    "cargo xtask accuracy reference [--quick] [--output FILE.md]   the tracer against other programs and laws
cargo xtask accuracy moments [--quick] [--output FILE.md]     the moment solver and Hillaire 2020 against the tracer
cargo xtask accuracy gpu [--quick] [--output FILE.md]         the renderer on the GPU, and Hillaire 2020, against the tracer
cargo xtask accuracy elevation [--quick] [--output FILE.svg]  their errors over the Sun's elevation, as a plot
cargo xtask accuracy colour [--quick] [--output FILE.md]      four wavelengths and sharp channels against full spectra
cargo xtask accuracy day [--quick] [--output FILE.md]         a day's illuminance against a published fit; day.svg beside FILE.md
cargo xtask accuracy dusk [--quick] [--output FILE.md]         when stars come out between sunset and night; dusk-stars.jpg beside FILE.md
cargo xtask accuracy day-pictures --output FOLDER             the day's pictures, and a night with and without the Moon
cargo xtask accuracy grid [--quick]                           questions for `himmel radiance`, a grid over all geometries
moments, gpu: --class day,horizon,94,96,30km,space,haze,mars,titan,earth   only these, in this order
moments, gpu, elevation: --points N   lines of sight of a class (60; 20 for each elevation)
                         --kept DIR   where the tracer's answers are kept (target/accuracy): none is traced twice, and a run
                                      that was stopped goes on where it was";

/// How much work.
#[derive(Clone, Copy)]
pub struct Work {
    /// A tenth of it, to see that it runs.
    pub quick: bool,
}

impl Work {
    /// That many, or a tenth.
    pub fn count(self, full: u64) -> u64 {
        if self.quick { (full / 10).max(1) } else { full }
    }
}

/// Which classes, and how much of them.
pub struct Choice {
    pub work: Work,
    /// Keys of classes in the order in which they are wanted; empty means all.
    pub classes: Vec<String>,
    /// Lines of sight of a class.
    pub points: usize,
    /// The folder of the tracer's answers.
    pub kept: PathBuf,
}

/// Runs one table.
pub fn run(args: &[String]) -> Result<(), String> {
    let (mut work, mut output, mut what) = (Work { quick: false }, None, None);
    let (mut classes, mut points, mut kept) = (Vec::new(), None, None);
    let mut words = args.iter();
    while let Some(word) = words.next() {
        let mut next = |takes: &str| words.next().cloned().ok_or_else(|| format!("{word} takes {takes}"));
        match word.as_str() {
            "--quick" => work.quick = true,
            "--output" => output = Some(next("a file")?),
            "--class" => classes = next("names of classes, with commas")?.split(',').map(str::to_owned).collect(),
            "--points" => {
                let number = next("a number")?;
                let sensible = number.parse::<usize>().ok().filter(|n| (1..=100_000).contains(n));
                points = Some(sensible.ok_or(format!("--points must lie in 1..=100000, got {number}"))?);
            }
            "--kept" => kept = Some(PathBuf::from(next("a folder")?)),
            name if what.is_none() && !name.starts_with('-') => what = Some(name.to_owned()),
            other => return Err(format!("what is \"{other}\"?\n{USAGE}")),
        }
    }
    if what.as_deref() == Some("grid") {
        print!("{}", grid(work));
        return Ok(());
    }
    if what.as_deref() == Some("day-pictures") {
        let folder = output.ok_or("day-pictures takes --output FOLDER")?;
        print!("{}", day::pictures(std::path::Path::new(&folder))?);
        return Ok(());
    }
    // Quick answers have a quick one's noise: they are kept beside the others.
    let kept =
        kept.unwrap_or_else(|| PathBuf::from(if work.quick { "target/accuracy/quick" } else { "target/accuracy" }));
    let choice = |full: u64| Choice { work, classes, points: points.unwrap_or(work.count(full) as usize), kept };
    let open = || himmel::Gpu::open(None).map_err(|error| error.to_string());
    let put = |text: &str| match &output {
        Some(path) => std::fs::write(path, text).map_err(|error| format!("cannot write {path}: {error}")),
        None => Ok(()),
    };
    let beside = output.as_ref().and_then(|path| std::path::Path::new(path).parent());
    let started = std::time::Instant::now();
    let mut text = match what.as_deref() {
        Some("reference") => reference::table(work)?,
        Some("moments") => moments::table(&choice(60), None, put)?,
        Some("gpu") => {
            let gpu = open()?;
            let head = format!("Adapter: {}.\n\n", gpu.report());
            let body = moments::table(&choice(60), Some(&gpu), |text| put(&format!("{head}{text}")))?;
            format!("{head}{body}")
        }
        Some("elevation") => return elevation::plot(&choice(20), &open()?, output.as_deref()),
        Some("colour") => colour::table(work)?,
        Some("day") => day::table(work, beside)?,
        Some("dusk") => dusk::table(work, beside)?,
        _ => return Err(USAGE.into()),
    };
    let _ = writeln!(
        text,
        "\n`cargo xtask accuracy {}{}`, {:.0} s on {} threads.",
        what.unwrap_or_default(),
        if work.quick { " --quick" } else { "" },
        started.elapsed().as_secs_f64(),
        std::thread::available_parallelism().map_or(1, usize::from)
    );
    if output.is_none() {
        print!("{text}");
    }
    put(&text)
}

/// Questions for `himmel radiance --input`: four altitudes, Suns from the zenith to 6° below the horizon, views from the
/// zenith to half a degree above it, azimuths, three wavelengths.
fn grid(work: Work) -> String {
    let mut text = String::from("altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm\n");
    let mut count = 0;
    for altitude_m in [0.0, 2e3, 10e3, 30e3] {
        for sun in [0.0, 30.0, 60.0, 75.0, 85.0, 90.0, 92.0, 94.0, 96.0] {
            for zenith in [0.0, 30.0, 60.0, 80.0, 87.0, 89.5] {
                for azimuth in [0.0, 45.0, 90.0, 180.0] {
                    for nm in [680.0, 550.0, 440.0] {
                        count += 1;
                        if !work.quick || count % 10 == 0 {
                            let _ = writeln!(text, "{altitude_m},{sun},{zenith},{azimuth},{nm}");
                        }
                    }
                }
            }
        }
    }
    text
}

/// Unit vector of a view: zenith angle and azimuth from the Sun's, degrees; z is the zenith, the Sun over +x.
pub fn view(zenith_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (zenith, azimuth) = (zenith_deg.to_radians(), azimuth_deg.to_radians());
    DVec3::new(zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin(), zenith.cos())
}

/// Numbers that are the same in every run (xorshift64*).
pub struct Random(u64);

impl Random {
    /// Starts from a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// A number in low..high.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let unit = (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64;
        low + unit * (high - low)
    }
}

/// A share 0..=1 of a list, sorted by size; 0 of an empty one.
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let index = ((values.len() as f64 - 1.0) * share).round().max(0.0) as usize;
    values.get(index).copied().unwrap_or(0.0)
}
