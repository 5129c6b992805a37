//! `cargo xtask pictures`: the pictures of `docs/pictures.md`, ours and the tracer's side by side at one exposure.

mod sheets;

use std::path::{Path, PathBuf};

use himmel::picture::render;
use himmel::{Exposure, Gpu, Output, OutputParams, Pixels, ReferencePicture, Scene, SkyModel};
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{self, FilterType};
use image::{ExtendedColorType, ImageEncoder, Rgb, RgbImage};

use sheets::{BANDS, SHEETS, Sheet};

pub const USAGE: &str = "cargo xtask pictures [NAME…] [--output FOLDER] [--kept FOLDER] [--noise PERCENT]
    names: strip, orbit-traced, mars-noon, mars-sunset, titan, titan-reference, haze, eclipse, moon, moon-relief,
           moon-2010, moon-2022, moon-2023, body-giant, body-setting, body-moonlet; all of them without a name
    --output  where the JPEGs go (docs/images)
    --kept    where the tracer's samples are kept (target/pictures): a run that was stopped goes on where it was
    --noise   trace until half of the pixels have this standard error (6), or 1,024 paths";

/// Between tiles, pixels.
const GAP: u32 = 2;
/// Bytes of a picture in the documentation, at most.
const MOST_BYTES: usize = 200_000;
/// Most passes of 32 paths.
const MOST_PASSES: u64 = 32;
const LEAST_PASSES: u64 = 2;

pub fn run(args: &[String]) -> Result<(), String> {
    let (mut output, mut kept) = (PathBuf::from("docs/images"), PathBuf::from("target/pictures"));
    let (mut names, mut noise) = (Vec::new(), 0.06);
    let mut words = args.iter();
    while let Some(word) = words.next() {
        let mut next = |takes: &str| words.next().cloned().ok_or_else(|| format!("{word} takes {takes}"));
        match word.as_str() {
            "--output" => output = next("a folder")?.into(),
            "--kept" => kept = next("a folder")?.into(),
            "--noise" => {
                let number = next("a number")?;
                let sensible = number.parse::<f64>().ok().filter(|percent| (0.01..=100.0).contains(percent));
                noise = sensible.ok_or(format!("--noise must lie in 0.01..=100 %, got {number}"))? / 100.0;
            }
            name if !name.starts_with('-') => names.push(name.to_owned()),
            other => return Err(format!("what is \"{other}\"?\n{USAGE}")),
        }
    }
    let unknown = names.iter().find(|name| SHEETS.iter().all(|sheet| sheet.name != **name));
    if let Some(name) = unknown {
        return Err(format!("no picture \"{name}\"\n{USAGE}"));
    }
    for folder in [&output, &kept] {
        std::fs::create_dir_all(folder).map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    }
    let gpu = Gpu::open(None).map_err(|error| error.to_string())?;
    println!(
        "Adapter: {}.\n\n| picture | tile | EV100 | paths | noise | ours against the tracer |\n|---|---|---|---|---|---|",
        gpu.report()
    );
    for sheet in SHEETS.iter().filter(|sheet| names.is_empty() || names.iter().any(|name| name == sheet.name)) {
        let picture = draw(sheet, &gpu, &kept, noise)?;
        save(&picture, &output.join(format!("{}.jpg", sheet.name)))?;
    }
    Ok(())
}

/// All tiles of a sheet: ours above the tracer's, or left of it where there is one pair.
fn draw(sheet: &Sheet, gpu: &Gpu, kept: &Path, noise: f64) -> Result<RgbImage, String> {
    let [width, height] = sheet.size;
    let rows = if sheet.traced.is_some() { 2 } else { 1 };
    let columns = sheet.tiles.len() as u32;
    let [across, down] = if columns == 1 { [rows, 1] } else { [columns, rows] };
    let whole = [(width + GAP) * across - GAP, (height + GAP) * down - GAP];
    let mut picture = RgbImage::from_pixel(whole[0], whole[1], Rgb([255; 3]));
    for (column, (label, settings)) in sheet.tiles.iter().enumerate() {
        let model = model(sheet, settings, 1, kept)?;
        let ours = render(gpu, &model, Output::Display, &mut |_| true).map_err(|error| error.to_string())?;
        let place = |row: u32| if columns == 1 { [row, 0] } else { [column as u32, row] };
        put(&mut picture, &ours.pixels, sheet.size, place(0));
        let mut line = format!("| {} | {label} | {:.2} |", sheet.name, ours.ev100);
        if let Some(smaller) = sheet.traced {
            let model = self::model(sheet, settings, smaller, kept)?;
            let name = format!("{}{}{label}", sheet.name, if label.is_empty() { "" } else { " " });
            let traced = trace(&model, &kept.join(format!("{name}.samples")), &name, noise)?;
            // What is metered already has its compensation.
            let output = OutputParams {
                exposure: Some(Exposure::Ev100(ours.ev100)),
                compensation_ev: 0.0,
                ..model.scene().output.clone()
            };
            let small = traced.picture(&output, Output::Display).pixels;
            put(
                &mut picture,
                &enlarged(&small, sheet.size.map(|side| side / smaller), sheet.size),
                sheet.size,
                place(1),
            );
            let noise = traced.noise().map_or(f64::NAN, |noise| 100.0 * noise.median);
            line += &format!(" {} | {noise:.1} % | {} |", traced.paths_per_pixel(), difference(&model, gpu, &traced)?);
        } else {
            line += " | | |";
        }
        println!("{line}");
    }
    Ok(picture)
}

