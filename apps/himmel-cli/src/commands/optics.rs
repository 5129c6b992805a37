//! `himmel optics`: what particles, gases and whole atmospheres do to light, as numbers and plots.

mod plot;

use std::path::Path;

use himmel_air::lognormal::{self, Mode};
use himmel_air::mie::{Index, Mie};
use himmel_air::{AirError, Preset};

use crate::{Failure, out};

/// Arguments of `himmel optics`.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  himmel optics mie --radius-um 0.5 --index 1.5,0.01 --wavelength-nm 550
  himmel optics lognormal --mode 0.1,1.6,100 --index 1.5,0.01 --wavelength-nm 550
  himmel optics depth --preset bruneton2017
  himmel optics plot --preset mars --what phase -o phase.svg")]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    /// One sphere, by exact Lorenz–Mie: efficiencies and mean cosine.
    #[command(
        after_help = "Example:\n  himmel optics mie --radius-um 0.525 --index 1.55,0 --wavelength-nm 632.8 --json"
    )]
    Mie(MieArgs),
    /// Log-normal modes of spheres: cross sections of a mean particle.
    #[command(
        after_help = "Example:\n  himmel optics lognormal --mode 0.069,2.03,1.3e4 --mode 0.97,2.15,4.2 --index 1.57,0.02 --wavelength-nm 550"
    )]
    Lognormal(LognormalArgs),
    /// A component of an atmosphere: coefficients, albedo, mean cosine, Legendre moments, column.
    #[command(
        after_help = "Example:\n  himmel optics component --preset venus --name clouds --wavelength-nm 550 --json"
    )]
    Component(ComponentArgs),
    /// Vertical optical depth of an atmosphere, by component.
    #[command(after_help = "Example:\n  himmel optics depth --preset bruneton2017 --wavelength-nm 550 --json")]
    Depth(DepthArgs),
    /// Plot density over altitude, coefficients over wavelength, or phase functions: PNG or SVG.
    #[command(after_help = "Example:\n  himmel optics plot --preset earth --what phase -o phase.svg")]
    Plot(plot::Args),
}

