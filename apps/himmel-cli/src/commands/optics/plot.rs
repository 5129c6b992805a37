//! `himmel optics plot`

use std::path::{Path, PathBuf};

use himmel_air::{Component, Medium};
use plotters::coord::Shift;
use plotters::prelude::*;

use super::{preset, wavelength};
use crate::{Failure, out};

/// Arguments of `himmel optics plot`.
#[derive(clap::Args)]
pub struct Args {
    /// Name of a preset, or a .toml file.
    #[arg(long, default_value = "earth")]
    preset: String,
    /// What to draw.
    #[arg(long, default_value = "density", value_parser = ["density", "coefficients", "phase"])]
    what: String,
    /// Wavelengths of the phase functions, nm; several are allowed.
    #[arg(long, value_name = "L", default_values_t = [440.0, 550.0, 680.0], num_args = 1..)]
    wavelength_nm: Vec<f64>,
    /// Only this component.
    #[arg(long)]
    name: Option<String>,
    /// File to write: .png or .svg.
    #[arg(short, long, value_name = "FILE.{png,svg}")]
    output: PathBuf,
}

/// Size of a plot in pixels.
const SIZE: (u32, u32) = (960, 640);

/// A curve with its name.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
}

/// A picture of curves, before it is drawn.
struct Chart {
    title: String,
    x: String,
    y: String,
    log_x: bool,
    log_y: bool,
    polar: bool,
    curves: Vec<Curve>,
}

/// Runs it.
pub fn run(args: &Args, quiet: bool) -> Result<(), Failure> {
    let preset = preset(&args.preset)?;
    let medium = &preset.medium;
    let components: Vec<&Component> =
        medium.components.iter().filter(|c| args.name.as_ref().is_none_or(|name| *name == c.name)).collect();
    if components.is_empty() {
        let names: Vec<&str> = medium.components.iter().map(|c| c.name.as_str()).collect();
        return Err(Failure::usage(format!("no such component; {} has {}", args.preset, names.join(", "))));
    }
    let chart = match args.what.as_str() {
        "density" => density(&args.preset, medium, &components),
        "coefficients" => coefficients(&args.preset, &components),
        _ => phase(&args.preset, &components, &args.wavelength_nm)?,
    };
    if chart.curves.iter().all(|curve| curve.points.len() < 2) {
        return Err(Failure::failed("there is nothing to draw: the chosen components neither scatter nor absorb"));
    }
    write(&chart, &args.output)?;
    if !quiet {
        out!("{}", args.output.display());
    }
    Ok(())
}

/// Extinction at 550 nm over altitude.
fn density(preset: &str, medium: &Medium, components: &[&Component]) -> Chart {
    let curve = |c: &&Component| {
        let per_m = c.scattering_per_m.at(550.0) + c.absorption_per_m.at(550.0);
        let at = |i: i32| {
            let altitude_m = medium.top_altitude_m * f64::from(i) / 600.0;
            (per_m * c.profile.at(altitude_m) * 1e3, altitude_m / 1e3)
        };
        // Eight decades below the densest matter to no eye.
        let points: Vec<(f64, f64)> = (0..=600).map(at).collect();
        let most = points.iter().map(|p| p.0).fold(0.0, f64::max);
        Curve { name: c.name.clone(), points: points.into_iter().filter(|p| p.0 > 1e-8 * most).collect() }
    };
    Chart {
        title: format!("{preset}: extinction at 550 nm"),
        x: "extinction, 1/km".into(),
        y: "altitude, km".into(),
        log_x: true,
        log_y: false,
        polar: false,
        curves: components.iter().map(curve).collect(),
    }
}

/// Scattering and absorption where the profile is 1, over wavelength.
fn coefficients(preset: &str, components: &[&Component]) -> Chart {
    let mut curves = Vec::new();
    for c in components {
        for (kind, spectrum) in [("scattering", &c.scattering_per_m), ("absorption", &c.absorption_per_m)] {
            let points = (0..=225).map(|i| 380.0 + 2.0 * f64::from(i)).map(|nm| (nm, spectrum.at(nm) * 1e3));
            let points: Vec<(f64, f64)> = points.filter(|p| p.1 > 0.0).collect();
            if points.len() > 1 {
                curves.push(Curve { name: format!("{}: {kind}", c.name), points });
            }
        }
    }
    Chart {
        title: format!("{preset}: coefficients where the profile is 1"),
        x: "wavelength, nm".into(),
        y: "coefficient, 1/km".into(),
        log_x: false,
        log_y: true,
        polar: false,
        curves,
    }
}