/// Nothing shines but the Sun.
const NO_NIGHT: [(&str, &str); 6] = [
    ("body.moon.enabled", "off"),
    ("night.stars.enabled", "off"),
    ("night.planets.enabled", "off"),
    ("night.airglow.enabled", "off"),
    ("night.zodiacal.enabled", "off"),
    ("night.milky_way.enabled", "off"),
];

fn model(sheet: &Sheet, settings: &[(&str, &str)], smaller: u32, kept: &Path) -> Result<SkyModel, String> {
    let [width, height] = sheet.size.map(|side| (side / smaller).to_string());
    let size = [("output.width_px", width.as_str()), ("output.height_px", height.as_str())];
    let mut scene = Scene { preset: sheet.preset.into(), ..Scene::default() };
    // The tracer knows the air and the Sun alone.
    let dark = sheet.traced.map_or(&[][..], |_| &NO_NIGHT);
    for (key, value) in sheet.common.iter().chain(settings).chain(&size).chain(dark) {
        let value = if *value == BANDS { bands(kept)? } else { (*value).to_string() };
        scene.set(key, &value).map_err(|error| error.to_string())?;
    }
    SkyModel::new(&scene).map_err(|error| error.to_string())
}

/// A map of a giant's bands: sums of waves over latitude, bent by waves over longitude. Returns its path.
fn bands(folder: &Path) -> Result<String, String> {
    const HEIGHT: u32 = 1024;
    let mut map = RgbImage::new(2 * HEIGHT, HEIGHT);
    for (x, y, pixel) in map.enumerate_pixels_mut() {
        let longitude = f64::from(x) / f64::from(HEIGHT) * std::f64::consts::PI;
        let latitude = 90.0 - 180.0 * (f64::from(y) + 0.5) / f64::from(HEIGHT);
        let waves = 1.2 * (9.0 * longitude + latitude / 7.0).sin() + 0.5 * (23.0 * longitude - latitude / 3.0).sin();
        let bent = latitude + waves * (-(latitude / 45.0).powi(2)).exp();
        let light = 0.5 + 0.5 * (0.33 * bent).sin() * (0.11 * bent + 1.0).cos() + 0.08 * (1.1 * bent).sin();
        let (dark, bright) = ([0.50, 0.38, 0.27], [0.86, 0.80, 0.70]);
        *pixel = Rgb([0, 1, 2].map(|k| {
            let albedo: f64 = dark[k] + (bright[k] - dark[k]) * light.clamp(0.0, 1.0);
            // sRGB, whose linear foot is far below.
            ((1.055 * albedo.powf(1.0 / 2.4) - 0.055) * 255.0).round() as u8
        }));
    }
    let path = folder.join("bands.png");
    map.save(&path).map_err(|error| error.to_string())?;
    Ok(path.display().to_string())
}

/// The tracer's picture, from what is kept of it on.
fn trace(model: &SkyModel, file: &Path, name: &str, noise: f64) -> Result<ReferencePicture, String> {
    let mut traced = ReferencePicture::new(model, 1).map_err(|error| error.to_string())?;
    if let Ok(state) = std::fs::read(file)
        && let Err(error) = traced.resume(&state)
    {
        eprintln!("{name}: traced anew: {error}");
    }
    let enough = |traced: &ReferencePicture| {
        traced.passes() >= MOST_PASSES
            || traced.passes() >= LEAST_PASSES && traced.noise().is_some_and(|found| found.median <= noise)
    };
    while !enough(&traced) {
        traced.add_pass(&mut |_| true).map_err(|error| error.to_string())?;
        himmel::picture::save_bytes(&traced.state(), file).map_err(|error| error.to_string())?;
        let found = traced.noise().map_or(f64::NAN, |noise| 100.0 * noise.median);
        eprint!("\r{name}: {} paths per pixel, noise {found:.1} % ", traced.paths_per_pixel());
    }
    eprintln!();
    Ok(traced)
}

