//! One day in 96 frames at a fixed place: illuminance against a published fit, zenith luminance, exposure; a plot and pictures.

use std::fmt::Write as _;
use std::path::Path;

use himmel::parts::gpu::FrameState;
use himmel::{Gpu, Output, Picture, Pixels, Projection, Scene, SkyModel, Still, View, picture};
use plotters::prelude::*;

use super::Work;

/// Mazatlán: the Sun climbs to 66° and sinks to −68°; the full Moon of 2022-03-18, 07:18 UTC, without an eclipse, at midnight.
const PLACE: &str = "23.2494,-106.4111,10";
const START: i64 = 1_647_541_800; // 2022-03-17T18:30Z, shortly before noon.
const FRAMES: i64 = 96;
const STEP_S: i64 = 900;
/// Illuminance of the full Moon above the air.
const FULL_MOON_LX: f64 = 0.32;
/// Below this our air alone says nothing: a natural night has 6e-4 lx.
const NIGHT_LX: f64 = 3e-5;

/// Clear air; air whose daylight is the published one's; thick haze.
const PRESETS: [&str; 3] = ["earth", "earth-klupiec", "earth-haze"];

/// Light at one instant.
struct Frame {
    hours: f64,
    sun_deg: f64,
    moon_deg: f64,
    /// Of the Moon above the air, lx.
    moon_above_lx: f64,
    sun_lx: f64,
    moon_lx: f64,
    /// From both and from the night's glow, lx.
    all_lx: f64,
    zenith_cd_m2: f64,
}

/// A value of a frame, where it has one.
type Quantity = dyn Fn(&Frame) -> Option<f64>;

/// lg of the horizontal illuminance of a clear sky, lx: cubics in altitude / 90° [seidelmann1992, table 1.84].
fn published(altitude_deg: f64, moon: bool) -> Option<f64> {
    let c = match (moon, altitude_deg) {
        (false, 20.0..=90.0) => [3.74, 3.97, -4.07, 1.47],
        (false, 5.0..20.0) => [3.05, 13.28, -45.98, 64.33],
        (false, -0.8..5.0) => [2.88, 22.26, -207.64, 1034.30],
        (false, -5.0..-0.8) => [2.88, 21.81, -258.11, -858.36],
        (false, -12.0..-5.0) => [2.70, 12.17, -431.69, -1899.83],
        (false, -18.0..-12.0) => [13.84, 262.72, 1447.42, 2797.93],
        (true, 20.0..=90.0) => [-1.95, 4.06, -4.24, 1.56],
        (true, 5.0..20.0) => [-2.58, 12.58, -42.58, 59.06],
        (true, -0.8..5.0) => [-2.79, 24.27, -252.95, 1321.29],
        _ => return None,
    };
    let x = altitude_deg / 90.0;
    Some(c[0] + x * (c[1] + x * (c[2] + x * c[3])))
}

fn model_at(preset: &str, moon: bool) -> Result<SkyModel, String> {
    let mut scene = Scene { preset: preset.into(), ..Scene::default() };
    let time = jiff::Timestamp::from_second(START).map_err(|error| error.to_string())?.to_string();
    let moon = if moon { "on" } else { "off" };
    let settings =
        [("observer.place", PLACE), ("clock.time", &time), ("output.tonemap", "eye"), ("body.moon.enabled", moon)];
    for (key, value) in settings {
        scene.set(key, value).map_err(|error| error.to_string())?;
    }
    SkyModel::new(&scene).map_err(|error| error.to_string())
}

/// All frames.
fn day(preset: &str, work: Work) -> Result<Vec<Frame>, String> {
    let (mut dark, mut moonlit) = (model_at(preset, false)?, model_at(preset, true)?);
    let mut frames = Vec::new();
    for index in (0..=FRAMES).step_by(if work.quick { 4 } else { 1 }) {
        let failed = |error: himmel::Error| error.to_string();
        let now = jiff::Timestamp::from_second(START + index * STEP_S).map_err(|error| error.to_string())?;
        dark.clock_mut().set(now);
        moonlit.clock_mut().set(now);
        let [without, with] = [dark.light().map_err(failed)?, moonlit.light().map_err(failed)?];
        let moon = moonlit.moon().map_err(failed)?.ok_or("the Moon is missing")?;
        frames.push(Frame {
            hours: (index * STEP_S) as f64 / 3600.0,
            sun_deg: dark.sun().map_err(failed)?.airless_altitude_deg,
            moon_deg: moon.airless_altitude_deg,
            moon_above_lx: moon.illuminance_lx,
            sun_lx: without.horizontal_illuminance_lx(),
            moon_lx: with.horizontal_illuminance_lx() - without.horizontal_illuminance_lx(),
            all_lx: with.horizontal_illuminance_lx(),
            zenith_cd_m2: with.zenith_luminance_cd_m2,
        });
    }
    Ok(frames)
}

