//! The glow of the night: pixels against the f64 model.

use himmel::{Output, Pixels, SkyModel, Still};
use himmel_tests::{gpu, model};

const NIGHT: [(&str, &str); 2] = [("observer.place", "-24.6272,-70.4042,2635"), ("clock.time", "2012-07-18T04:00Z")];

/// Relative errors of a picture's luminance, sorted.
fn errors(model: &SkyModel) -> Vec<f64> {
    let size = &model.scene().output;
    let (width, height) = (size.width_px, size.height_px);
    let (view, frame) = (model.view().unwrap(), model.frame().unwrap());
    let mut still = Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap();
    let picture = still.render(&frame, &view, width, height, &mut |_| true).unwrap();
    let Pixels::Radiance(rgb) = &picture.pixels else { panic!("radiance was asked for") };
    let luminance = |c: [f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    let (air, altitude_m) = (model.atmosphere(), model.altitude_m());
    let horizon = himmel::parts::air::geometry::horizon_cosine(air.medium().bottom_radius_m, altitude_m).asin();
    let pixel = (model.scene().camera.fov_deg / f64::from(height)).to_radians();
    let night = frame.night.expect("it is night");
    let mut errors = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let ndc = [
                2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0,
                1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(height),
            ];
            let Some(direction) = view.direction(ndc) else { continue };
            // There pixels mix ground and sky.
            if (direction.z.asin() - horizon).abs() < 2.0 * pixel {
                continue;
            }
            let twin = air.rec709(night.parts(air, altitude_m, direction, 0).sum());
            let at = 3 * (y * width + x) as usize;
            let ours = luminance([0, 1, 2].map(|c| f64::from(rgb[at + c])));
            errors.push((ours / luminance(twin.to_array()) - 1.0).abs());
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

/// Half floats of the zodiacal table and texels of nine bits hold 1e-3; sums of many more agree better. Where the star map is drawn
/// pixels are no larger than its texels, so that both read its finest level.
#[test]
fn the_night_is_that_of_the_model() {
    let off = ("night.milky_way.enabled", "off");
    let city = ("night.light_pollution.bortle", "8");
    let scenes: [(&str, &[(&str, &str)]); 8] = [
        ("heart of the Milky Way", &[("camera.look", "170,80"), ("camera.fov_deg", "4")]),
        ("Magellanic Clouds, low", &[("camera.look", "185,17"), ("camera.fov_deg", "4")]),
        ("all around", &[off, ("camera.look", "280,20"), ("camera.fov_deg", "80")]),
        ("a city", &[off, city, ("camera.look", "90,30"), ("camera.fov_deg", "80")]),
        ("the ground", &[off, ("camera.look", "0,-30"), ("camera.fov_deg", "40")]),
        (
            "limb from orbit",
            &[off, ("observer.altitude_m", "400000"), ("camera.look", "0,-18"), ("camera.fov_deg", "10")],
        ),
        (
            "within the layer",
            &[off, ("observer.altitude_m", "90000"), ("camera.look", "0,0"), ("camera.fov_deg", "60")],
        ),
        ("marching", &[off, ("air.quality", "film"), ("camera.look", "0,45"), ("camera.fov_deg", "80")]),
    ];
    let mut bad = Vec::new();
    for (name, settings) in scenes {
        let size = [("output.width_px", "64"), ("output.height_px", "48"), ("output.exposure", "none")];
        // The model knows no points of light.
        let glow = [("night.stars.enabled", "off"), ("night.planets.enabled", "off")];
        let settings: Vec<_> = NIGHT.iter().chain(&glow).chain(&size).chain(settings).copied().collect();
        let errors = errors(&model("earth", &settings));
        let (median, p99) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
        println!("{name}: median {median:.1e}, 99 % {p99:.1e}, worst {:.1e}", errors[errors.len() - 1]);
        if !(median < 1e-3 && p99 < 5e-3) {
            bad.push(format!("{name}: median {median:e}, 99 % {p99:e}"));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

/// By day the pipelines know nothing of it.
#[test]
fn by_day_there_is_no_night() {
    let at = |altitude: &'static str| model("earth", &[("light.sun.altitude_deg", altitude)]).frame().unwrap().night;
    assert!(at("10").is_none() && at("-2").is_none() && at("-4").is_some());
}

/// A light is drawn alike whichever of a frame's lights it is: full Moons light the sky as Suns do.
#[test]
fn a_second_light_is_drawn_as_the_first() {
    let off = [("night.stars.enabled", "off"), ("night.planets.enabled", "off"), ("body.moon.enabled", "off")];
    let settings = [("light.sun.altitude_deg", "20"), ("output.width_px", "96"), ("output.height_px", "54")];
    let model = model("earth", &[&off[..], &settings, &[("output.exposure", "none")]].concat());
    let (view, frame) = (model.view().unwrap(), model.frame().unwrap());
    let mut still = Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap();
    let mut draw = |frame| {
        let picture = still.render(frame, &view, 96, 54, &mut |_| true).unwrap();
        let Pixels::Radiance(rgb) = picture.pixels else { panic!("radiance was asked for") };
        rgb
    };
    let first = draw(&frame);
    let mut second = frame.clone();
    second.other_suns = vec![frame.sun];
    second.sun.irradiance = [0.0; 4];
    second.sun.direction.z *= -1.0;
    second.sun.disc_direction = second.sun.direction;
    let second = draw(&second);
    let worst = first.iter().zip(&second).map(|(a, b)| (b / a - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-4, "{worst}");
}

/// The grid of frames in real time against pixels that evaluate the glow, below a sky and above a horizon, with a Moon before it.
#[test]
fn the_grid_interpolates_the_glow() {
    let off = [("night.stars.enabled", "off"), ("night.planets.enabled", "off")];
    let size = [("output.width_px", "320"), ("output.height_px", "180"), ("output.exposure", "none")];
    for (name, settings, worst) in [
        (
            "zodiacal light",
            &[("night.milky_way.enabled", "off"), ("camera.look", "280,20"), ("camera.fov_deg", "60")][..],
            2e-3,
        ),
        // Texels of 0.09° are averaged over the grid's spacing.
        ("heart of the Milky Way", &[("camera.look", "170,80"), ("camera.fov_deg", "60")], 0.2),
        ("the Moon", &[("clock.time", "2012-07-25T02:00Z"), ("camera.look", "moon"), ("camera.fov_deg", "10")], 2e-2),
    ] {
        let model = model("earth", &[&NIGHT[..], &off, &size, settings].concat());
        let (view, frame) = (model.view().unwrap(), model.frame().unwrap());
        let mut still = Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap();
        let mut draw = |grid| {
            still.renderer().set_night_grid(grid);
            let Pixels::Radiance(rgb) = still.render(&frame, &view, 320, 180, &mut |_| true).unwrap().pixels else {
                panic!("radiance was asked for")
            };
            rgb
        };
        let (pixels, grid) = (draw(false), draw(true));
        let mut errors: Vec<f32> = pixels.iter().zip(&grid).skip(1).step_by(3).map(|(a, b)| b / a - 1.0).collect();
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        errors.iter_mut().for_each(|error| *error = error.abs());
        errors.sort_by(f32::total_cmp);
        let (median, p99) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
        println!(
            "{name}: mean {mean:.1e}, median {median:.1e}, 99 % {p99:.1e}, worst {:.1e}",
            errors[errors.len() - 1]
        );
        assert!(grid != pixels, "{name} has no grid");
        assert!(mean.abs() < 2e-3 && p99 < worst, "{name}: {mean} {p99}");
    }
}
