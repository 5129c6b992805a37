//! `himmel`: skies as pictures and numbers.

mod commands;
mod progress;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// The sky of any place and time, physically right.
#[derive(Parser)]
#[command(
    name = "himmel",
    version,
    max_term_width = 110,
    after_help = "Examples:\n  himmel render --place Potsdam --time 2012-09-06T20:00 -o sky.png\n  himmel ephemeris moon --place Potsdam\n  himmel almanac --place Potsdam --date 2012-09-06\n  himmel eclipses solar --place Stuttgart --from 1999-01-01 --to 1999-12-31\n  himmel params\n  himmel info"
)]
struct Cli {
    /// Print nothing but errors (and data that was asked for).
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a picture of the sky.
    Render(commands::render::Args),
    /// List every parameter: name, unit, range, default, meaning.
    Params(commands::params::Args),
    /// Name the GPU adapter, its limits, and the data sets with their licences.
    Info(commands::info::Args),
    /// Where bodies and stars are: one now, or a table of questions.
    Ephemeris(commands::ephemeris::Args),
    /// Rise, set, transit, twilights and Moon phases for a place.
    Almanac(commands::almanac::Args),
    /// Eclipses of the Moon, and of the Sun at a place.
    Eclipses(commands::eclipses::Args),
    /// Particles, gases and whole atmospheres: cross sections, optical depth, phase functions, plots.
    Optics(commands::optics::Args),
    /// Radiance along lines of sight, with all orders of scattering: one question, or a table of them.
    Radiance(commands::radiance::Args),
    /// Illuminance by Sun and sky, zenith luminance, spectrum: for a place and time, or over time.
    Light(commands::light::Args),
    /// Measure the renderer: medians of frames and passes, beside those of the usual approximation.
    Bench(commands::bench::Args),
}

/// Prints a line; see [`print_bytes`].
#[macro_export]
macro_rules! out {
    ($($text:tt)*) => {
        $crate::print_bytes(format!("{}\n", format_args!($($text)*)).as_bytes())
    };
}

/// Writes to the standard output. A reader that has left (`himmel params | head`) ends the program quietly: nobody wants
/// the rest. Anything else, a full disk, is a failure.
pub fn print_bytes(bytes: &[u8]) {
    use std::io::Write as _;
    let mut stdout = std::io::stdout();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Ok(()) => {}
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(error) => {
            eprintln!("himmel: cannot write the standard output: {error}");
            std::process::exit(1);
        }
    }
}

/// Why a command ended: 2 for bad usage, 1 for everything else.
pub struct Failure {
    code: u8,
    message: String,
}

impl Failure {
    /// The command line asks for something that cannot be.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into() }
    }

    /// It was well asked, and did not work.
    pub fn failed(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into() }
    }
}

impl From<himmel::Error> for Failure {
    fn from(error: himmel::Error) -> Self {
        use himmel::Error as E;
        let code = match error {
            E::Place(_)
            | E::Time { .. }
            | E::Look(_)
            | E::Camera(_)
            | E::Param(_)
            | E::FileFormat { .. }
            | E::Air(himmel::parts::air::AirError::UnknownPreset { .. })
            | E::Gpu(himmel::GpuError::Size { .. } | himmel::GpuError::Comparison(_)) => 2,
            _ => 1,
        };
        Self { code, message: error.to_string() }
    }
}

impl From<himmel::GpuError> for Failure {
    fn from(error: himmel::GpuError) -> Self {
        himmel::Error::from(error).into()
    }
}

/// Mesa's device-selection layer asks a Wayland server for advice and complains on the terminal where there is none.
#[cfg(target_os = "linux")]
fn hush_device_selection() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: called first in `main`; no other thread exists that could read the environment.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    hush_device_selection();
    // Warnings only, unless HIMMEL_LOG asks for more: info, debug, himmel_gpu=trace.
    let filter = tracing_subscriber::EnvFilter::try_from_env("HIMMEL_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("error,himmel=warn,himmel_gpu=warn"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).without_time().init();
    let cli = Cli::parse();
    let result = match cli.command {
        Command::Render(args) => commands::render::run(&args, cli.quiet),
        Command::Params(args) => commands::params::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Ephemeris(args) => commands::ephemeris::run(&args),
        Command::Almanac(args) => commands::almanac::run(&args, cli.quiet),
        Command::Eclipses(args) => commands::eclipses::run(&args, cli.quiet),
        Command::Optics(args) => commands::optics::run(&args, cli.quiet),
        Command::Radiance(args) => commands::radiance::run(&args, cli.quiet),
        Command::Light(args) => commands::light::run(&args, cli.quiet),
        Command::Bench(args) => commands::bench::run(&args, cli.quiet),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { code, message }) => {
            eprintln!("himmel: {message}");
            ExitCode::from(code)
        }
    }
}