/// The table; the plot goes beside the output file.
pub fn table(work: Work, folder: Option<&Path>) -> Result<String, String> {
    let mut text = String::from(
        "| preset | Sun or Moon | frames | largest \\|difference\\| | mean difference | must |\n|---|---|---|---|---|---|\n",
    );
    let mut last = String::new();
    for preset in PRESETS {
        let frames = day(preset, work)?;
        let mut row = |name: &str, must: &str, differences: Vec<f64>| {
            let count = differences.len();
            let worst = differences.iter().fold(0.0, |worst: f64, d| worst.max(d.abs()));
            let mean = differences.iter().sum::<f64>() / (count as f64).max(1.0);
            let _ = writeln!(text, "| {preset} | {name} | {count} | {worst:.3} dex | {mean:+.3} dex | {must} |");
        };
        let sun = |from: f64, to: f64| -> Vec<f64> {
            let within = frames.iter().filter(|f| (from..to).contains(&f.sun_deg));
            within.filter_map(|f| Some(f.sun_lx.log10() - published(f.sun_deg, false)?)).collect()
        };
        row("Sun above 5°", "0.15", sun(5.0, 90.0));
        row("Sun from −6° to 5°", "0.3", sun(-6.0, 5.0));
        row("Sun from −12° to −6°", "0.4", sun(-12.0, -6.0));
        let lunar = frames.iter().filter(|f| f.moon_deg > 5.0 && f.sun_deg < -12.0);
        let lunar = lunar
            .filter_map(|f| Some((f.moon_lx * FULL_MOON_LX / f.moon_above_lx).log10() - published(f.moon_deg, true)?));
        row("full Moon above 5°, brought to 0.32 lx above the air", "0.15", lunar.collect());
        let step = |value: fn(&Frame) -> f64| {
            let pairs = frames.windows(2).filter(|pair| pair[0].sun_deg.max(pair[1].sun_deg) < -18.0);
            pairs.map(|pair| (value(&pair[1]) / value(&pair[0])).log10().abs()).fold(0.0, f64::max)
        };
        let brightest = frames.iter().filter(|f| f.sun_deg < -18.0).map(|f| f.moon_above_lx).fold(0.0, f64::max);
        let _ = writeln!(
            last,
            "\n`{preset}`: the Moon has {brightest:.3} lx above the air at its best; between neighbouring frames of the night \
             the light on level ground changes by at most {:.3} dex, the zenith by {:.3}.",
            step(|f| f.all_lx),
            step(|f| f.zenith_cd_m2)
        );
        if let Some(folder) = folder {
            let name = if preset == PRESETS[0] { "day.svg".into() } else { format!("day-{preset}.svg") };
            std::fs::write(folder.join(&name), plot(preset, &frames)?).map_err(|error| error.to_string())?;
            let _ = writeln!(last, "\n![illuminance, zenith luminance and differences, {preset}]({name})");
        }
    }
    Ok(text + &last)
}

