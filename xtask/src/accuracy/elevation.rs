//! The error over the Sun's elevation, as a plot.

use std::path::Path;

use himmel::Gpu;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontStyle;

use super::Choice;
use super::class::Class;
use super::moments::{Point, Solvers, noise, percent, spread};

const SIZE: (u32, u32) = (960, 600);

/// Degrees; crowded where light changes fastest.
const ELEVATIONS_DEG: [i32; 24] =
    [60, 45, 30, 20, 15, 10, 7, 5, 3, 2, 1, 0, -1, -2, -3, -4, -5, -6, -7, -8, -10, -12, -15, -18];

/// An observer on the ground, lines of sight over the whole sky.
fn class(elevation_deg: i32, choice: &Choice) -> Class {
    let zenith_deg = f64::from(90 - elevation_deg);
    Class {
        key: format!("elevation{elevation_deg:+03}"),
        name: format!("{elevation_deg}°"),
        preset: "bruneton2017",
        sun_deg: (zenith_deg, zenith_deg),
        view_deg: (0.0, 89.5),
        altitude_m: (0.0, 0.0),
        error: match elevation_deg {
            -2.. => 0.2,
            -6.. => 0.5,
            _ => 1.5,
        },
        most_samples: choice.work.count(1 << 18),
        seed: 2000 + (elevation_deg + 90) as u64,
    }
}

struct Curve {
    name: &'static str,
    colour: RGBColor,
    /// Elevation, median and 95th percentile in %.
    points: Vec<(f64, f64, f64)>,
}

/// Prints the numbers and writes them as a plot.
pub fn plot(choice: &Choice, gpu: &Gpu, output: Option<&str>) -> Result<(), String> {
    let curve = |name, colour| Curve { name, colour, points: Vec::new() };
    let mut curves = [
        curve("Himmel on the GPU", RGBColor(0, 90, 200)),
        curve("Hillaire 2020, converged", RGBColor(235, 140, 0)),
        curve("Hillaire 2020, usual sizes", RGBColor(200, 30, 30)),
        curve("the tracer's standard error", RGBColor(150, 150, 150)),
    ];
    let mut solvers = Solvers::default();
    println!("Adapter: {}.\n", gpu.report());
    println!(
        "| Sun | reference ± | ours on the GPU | Hillaire 2020, converged | Hillaire 2020, usual sizes |\n|---|---|---|---|---|"
    );
    for elevation_deg in ELEVATIONS_DEG {
        let points = solvers.points(&class(elevation_deg, choice), choice, Some(gpu))?;
        let of = |of: &dyn Fn(&Point) -> [f64; 3]| spread(&points, of);
        let found =
            [of(&|point| point.ours), of(&|point| point.usual_converged), of(&|point| point.usual), noise(&points)];
        let say = |(median, most): (f64, f64)| format!("{} / {}", percent(median), percent(most));
        println!(
            "| {elevation_deg}° | {} | {} | {} | {} |",
            say(found[3]),
            say(found[0]),
            say(found[1]),
            say(found[2])
        );
        for (curve, (median, most)) in curves.iter_mut().zip(found) {
            curve.points.push((f64::from(elevation_deg), 100.0 * median, 100.0 * most));
        }
        // After each, so that a run that is stopped leaves what it has.
        if let Some(path) = output {
            let mut text = String::new();
            draw(&curves, &SVGBackend::with_string(&mut text, SIZE).into_drawing_area())?;
            std::fs::write(Path::new(path), text).map_err(|error| format!("cannot write {path}: {error}"))?;
        }
    }
    println!(
        "\nMedian / 95th percentile of the relative error in %: `bruneton2017`, on the ground, {} lines of sight over the whole sky for each elevation, at 680, 550 and 440 nm.",
        choice.points
    );
    Ok(())
}

fn draw(curves: &[Curve], area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), String> {
    // Letters are measured with it. It fails only for a broken font.
    let _ = plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::HACK_REGULAR);
    let failed = |error: DrawingAreaErrorKind<_>| -> String { format!("{error}") };
    area.fill(&WHITE).map_err(failed)?;
    let mut chart = ChartBuilder::on(area)
        .caption("Error of the clear sky's radiance: median (line), 95th percentile (dashes)", ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(70)
        .build_cartesian_2d(-62.0..19.0, (0.02..400.0).log_scale())
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc("elevation of the Sun, degrees")
        .y_desc("relative error, %")
        .x_labels(18)
        // Plotted from day to night.
        .x_label_formatter(&|x: &f64| format!("{:.0}", -x))
        .y_label_formatter(&|y: &f64| format!("{y}"))
        .light_line_style(BLACK.mix(0.06))
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 16))
        .draw()
        .map_err(failed)?;
    for curve in curves {
        let style = curve.colour.stroke_width(2);
        let line = |pick: fn(&(f64, f64, f64)) -> f64| {
            curve.points.iter().map(move |point| (-point.0, pick(point).clamp(0.02, 400.0)))
        };
        chart
            .draw_series(LineSeries::new(line(|point| point.1), style))
            .map_err(failed)?
            .label(curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        chart.draw_series(DashedLineSeries::new(line(|point| point.2), 5, 4, style)).map_err(failed)?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()
        .map_err(failed)?;
    area.present().map_err(failed)
}
