//! From sunset to night, a minute at a time: which stars an eye sees, by the sky's own luminance behind each; a sheet of pictures.

use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use himmel::parts::astro::{Catalogue, Instant, Observer, Place, Precise, Star};
use himmel::{Gpu, Output, Scene, SkyModel, Still, limiting_magnitude};

use super::Work;
use super::day::Sheet;

/// Potsdam, a night before new Moon; Vega stands 70° high in the dusk.
const PLACE: [f64; 3] = [52.39, 13.06, 40.0];
const START: i64 = 1_347_729_600; // 2012-09-15T17:20Z, at sunset.
const MINUTES: i64 = 126;
/// Stars lower than this are left out: their air is another.
const LOWEST_DEG: f64 = 30.0;
/// Elevations of the Sun at which pictures are made.
const PICTURES_DEG: [f64; 8] = [-2.0, -4.0, -6.0, -8.0, -10.0, -12.0, -15.0, -18.0];
/// Pixels of each.
const SIZE: (u32, u32) = (360, 270);

/// A star, and where the Sun stood when it was first seen.
struct Watched<'a> {
    star: &'a Star,
    seen_at_deg: Option<f64>,
    altitude_deg: f64,
}

fn model_at(minute: i64) -> Result<SkyModel, String> {
    let mut scene = Scene::default();
    let time = jiff::Timestamp::from_second(START + 60 * minute).map_err(|error| error.to_string())?.to_string();
    let place = PLACE.map(|value| value.to_string()).join(",");
    for (key, value) in [
        ("observer.place", place.as_str()),
        ("clock.time", &time),
        ("camera.look", "vega"),
        ("camera.fov_deg", "20"),
        ("output.tonemap", "eye"),
        ("output.width_px", &SIZE.0.to_string()),
        ("output.height_px", &SIZE.1.to_string()),
    ] {
        scene.set(key, value).map_err(|error| error.to_string())?;
    }
    SkyModel::new(&scene).map_err(|error| error.to_string())
}

/// How many magnitudes the air takes from a star.
fn extinction(model: &SkyModel, star: &Star, sine: f64) -> f64 {
    let air = model.atmosphere();
    let four = air.starlight().of_black_body(star.temperature_k().unwrap_or(0.0), 1.0);
    let through = air.sun_transmittance(model.altitude_m(), sine);
    -2.5 * air.xyz(std::array::from_fn(|k| four[k] * through[k])).y.log10()
}

fn luminance(model: &SkyModel, direction: DVec3) -> Result<f64, String> {
    let rgb = model.luminance(direction).map_err(|error| error.to_string())?;
    Ok(rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722)))
}