fn plot(preset: &str, frames: &[Frame]) -> Result<String, String> {
    fn failed(error: impl std::fmt::Display) -> String {
        error.to_string()
    }
    // Letters are measured with it. It fails only for a broken font.
    let _ = plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::HACK_REGULAR);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (960, 760)).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let (upper, lower) = root.split_vertically(500);
        let mut chart = ChartBuilder::on(&upper)
            .caption(format!("A day and a night of full Moon, Mazatlán, 2022-03-17, {preset}"), ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(80)
            .build_cartesian_2d(0.0..24.0, (NIGHT_LX..3e5).log_scale())
            .map_err(failed)?;
        chart
            .configure_mesh()
            .x_desc("hours after 18:30 UTC")
            .y_desc("lx, cd/m²")
            .y_label_formatter(&|value| format!("{value:.0e}"))
            .draw()
            .map_err(failed)?;
        let curves: [(&str, &Quantity); 5] = [
            ("level surface, Sun", &|f| Some(f.sun_lx)),
            ("level surface, Moon", &|f| Some(f.moon_lx)),
            ("zenith, cd/m²", &|f| Some(f.zenith_cd_m2)),
            ("published, Sun", &|f| Some(10f64.powf(published(f.sun_deg, false)?))),
            ("published, Moon", &|f| {
                let share = f.moon_above_lx / FULL_MOON_LX;
                Some(share * 10f64.powf(published(f.moon_deg, true).filter(|_| f.moon_deg > -0.8)?))
            }),
        ];
        for (i, (name, value)) in curves.into_iter().enumerate() {
            let colour = Palette99::pick(if i < 3 { i } else { i - 3 }).to_rgba();
            // Curves run along the bottom where there is no light.
            let shown = |v: f64| if i < 3 { Some(v.max(NIGHT_LX)) } else { Some(v).filter(|v| *v > NIGHT_LX) };
            let points: Vec<(f64, f64)> = frames.iter().filter_map(|f| Some((f.hours, shown(value(f)?)?))).collect();
            if i < 3 {
                chart
                    .draw_series(LineSeries::new(points, colour.stroke_width(2)))
                    .map_err(failed)?
                    .label(name)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
            } else {
                chart
                    .draw_series(points.into_iter().map(|point| Circle::new(point, 3, colour)))
                    .map_err(failed)?
                    .label(name)
                    .legend(move |(x, y)| Circle::new((x + 9, y), 3, colour));
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperMiddle)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()
            .map_err(failed)?;
        let mut chart = ChartBuilder::on(&lower)
            .caption("ours over published", ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(80)
            .build_cartesian_2d(-18.0..90.0, -0.6..0.6)
            .map_err(failed)?;
        chart.configure_mesh().x_desc("altitude, °").y_desc("dex").draw().map_err(failed)?;
        for (i, moon) in [false, true].into_iter().enumerate() {
            let colour = Palette99::pick(i).to_rgba();
            let points = frames.iter().filter_map(|f| {
                let (altitude, ours) = match moon {
                    true if f.sun_deg > -12.0 => return None,
                    true => (f.moon_deg, f.moon_lx * FULL_MOON_LX / f.moon_above_lx),
                    // Deeper, starlight and airglow are most of it.
                    false if f.sun_deg < -14.0 => return None,
                    false => (f.sun_deg, f.sun_lx),
                };
                Some((altitude, ours.log10() - published(altitude, moon)?))
            });
            chart
                .draw_series(points.map(|point| Circle::new(point, 3, colour)))
                .map_err(failed)?
                .label(if moon { "Moon" } else { "Sun" })
                .legend(move |(x, y)| Circle::new((x + 9, y), 3, colour));
        }
        for limits in [[(5.0, 0.15), (90.0, 0.15)], [(-6.0, 0.3), (5.0, 0.3)], [(-12.0, 0.4), (-6.0, 0.4)]] {
            for sign in [1.0, -1.0] {
                let line = limits.map(|(x, y)| (x, sign * y));
                chart.draw_series(LineSeries::new(line, BLACK.mix(0.5))).map_err(failed)?;
            }
        }
        chart.configure_series_labels().background_style(WHITE.mix(0.8)).draw().map_err(failed)?;
        root.present().map_err(failed)?;
    }
    Ok(text)
}

fn frame_of(model: &SkyModel) -> Result<FrameState, String> {
    model.frame().map_err(|error| error.to_string())
}

/// Pictures: 24 frames of the day as fisheyes, each at its own exposure, as an eye sees them; and a night with and without
/// the Moon, photopic and as an eye has it.
pub fn pictures(folder: &Path) -> Result<String, String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    const SIDE: u32 = 220;
    let failed = |error: &dyn std::fmt::Display| error.to_string();
    let gpu = Gpu::open(None).map_err(|error| failed(&error))?;
    let mut text = String::from("| hours | Sun | EV100 | mean of the picture, 0–255 |\n|---|---|---|---|\n");
    let view = View::with_projection(
        std::f64::consts::PI,
        std::f64::consts::FRAC_PI_2,
        Projection::Fisheye(std::f64::consts::PI),
        1.0,
    );
    let first = model_at("earth", true)?;
    let mut still = Still::new(&gpu, Output::Display, first.atmosphere()).map_err(|error| failed(&error))?;
    let mut draw = |frame: &FrameState, view: &View, size: (u32, u32)| {
        still.render(frame, view, size.0, size.1, &mut |_| true).map_err(|error| failed(&error))
    };
    let mut sheet = Sheet::new(8, 3, (SIDE, SIDE));
    let mut model = first;
    for index in 0..24 {
        let now = jiff::Timestamp::from_second(START + 4 * index * STEP_S);
        model.clock_mut().set(now.map_err(|error| failed(&error))?);
        let shown = draw(&frame_of(&model)?, &view, (SIDE, SIDE))?;
        let mean = sheet.add(&shown);
        let sun_deg = model.sun().map_err(|error| failed(&error))?.airless_altitude_deg;
        let _ = writeln!(text, "| {index} | {sun_deg:.1}° | {:.2} | {mean:.0} |", shown.ev100);
    }
    sheet.save(&folder.join("day.jpg"))?;
    // The night: 2022-03-18T06:30Z, the Moon high in the south.
    let mut sheet = Sheet::new(3, 2, (480, 270));
    let now = jiff::Timestamp::from_second(START + 48 * STEP_S);
    model.clock_mut().set(now.map_err(|error| failed(&error))?);
    let mut moonless = model_at("earth", false)?;
    moonless.clock_mut().set(model.clock().now());
    let view = View::looking(2.6, 0.35, 1.2, 16.0 / 9.0);
    for tonemap in [himmel::Tonemap::AgxPunchy, himmel::Tonemap::Eye, himmel::Tonemap::EyeBlue] {
        let mut frame = frame_of(&model)?;
        frame.output.tonemap = tonemap;
        sheet.add(&draw(&frame, &view, (480, 270))?);
    }
    for tonemap in [himmel::Tonemap::AgxPunchy, himmel::Tonemap::Eye, himmel::Tonemap::EyeBlue] {
        let mut frame = frame_of(&moonless)?;
        frame.output.tonemap = tonemap;
        sheet.add(&draw(&frame, &view, (480, 270))?);
    }
    sheet.save(&folder.join("night.jpg"))?;
    Ok(text)
}

