//! Whole pictures against the f64 twin: tables, march, ground, colour matrix, cameras.

use std::collections::HashMap;

use himmel::{Output, Pixels, SkyModel, Still};
use himmel_tests::{Settings, gpu, model};

/// Renders a scene's picture and compares each pixel's luminance with the model's. Returns relative errors, sorted. `still`: of the
/// scene's atmosphere.
fn errors(still: &mut Still, model: &SkyModel) -> Vec<f64> {
    let size = &model.scene().output;
    let (width, height) = (size.width_px, size.height_px);
    let view = model.view().unwrap();
    let picture = still.render(&model.frame().unwrap(), &view, width, height, &mut |_| true).unwrap();
    let Pixels::Radiance(rgb) = &picture.pixels else { panic!("radiance was asked for") };
    let luminance = |c: [f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    let radius_m = model.atmosphere().medium().bottom_radius_m;
    let horizon = himmel::parts::air::geometry::horizon_cosine(radius_m, model.altitude_m()).asin();
    let pixel = (model.scene().camera.fov_deg / f64::from(height)).to_radians();
    let mut errors = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let ndc = [
                2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0,
                1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(height),
            ];
            let Some(direction) = view.direction(ndc) else { continue };
            // On the horizon the picture mixes ground and sky over a pixel; the model does not.
            if (direction.z.asin() - horizon).abs() < pixel {
                continue;
            }
            let i = 3 * (y * width + x) as usize;
            let ours = luminance([rgb[i], rgb[i + 1], rgb[i + 2]].map(f64::from));
            let twin = luminance(model.luminance(direction).unwrap().to_array());
            let error = (ours - twin).abs() / twin.abs().max(1e-3);
            errors.push(if error.is_nan() { f64::INFINITY } else { error });
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

/// Every scene: 99 % of all pixels within 1 %, half within 0.2 %. Nothing but f32 and the tables' interpolation lies
/// between the two.
#[test]
fn pictures_are_those_of_the_model() {
    let size =
        [("output.width_px", "48"), ("output.height_px", "27"), ("output.exposure", "none"), ("light.sun.disc", "off")];
    let scenes: [(&str, &str, Settings); 9] = [
        ("noon", "earth", &[("clock.time", "2012-09-06T11:00Z"), ("camera.look", "N,20")]),
        ("sunward", "earth", &[("clock.time", "2012-09-06T16:00Z"), ("camera.look", "sun")]),
        ("twilight", "earth", &[("light.sun.altitude_deg", "-4"), ("camera.look", "sunward")]),
        (
            "belt of Venus",
            "bruneton2017",
            &[("light.sun.altitude_deg", "-2"), ("light.sun.azimuth_deg", "270"), ("camera.look", "90,10")],
        ),
        ("haze", "earth-haze", &[("light.sun.altitude_deg", "20"), ("camera.look", "sunward")]),
        (
            "mountain",
            "earth",
            &[("observer.altitude_m", "5000"), ("camera.look", "S,-5"), ("light.sun.altitude_deg", "30")],
        ),
        (
            "orbit",
            "earth",
            &[("observer.altitude_m", "400000"), ("camera.look", "W,-20"), ("light.sun.altitude_deg", "10")],
        ),
        ("mars", "mars-reference", &[("light.sun.altitude_deg", "5"), ("camera.look", "sunward")]),
        (
            "all sky",
            "earth",
            &[
                ("camera.look", "zenith"),
                ("camera.projection", "fisheye"),
                ("camera.fov_deg", "180"),
                ("light.sun.altitude_deg", "40"),
            ],
        ),
    ];
    let mut bad = Vec::new();
    // Tables of this quality take long: scenes with the same air share them.
    let mut stills: HashMap<&str, Still> = HashMap::new();
    for (name, preset, settings) in scenes {
        // Every pixel marches, as the twin does.
        let film = [("air.quality", "film")];
        // Seen from space the night is there by day: night.rs and stars.rs compare it.
        let night =
            ["stars", "planets", "airglow", "zodiacal", "milky_way"].map(|name| format!("night.{name}.enabled"));
        let no_night = night.iter().map(|name| (name.as_str(), "off"));
        let all: Vec<(&str, &str)> = size.iter().chain(&film).chain(settings).copied().chain(no_night).collect();
        let model = model(preset, &all);
        let still =
            stills.entry(preset).or_insert_with(|| Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap());
        let errors = errors(still, &model);
        let (median, p99) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
        println!("{name}: median {median:.1e}, 99 % {p99:.1e}, worst {:.1e}", errors[errors.len() - 1]);
        if !(median < 2e-3 && p99 < 1e-2) {
            bad.push(format!("{name}: median {median:e}, 99 % {p99:e}"));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

/// A picture in tiles, and its parts drawn alone, are the same pixels.
#[test]
fn tiles_leave_no_seam() {
    // Marched: the tiles of the table's pipelines follow the part that is drawn.
    let settings = [("output.exposure", "8"), ("camera.look", "sunward"), ("air.quality", "film")];
    let model = model("earth", &settings);
    let view = model.view().unwrap();
    let frame = model.frame().unwrap();
    let mut still = Still::new(gpu(), Output::Display, model.atmosphere()).unwrap();
    let whole = still.render(&frame, &view, 2050, 16, &mut |_| true).unwrap();
    let right = himmel::View { part: [1025.0 / 2050.0, 0.0, 0.5, 1.0], first_pixel: [1025, 0], ..view };
    let half = still.render(&frame, &right, 1025, 16, &mut |_| true).unwrap();
    let (Pixels::Display(a), Pixels::Display(b)) = (&whole.pixels, &half.pixels) else {
        panic!("display was asked for")
    };
    let mut different = 0;
    for y in 0..16 {
        for x in 0..1025 * 3 {
            different += usize::from(a[y * 2050 * 3 + 1025 * 3 + x].abs_diff(b[y * 1025 * 3 + x]) > 1);
        }
    }
    // Interpolated coordinates differ in the last bit; dithering may turn that into one step of 255.
    assert_eq!(different, 0);
}