/// Phase functions, polar: the radius is log10(4π p) + 3, so that isotropic scattering is a circle of radius 3.
fn phase(preset: &str, components: &[&Component], wavelengths_nm: &[f64]) -> Result<Chart, Failure> {
    let mut curves = Vec::new();
    for &nm in wavelengths_nm {
        let nm = wavelength(nm)?;
        for c in components {
            let Some(phase) = &c.phase else { continue };
            let at = |i: i32| {
                let theta = f64::from(i).to_radians() * 0.5;
                let radius =
                    ((4.0 * std::f64::consts::PI * phase.at(theta.cos(), nm)).max(1e-30).log10() + 3.0).max(0.0);
                (radius * theta.cos(), radius * theta.sin())
            };
            curves.push(Curve { name: format!("{} {nm} nm", c.name), points: (-360..=360).map(at).collect() });
        }
    }
    Ok(Chart {
        title: format!("{preset}: phase functions, log10(4 pi p) + 3; light comes from the left"),
        x: "forward".into(),
        y: "sideways".into(),
        log_x: false,
        log_y: false,
        polar: true,
        curves,
    })
}

fn write(chart: &Chart, path: &Path) -> Result<(), Failure> {
    let failed = |reason: String| Failure::failed(format!("cannot write the plot: {reason}: {}", path.display()));
    // Letters are measured with it in an SVG, too. It fails only for a broken font.
    let _ = plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::HACK_REGULAR);
    match path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => {
            let mut text = String::new();
            draw(chart, &SVGBackend::with_string(&mut text, SIZE).into_drawing_area()).map_err(failed)?;
            std::fs::write(path, text).map_err(|error| failed(error.to_string()))
        }
        Some("png") => {
            let mut pixels = vec![0; (SIZE.0 * SIZE.1 * 3) as usize];
            draw(chart, &BitMapBackend::with_buffer(&mut pixels, SIZE).into_drawing_area()).map_err(failed)?;
            image::save_buffer(path, &pixels, SIZE.0, SIZE.1, image::ColorType::Rgb8)
                .map_err(|error| failed(error.to_string()))
        }
        _ => Err(Failure::usage(format!("a plot is written as .png or .svg, got {}", path.display()))),
    }
}

/// Smallest and largest value of a coordinate, widened so that a constant has an axis.
fn range(chart: &Chart, pick: impl Fn(&(f64, f64)) -> f64, log: bool) -> (f64, f64) {
    let values = chart.curves.iter().flat_map(|curve| &curve.points).map(pick).filter(|v| v.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    match (low.is_finite(), log) {
        (false, _) => (1.0, 10.0),
        (true, true) => (low * 0.8, high * 1.25),
        (true, false) => {
            let margin = 0.03 * (high - low).max(1e-9 * high.abs().max(1e-9));
            (low - margin, high + margin)
        }
    }
}

fn draw<B: DrawingBackend>(chart: &Chart, area: &DrawingArea<B, Shift>) -> Result<(), String> {
    area.fill(&WHITE).map_err(|error| error.to_string())?;
    let (mut x, mut y) = (range(chart, |p| p.0, chart.log_x), range(chart, |p| p.1, chart.log_y));
    if chart.polar {
        // One scale in both directions.
        let half = 0.5 * (x.1 - x.0).max((y.1 - y.0) * 1.6).max(1e-6);
        let (cx, cy) = (0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1));
        (x, y) = ((cx - half, cx + half), (cy - half / 1.6, cy + half / 1.6));
    }
    let mut builder = ChartBuilder::on(area);
    builder.caption(&chart.title, ("sans-serif", 22)).margin(12).x_label_area_size(46).y_label_area_size(86);
    match (chart.log_x, chart.log_y) {
        (true, _) => finish(chart, builder.build_cartesian_2d((x.0..x.1).log_scale(), y.0..y.1)),
        (_, true) => finish(chart, builder.build_cartesian_2d(x.0..x.1, (y.0..y.1).log_scale())),
        _ => finish(chart, builder.build_cartesian_2d(x.0..x.1, y.0..y.1)),
    }?;
    area.present().map_err(|error| error.to_string())
}

type Built<'a, B, X, Y> =
    Result<ChartContext<'a, B, Cartesian2d<X, Y>>, DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

fn finish<'a, B, X, Y>(chart: &Chart, context: Built<'a, B, X, Y>) -> Result<(), String>
where
    B: DrawingBackend + 'a,
    X: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
{
    let mut context = context.map_err(|error| error.to_string())?;
    let label = |value: &f64| match value.abs() {
        size if size != 0.0 && !(0.009..1e5).contains(&size) => format!("{value:.0e}"),
        _ => format!("{:.4}", value).trim_end_matches('0').trim_end_matches('.').to_string(),
    };
    context
        .configure_mesh()
        .x_desc(&chart.x)
        .y_desc(&chart.y)
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .draw()
        .map_err(|error| error.to_string())?;
    for (i, curve) in chart.curves.iter().enumerate() {
        let colour = Palette99::pick(i).to_rgba();
        context
            .draw_series(LineSeries::new(curve.points.iter().copied(), colour.stroke_width(2)))
            .map_err(|error| error.to_string())?
            .label(&curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    context
        .configure_series_labels()
        .position(if chart.polar { SeriesLabelPosition::UpperLeft } else { SeriesLabelPosition::UpperRight })
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()
        .map_err(|error| error.to_string())
}