/// Median luminance of ours over the tracer's, pixel by pixel without those about the Sun's disc, and the ratio of the sums
/// of R, G, B.
fn difference(model: &SkyModel, gpu: &Gpu, traced: &ReferencePicture) -> Result<String, String> {
    let mut scene = model.scene().clone();
    scene.output.exposure = Some(Exposure::None);
    let model = SkyModel::new(&scene).map_err(|error| error.to_string())?;
    let ours = render(gpu, &model, Output::Radiance, &mut |_| true).map_err(|error| error.to_string())?;
    let Pixels::Radiance(ours) = ours.pixels else { return Ok(String::new()) };
    let theirs = traced.rgb_cd_m2();
    let luminance = |rgb: [f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let (view, sun) =
        (model.view().map_err(|error| error.to_string())?, model.frame().map_err(|error| error.to_string())?.sun);
    let (width, height) = traced.size();
    // Discs are smoothed over a pixel in other ways.
    let pixel_rad = scene.camera.fov_deg.to_radians() / f64::from(height);
    let far = |index: usize| {
        let (x, y) = ((index as u32 % width) as f64 + 0.5, (index as u32 / width) as f64 + 0.5);
        let direction = view.direction([2.0 * x / f64::from(width) - 1.0, 1.0 - 2.0 * y / f64::from(height)]);
        direction
            .is_some_and(|direction| direction.angle_between(sun.disc_direction) > sun.radius_rad + 2.0 * pixel_rad)
    };
    let mut pairs: Vec<(f64, [f64; 3], [f64; 3])> = ours
        .chunks_exact(3)
        .zip(&theirs)
        .enumerate()
        .filter(|(index, _)| far(*index))
        .map(|(_, (a, b))| ([0, 1, 2].map(|k| f64::from(a[k])), b.to_array()))
        .filter(|(_, b)| luminance(*b) > 0.0)
        .map(|(a, b)| (luminance(a) / luminance(b), a, b))
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = pairs.get(pairs.len() / 2).map_or(f64::NAN, |pair| pair.0);
    let sum = |k: usize| pairs.iter().map(|p| p.1[k]).sum::<f64>() / pairs.iter().map(|p| p.2[k]).sum::<f64>();
    Ok(format!(
        "{:+.1} %, sums of RGB {:+.1}, {:+.1}, {:+.1} %",
        100.0 * (median - 1.0),
        100.0 * (sum(0) - 1.0),
        100.0 * (sum(1) - 1.0),
        100.0 * (sum(2) - 1.0)
    ))
}

fn enlarged(pixels: &Pixels, from: [u32; 2], to: [u32; 2]) -> Pixels {
    let Pixels::Display(rgb) = pixels else { return Pixels::Display(Vec::new()) };
    let small = RgbImage::from_raw(from[0], from[1], rgb.clone()).unwrap_or_default();
    Pixels::Display(imageops::resize(&small, to[0], to[1], FilterType::CatmullRom).into_raw())
}

/// Copies a tile to its column and row.
fn put(picture: &mut RgbImage, pixels: &Pixels, [width, height]: [u32; 2], [column, row]: [u32; 2]) {
    let Pixels::Display(rgb) = pixels else { return };
    let [left, top] = [column * (width + GAP), row * (height + GAP)];
    for (i, pixel) in rgb.chunks_exact(3).enumerate().take((width * height) as usize) {
        let (x, y) = (i as u32 % width, i as u32 / width);
        picture.put_pixel(left + x, top + y, Rgb([pixel[0], pixel[1], pixel[2]]));
    }
}

/// As good a JPEG as fits.
fn save(picture: &RgbImage, path: &Path) -> Result<(), String> {
    let mut bytes = Vec::new();
    for quality in [94, 90, 85, 80, 70, 60, 50] {
        bytes.clear();
        JpegEncoder::new_with_quality(&mut bytes, quality)
            .write_image(picture, picture.width(), picture.height(), ExtendedColorType::Rgb8)
            .map_err(|error| error.to_string())?;
        if bytes.len() <= MOST_BYTES {
            break;
        }
    }
    himmel::picture::save_bytes(&bytes, path).map_err(|error| error.to_string())
}