#[derive(clap::Args)]
struct MieArgs {
    /// Radius, µm.
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    radius_um: f64,
    /// Refractive index n − ik as N,K; k ≥ 0 absorbs.
    #[arg(long, value_name = "N,K", allow_hyphen_values = true)]
    index: String,
    /// Wavelength, nm.
    #[arg(long, value_name = "L", allow_hyphen_values = true)]
    wavelength_nm: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct LognormalArgs {
    /// A mode: median radius (µm), geometric standard deviation, particles per cm³. Several are allowed.
    #[arg(long, value_name = "RG,SG,N", required = true, num_args = 1..)]
    mode: Vec<String>,
    /// Refractive index n − ik as N,K; k ≥ 0 absorbs.
    #[arg(long, value_name = "N,K", allow_hyphen_values = true)]
    index: String,
    /// Wavelength, nm.
    #[arg(long, value_name = "L", allow_hyphen_values = true)]
    wavelength_nm: f64,
    /// Exact, or as thesis B.
    #[arg(long, default_value = "lorenz-mie", value_parser = ["lorenz-mie", "harmonic-mean"])]
    method: String,
    /// Single-scattering albedo, which the harmonic mean takes as given (thesis B: 0.87).
    #[arg(long, default_value_t = 0.87, allow_hyphen_values = true)]
    albedo: f64,
    /// Mean cosine, which the harmonic mean takes as given (thesis B: 0.761).
    #[arg(long, default_value_t = 0.761, allow_hyphen_values = true)]
    g: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct ComponentArgs {
    /// Name of a preset, or a .toml file.
    #[arg(long, default_value = "earth")]
    preset: String,
    /// Name of the component.
    #[arg(long)]
    name: String,
    /// Wavelength, nm.
    #[arg(long, value_name = "L", default_value_t = 550.0, allow_hyphen_values = true)]
    wavelength_nm: f64,
    /// Legendre moments to print.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=64))]
    moments: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct DepthArgs {
    /// Name of a preset, or a .toml file.
    #[arg(long, default_value = "earth")]
    preset: String,
    /// Wavelengths, nm; several are allowed.
    #[arg(long, value_name = "L", default_values_t = [550.0], num_args = 1..)]
    wavelength_nm: Vec<f64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl From<AirError> for Failure {
    fn from(error: AirError) -> Self {
        match error {
            AirError::Optics { .. } | AirError::UnknownPreset { .. } => Self::usage(error.to_string()),
            _ => Self::failed(error.to_string()),
        }
    }
}

/// Largest preset file that is read, bytes.
const LARGEST_PRESET: u64 = 4 << 20;

/// A preset by name, or from a file.
pub(super) fn preset(name: &str) -> Result<Preset, Failure> {
    if !name.ends_with(".toml") {
        return Ok(Preset::named(name)?);
    }
    let unreadable = |reason: String| Failure::failed(format!("cannot read the preset: {reason}: {name}"));
    let size = std::fs::metadata(Path::new(name)).map_err(|error| unreadable(error.to_string()))?.len();
    if size > LARGEST_PRESET {
        return Err(unreadable(format!("it has {size} bytes, more than {LARGEST_PRESET}")));
    }
    let text = std::fs::read_to_string(name).map_err(|error| unreadable(error.to_string()))?;
    Ok(Preset::from_toml(&text, name)?)
}

/// `N` numbers with commas between them.
fn numbers<const N: usize>(what: &str, form: &str, text: &str) -> Result<[f64; N], Failure> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|field| field.trim().parse::<f64>()).collect();
    parsed
        .ok()
        .and_then(|values| <[f64; N]>::try_from(values).ok())
        .ok_or_else(|| Failure::usage(format!("{what} takes {form}, got {}", himmel::params::shorten(text))))
}

fn wavelength(nm: f64) -> Result<f64, Failure> {
    if (100.0..=100_000.0).contains(&nm) {
        Ok(nm)
    } else {
        Err(Failure::usage(format!("--wavelength-nm must lie in 100..=100000 nm, got {nm}")))
    }
}

fn index(text: &str) -> Result<Index, Failure> {
    let [n, k] = numbers("--index", "N,K for n - ik with k >= 0", text)?;
    Ok(Index::new(n, k)?)
}

/// Prints named numbers as JSON or as lines.
fn print(json: bool, rows: &[(&str, f64)]) -> Result<(), Failure> {
    if json {
        let map: serde_json::Map<String, serde_json::Value> =
            rows.iter().map(|(name, value)| ((*name).to_string(), serde_json::json!(value))).collect();
        out!("{}", serde_json::to_string_pretty(&map).map_err(|error| Failure::failed(error.to_string()))?);
    } else {
        for (name, value) in rows {
            if *value != 0.0 && value.abs() < 1e-3 { out!("{name} = {value:e}") } else { out!("{name} = {value}") }
        }
    }
    Ok(())
}

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    match &args.what {
        What::Mie(args) => mie(args),
        What::Lognormal(args) => lognormal(args),
        What::Component(args) => component(args),
        What::Depth(args) => depth(args),
        What::Plot(args) => plot::run(args, quiet),
    }
}

fn mie(args: &MieArgs) -> Result<(), Failure> {
    let nm = wavelength(args.wavelength_nm)?;
    let size_parameter = 2.0 * std::f64::consts::PI * args.radius_um / (nm / 1000.0);
    let mie = Mie::new(size_parameter, index(&args.index)?)?;
    print(args.json, &[("q_ext", mie.q_ext), ("q_sca", mie.q_sca), ("g", mie.g), ("size_parameter", size_parameter)])
}

fn lognormal(args: &LognormalArgs) -> Result<(), Failure> {
    let nm = wavelength(args.wavelength_nm)?;
    let index = index(&args.index)?;
    let mode = |text: &String| {
        let [radius, deviation, number] =
            numbers("--mode", "RG,SG,N: median radius (um), geometric deviation, number per cm3", text)?;
        Ok(Mode::new(radius, deviation, number)?)
    };
    let modes = args.mode.iter().map(mode).collect::<Result<Vec<_>, Failure>>()?;
    let optics = match args.method.as_str() {
        "harmonic-mean" => lognormal::harmonic_mean(&modes, index, nm, args.albedo, args.g)?,
        _ => lognormal::lorenz_mie(&modes, index, nm, lognormal::FINE)?,
    };
    let albedo = optics.single_scattering_albedo();
    print(
        args.json,
        &[
            ("extinction_m2", optics.extinction_m2),
            ("scattering_m2", optics.scattering_m2),
            ("absorption_m2", (optics.extinction_m2 - optics.scattering_m2).max(0.0)),
            ("single_scattering_albedo", albedo),
            ("g", optics.g),
        ],
    )
}

fn component(args: &ComponentArgs) -> Result<(), Failure> {
    let nm = wavelength(args.wavelength_nm)?;
    let preset = preset(&args.preset)?;
    let medium = &preset.medium;
    let Some(component) = medium.components.iter().find(|component| component.name == args.name) else {
        let names: Vec<&str> = medium.components.iter().map(|component| component.name.as_str()).collect();
        let asked = himmel::params::shorten(&args.name);
        return Err(Failure::usage(format!(
            "{} has no component \"{asked}\"; it has {}",
            args.preset,
            names.join(", ")
        )));
    };
    let (scattering, absorption) = (component.scattering_per_m.at(nm), component.absorption_per_m.at(nm));
    let extinction = scattering + absorption;
    let column = component.profile.column_m(0.0, medium.top_altitude_m);
    let mut rows = vec![
        ("scattering_per_m", scattering),
        ("absorption_per_m", absorption),
        ("extinction_per_m", extinction),
        ("single_scattering_albedo", if extinction > 0.0 { scattering / extinction } else { 1.0 }),
        ("refractivity", component.refractivity.at(nm)),
        ("column_m", column),
        ("vertical_optical_depth", extinction * column),
    ];
    let moments = component.phase.as_ref().map(|phase| phase.legendre_moments(args.moments as usize, nm));
    if let Some(phase) = &component.phase {
        rows.push(("g", phase.mean_cosine(nm)));
    }
    if args.json {
        let mut map: serde_json::Map<String, serde_json::Value> =
            rows.iter().map(|(name, value)| ((*name).to_string(), serde_json::json!(value))).collect();
        map.insert("name".into(), serde_json::json!(component.name));
        map.insert("wavelength_nm".into(), serde_json::json!(nm));
        map.insert("legendre_moments".into(), serde_json::json!(moments));
        out!("{}", serde_json::to_string_pretty(&map).map_err(|error| Failure::failed(error.to_string()))?);
        return Ok(());
    }
    print(false, &rows)?;
    if let Some(moments) = moments {
        let list: Vec<String> = moments.iter().map(|moment| format!("{moment:.6}")).collect();
        out!("legendre_moments = {}", list.join(" "));
    }
    Ok(())
}

fn depth(args: &DepthArgs) -> Result<(), Failure> {
    let preset = preset(&args.preset)?;
    let medium = &preset.medium;
    let mut answers = Vec::new();
    for &nm in &args.wavelength_nm {
        let nm = wavelength(nm)?;
        let mut total = 0.0;
        let species: Vec<(String, f64, f64)> = medium
            .components
            .iter()
            .map(|component| {
                let column = component.profile.column_m(0.0, medium.top_altitude_m) * component.amount;
                let (scattering, absorption) =
                    (component.scattering_per_m.at(nm) * column, component.absorption_per_m.at(nm) * column);
                total += scattering + absorption;
                (component.name.clone(), scattering, absorption)
            })
            .collect();
        answers.push((nm, species, total));
    }
    if args.json {
        let rows: Vec<serde_json::Value> = answers
            .iter()
            .map(|(nm, species, total)| {
                let species: Vec<serde_json::Value> = species
                    .iter()
                    .map(|(name, scattering, absorption)| {
                        serde_json::json!({
                            "name": name,
                            "vertical_optical_depth": scattering + absorption,
                            "scattering": scattering,
                            "absorption": absorption,
                        })
                    })
                    .collect();
                serde_json::json!({ "wavelength_nm": nm, "species": species, "total": total })
            })
            .collect();
        let answer =
            serde_json::json!({ "preset": args.preset, "top_altitude_m": medium.top_altitude_m, "depths": rows });
        out!("{}", serde_json::to_string_pretty(&answer).map_err(|error| Failure::failed(error.to_string()))?);
        return Ok(());
    }
    for (nm, species, total) in answers {
        out!("{nm} nm, from the ground to {} km", medium.top_altitude_m / 1000.0);
        for (name, scattering, absorption) in species {
            out!(
                "  {:12.6e}  {name}  (scattering {scattering:.4e}, absorption {absorption:.4e})",
                scattering + absorption
            );
        }
        out!("  {total:12.6e}  together");
    }
    Ok(())
}
