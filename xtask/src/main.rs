//! Development tasks: `cargo xtask golden propose | review | accept NAME… | accept --all`,
//! `cargo xtask accuracy reference | moments | gpu | elevation | colour | day | dusk`,
//! `cargo xtask pictures`, `cargo xtask data milky-way FILES…`.
//!
//! Data is made by the scripts beside this crate: `xtask/data/*.py` (colour, light, air, places) and `xtask/astro/*.py`
//! (ephemeris pack, series, stars); each names what it needs at its top, and each table's `SOURCE.md` names its command.

mod accuracy;
mod pictures;

use std::process::ExitCode;

const USAGE: &str = "cargo xtask golden propose [TEST…]   run the golden tests and keep their new pictures
cargo xtask golden review              compare them with the accepted ones, numbers and a sheet each
cargo xtask golden accept NAME… | --all
cargo xtask accuracy reference | moments | gpu | elevation | colour | day | dusk [--quick] [--output FILE]   tables of errors, for docs/
cargo xtask pictures [NAME…]           ours and the tracer's side by side, for docs/
cargo xtask data milky-way TYCHO2_INDEX.fits MW_edgeon_edr3_unannotate.jpg [FOLDER] [QUALITY]   needs python3 with numpy and pillow";

/// Runs the script beside this crate that makes an asset.
fn data(args: &[String]) -> Result<(), String> {
    let script = match args.first().map(String::as_str) {
        Some("milky-way") => "milky_way.py",
        other => return Err(format!("unknown data \"{}\"\n{USAGE}", other.unwrap_or_default())),
    };
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(script);
    match std::process::Command::new("python3").arg(&path).args(&args[1..]).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{} ended with {status}", path.display())),
        Err(error) => Err(format!("python3 cannot be run: {error}")),
    }
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let result = match args.split_first() {
        Some((task, rest)) if task == "golden" => himmel_golden::cli::run(rest).map_err(|error| error.to_string()),
        Some((task, rest)) if task == "accuracy" => accuracy::run(rest),
        Some((task, rest)) if task == "pictures" => pictures::run(rest),
        Some((task, rest)) if task == "data" => data(rest),
        Some((task, _)) if task != "help" && task != "--help" => Err(format!("unknown task \"{task}\"\n{USAGE}")),
        _ => {
            println!("{USAGE}");
            Ok(())
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
