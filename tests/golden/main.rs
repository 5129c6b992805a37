//! Goldens: pictures that must not change unnoticed. Radiance as EXR by relative error, looks as PNG by FLIP.
//! `cargo xtask golden propose`, `review`, `accept`.

use himmel::{Output, Pixels, Still};
use himmel_golden::{FlipTolerance, GoldenError, GoldenSet, Tolerance};
use himmel_tests::{gpu, model};

const SIZE: [(&str, &str); 2] = [("output.width_px", "256"), ("output.height_px", "144")];

fn pixels(preset: &str, settings: &[(&str, &str)], output: Output) -> Pixels {
    let all: Vec<(&str, &str)> = SIZE.iter().chain(settings).copied().collect();
    let model = model(preset, &all);
    let mut still = Still::new(gpu(), output, model.atmosphere()).expect("a renderer");
    let frame = model.frame().expect("a frame");
    still.render(&frame, &model.view().expect("a view"), 256, 144, &mut |_| true).expect("a picture").pixels
}

/// Radiance in cd/m²; the Sun's disc is left out, since half floats end at 65,504.
fn radiance(name: &str, preset: &str, settings: &[(&str, &str)]) -> Result<(), GoldenError> {
    // Points have goldens of their own.
    let mut all = vec![("output.exposure", "none"), ("light.sun.disc", "off")];
    all.extend([("night.stars.enabled", "off"), ("night.planets.enabled", "off"), ("body.moon.enabled", "off")]);
    all.extend(settings);
    let Pixels::Radiance(rgb) = pixels(preset, &all, Output::Radiance) else { unreachable!("radiance was asked for") };
    println!("{}", GoldenSet::of_workspace()?.check_exr(name, 256, 144, &rgb, Tolerance::default())?);
    Ok(())
}

fn look(name: &str, preset: &str, settings: &[(&str, &str)]) -> Result<(), GoldenError> {
    let Pixels::Display(rgb) = pixels(preset, settings, Output::Display) else { unreachable!("display was asked for") };
    println!("{}", GoldenSet::of_workspace()?.check_png(name, 256, 144, &rgb, FlipTolerance::default())?);
    Ok(())
}

#[test]
fn twilight() -> Result<(), GoldenError> {
    radiance("twilight", "earth", &[])
}

#[test]
fn noon() -> Result<(), GoldenError> {
    radiance("noon", "earth", &[("clock.time", "2012-09-06T11:00Z"), ("camera.look", "E,20")])
}

#[test]
fn orbit() -> Result<(), GoldenError> {
    radiance(
        "orbit",
        "earth",
        &[("observer.altitude_m", "400000"), ("camera.look", "W,-18"), ("light.sun.altitude_deg", "8")],
    )
}

#[test]
fn mars() -> Result<(), GoldenError> {
    radiance("mars", "mars-reference", &[("light.sun.altitude_deg", "4"), ("camera.look", "sunward")])
}

/// Orion and Sirius, in cd/m²: places, colours, extinction.
#[test]
fn stars() -> Result<(), GoldenError> {
    let place = [("observer.place", "52.39,13.06"), ("clock.time", "2012-01-20T22:00Z"), ("camera.look", "180,30")];
    radiance(
        "stars",
        "earth",
        &[&place[..], &[("night.stars.enabled", "on"), ("night.planets.enabled", "on")]].concat(),
    )
}

/// Saturn fills a telescope.
#[test]
fn saturn() -> Result<(), GoldenError> {
    let place = [("observer.place", "Paranal"), ("clock.time", "2012-04-16T05:00Z"), ("camera.look", "saturn")];
    let camera = [("camera.fov_deg", "0.02"), ("output.exposure", "8"), ("night.planets.enabled", "on")];
    look("saturn", "earth", &[&place[..], &camera[..]].concat())
}

/// In the umbra of 2024-04-08: twilight all round.
#[test]
fn eclipse() -> Result<(), GoldenError> {
    let place = [("observer.place", "Mazatlan"), ("clock.time", "2024-04-08T18:09:30Z")];
    let camera = [("camera.look", "180,25"), ("camera.fov_deg", "100"), ("light.sun.disc", "on")];
    radiance("eclipse", "earth", &[&place[..], &camera[..]].concat())
}

/// A partial eclipse of the Moon: albedo, limb, penumbra, umbra, reddened by the air.
#[test]
fn moon() -> Result<(), GoldenError> {
    let place = [("observer.place", "Potsdam"), ("clock.time", "2023-10-28T20:14Z"), ("body.moon.enabled", "on")];
    radiance("moon", "earth", &[&place[..], &[("camera.look", "moon"), ("camera.fov_deg", "0.8")]].concat())
}

#[test]
fn look_of_sunset() -> Result<(), GoldenError> {
    look(
        "look-sunset",
        "earth",
        &[("clock.time", "2012-09-06T17:20Z"), ("camera.look", "sun"), ("camera.fov_deg", "20")],
    )
}

#[test]
fn look_of_all_sky() -> Result<(), GoldenError> {
    let camera = [("camera.look", "zenith"), ("camera.projection", "fisheye"), ("camera.fov_deg", "180")];
    look(
        "look-all-sky",
        "earth",
        &[&camera[..], &[("light.sun.altitude_deg", "20"), ("output.tonemap", "agx")]].concat(),
    )
}