/// Pictures side by side.
pub(super) struct Sheet {
    columns: u32,
    size: (u32, u32),
    count: u32,
    width: u32,
    rgb: Vec<u8>,
}

impl Sheet {
    pub(super) fn new(columns: u32, rows: u32, size: (u32, u32)) -> Self {
        let width = columns * size.0;
        Self { columns, size, count: 0, width, rgb: vec![0; (3 * width * rows * size.1) as usize] }
    }

    /// Puts a picture into the next place; returns its mean.
    pub(super) fn add(&mut self, shown: &Picture) -> f64 {
        let Pixels::Display(bytes) = &shown.pixels else { return 0.0 };
        let (x, y) = (self.count % self.columns * self.size.0, self.count / self.columns * self.size.1);
        for (row, line) in bytes.chunks_exact(3 * self.size.0 as usize).enumerate() {
            let start = 3 * ((y as usize + row) * self.width as usize + x as usize);
            self.rgb[start..start + line.len()].copy_from_slice(line);
        }
        self.count += 1;
        bytes.iter().map(|byte| f64::from(*byte)).sum::<f64>() / bytes.len() as f64
    }

    pub(super) fn save(self, path: &Path) -> Result<(), String> {
        let height = (self.rgb.len() / 3) as u32 / self.width;
        let sheet = Picture {
            width: self.width,
            height,
            pixels: Pixels::Display(self.rgb),
            exposure: 1.0,
            ev100: 0.0,
            times: Default::default(),
        };
        picture::save(&sheet, path).map_err(|error| error.to_string())
    }
}