/// The table; `folder`: where the pictures go.
pub fn table(work: Work, folder: Option<&Path>) -> Result<String, String> {
    let failed = |error: &dyn std::fmt::Display| error.to_string();
    let ephemeris = Precise::embedded().map_err(|error| failed(&error))?;
    let place = Place::from_degrees(PLACE[0], PLACE[1], PLACE[2]).map_err(|error| failed(&error))?;
    let catalogue = Catalogue::embedded();
    let vega = catalogue.find("vega").map_err(|error| failed(&error))?;
    let mut watched: Vec<Watched<'_>> = (catalogue.stars().iter())
        .filter(|star| star.v_magnitude < 6.0)
        .map(|star| Watched { star, seen_at_deg: None, altitude_deg: 0.0 })
        .collect();
    let mut model = model_at(0)?;
    let mut behind = String::from("| Sun | sky at Vega, cd/m² | limit there | zenith, cd/m² |\n|---|---|---|---|\n");
    let mut next = 0;
    let mut frames = Vec::new();
    for minute in (0..MINUTES).step_by(if work.quick { 10 } else { 1 }) {
        let time = jiff::Timestamp::from_second(START + 60 * minute).map_err(|error| failed(&error))?;
        model.clock_mut().set(time);
        let sun_deg = model.sun().map_err(|error| failed(&error))?.airless_altitude_deg;
        let instant = Instant::from_unix_seconds(model.clock().unix_seconds()).map_err(|error| failed(&error))?;
        let observer = Observer::new(&ephemeris, &instant, &place).map_err(|error| failed(&error))?;
        // No part of the sky above 30° is ten times darker than the zenith.
        let hopeless = limiting_magnitude(0.1 * luminance(&model, DVec3::Z)?);
        for of in watched.iter_mut().filter(|of| of.seen_at_deg.is_none() && of.star.v_magnitude < hopeless) {
            let direction = observer.apparent_star(of.star).direction_enu;
            let altitude_deg = direction.z.clamp(-1.0, 1.0).asin().to_degrees();
            if altitude_deg < LOWEST_DEG {
                continue;
            }
            let limit = limiting_magnitude(luminance(&model, direction)?);
            if of.star.v_magnitude + extinction(&model, of.star, direction.z) <= limit {
                (of.seen_at_deg, of.altitude_deg) = (Some(sun_deg), altitude_deg);
            }
        }
        if PICTURES_DEG.get(next).is_some_and(|&wanted| sun_deg <= wanted) {
            let at_vega = luminance(&model, observer.apparent_star(vega).direction_enu)?;
            let zenith = luminance(&model, DVec3::Z)?;
            let _ = writeln!(
                behind,
                "| {sun_deg:.1}° | {at_vega:.3e} | {:.1} | {zenith:.3e} |",
                limiting_magnitude(at_vega)
            );
            frames.push(minute);
            next += 1;
        }
    }
    let mut text =
        String::from("| V | stars | first seen with the Sun at | half of them | all |\n|---|---|---|---|---|\n");
    let first = watched.iter().find(|of| std::ptr::eq(of.star, vega));
    if let Some(Watched { seen_at_deg: Some(sun_deg), altitude_deg, .. }) = first {
        let _ = writeln!(text, "| Vega, {altitude_deg:.0}° high | 1 | {sun_deg:.1}° | | |");
    }
    for magnitude in 0..=5i32 {
        let own = watched.iter().filter(|of| (of.star.v_magnitude - f64::from(magnitude)).abs() <= 0.5);
        // Of those that rose high enough.
        let mut seen: Vec<f64> = own.filter_map(|of| of.seen_at_deg).collect();
        seen.sort_by(|a, b| b.total_cmp(a));
        let (Some(first), Some(last)) = (seen.first(), seen.last()) else { continue };
        let _ = writeln!(
            text,
            "| {:.1} to {:.1} | {} | {first:.1}° | {:.1}° | {last:.1}° |",
            f64::from(magnitude) - 0.5,
            f64::from(magnitude) + 0.5,
            seen.len(),
            seen[seen.len() / 2]
        );
    }
    let _ = writeln!(text, "\n{behind}");
    if let Some(folder) = folder {
        draw(&mut model, &frames, &folder.join("dusk-stars.jpg"))?;
    }
    Ok(text)
}

/// Pictures at some minutes, side by side.
fn draw(model: &mut SkyModel, minutes: &[i64], path: &Path) -> Result<(), String> {
    let failed = |error: &dyn std::fmt::Display| error.to_string();
    let gpu = Gpu::open(None).map_err(|error| failed(&error))?;
    let mut still = Still::new(&gpu, Output::Display, model.atmosphere()).map_err(|error| failed(&error))?;
    let mut sheet = Sheet::new(4, 2, SIZE);
    for minute in minutes {
        let time = jiff::Timestamp::from_second(START + 60 * minute).map_err(|error| failed(&error))?;
        model.clock_mut().set(time);
        let (frame, view) = (model.frame(), model.view());
        let (frame, view) = (frame.map_err(|error| failed(&error))?, view.map_err(|error| failed(&error))?);
        sheet.add(&still.render(&frame, &view, SIZE.0, SIZE.1, &mut |_| true).map_err(|error| failed(&error))?);
    }
    sheet.save(path)
}
