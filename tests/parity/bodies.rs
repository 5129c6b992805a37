//! Other bodies in the sky: the same light as where one stands above them, and nothing else changes.

use std::sync::Arc;

use himmel::glam::{DMat3, DMat4, DVec3};
use himmel::parts::air::{AirParams, AirQuality, Atmosphere, GroundParams};
use himmel::parts::gpu::{FarBody, FarLight, FrameState, SunState};
use himmel::{AlbedoMap, Exposure, Output, OutputParams, Pixels, Preset, Scene, SkyModel, Still, View};
use himmel_tests::{gpu, model};

fn atmosphere(preset: &str, enabled: bool) -> Atmosphere {
    let air = AirParams { enabled, quality: Some(AirQuality::Low), ..AirParams::default() };
    Atmosphere::new(&Preset::named(preset).unwrap(), &air, &GroundParams::default())
}

fn sun(direction: DVec3) -> SunState {
    SunState {
        direction,
        disc_direction: direction,
        radius_rad: 0.0047,
        irradiance: [1.0; 4],
        disc: false,
        limb_darkening: true,
    }
}

fn state(direction: DVec3, altitude_m: f64) -> FrameState {
    let output = OutputParams { exposure: Some(Exposure::None), ..OutputParams::default() };
    FrameState::new(sun(direction), altitude_m, output)
}

/// Luminance of every pixel.
fn draw(still: &mut Still, frame: &FrameState, view: &View, width: u32, height: u32) -> Vec<f64> {
    let picture = still.render(frame, view, width, height, &mut |_| true).unwrap();
    let Pixels::Radiance(rgb) = picture.pixels else { panic!("radiance was asked for") };
    rgb.chunks_exact(3)
        .map(|c| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]))
        .collect()
}

fn body_of(air: &Atmosphere, centre_m: DVec3, to_sun: DVec3) -> FarBody {
    let light = FarLight { direction: to_sun, irradiance: [1.0; 4] };
    FarBody {
        albedo: air.sampled().ground_albedo,
        air: Some(0),
        ..FarBody::even(centre_m, air.medium().bottom_radius_m, 0.0, light)
    }
}

/// A planet seen from above it, and the same planet as another body above the ground of an airless one, upside down. Half of the lit
/// pixels are within 0.5 %. Limbs, and crescents that are all limb, are drawn from 34 points a pixel: 99 % of all pixels are within
/// a few per cent of themselves (or of a sixth of the brightest), here 1 in 21. Where a pixel is wider than the air, what one sees from above is drawn
/// finer and averaged: the sky's own limb is smoothed between two rays only.
#[test]
fn a_body_is_what_one_sees_from_above_it() {
    // Half a turn about the east: what was below is above.
    let turn = DMat3::from_rotation_x(std::f64::consts::PI);
    let (width, height) = (64, 48);
    let mut bad = Vec::new();
    for preset in ["mars", "earth"] {
        let (air, bare) = (Arc::new(atmosphere(preset, true)), atmosphere(preset, false));
        let mut home = Still::new(gpu(), Output::Radiance, &air).unwrap();
        let mut away = Still::new(gpu(), Output::Radiance, &bare).unwrap();
        away.renderer().set_far_airs(&[Arc::clone(&air)]).unwrap();
        let radius_m = air.medium().bottom_radius_m;
        for (altitude_m, dip_deg, fov_deg, finer) in [
            (120e3, 60.0, 60.0, 1),
            (120e3, 12.0, 14.0, 4),
            (1e6, 90.0, 110.0, 8),
            (10.0 * radius_m, 90.0, 13.0, 8),
            (300.0 * radius_m, 90.0, 0.45, 16),
        ] {
            for sun_deg in [70.0f64, 0.0, -20.0] {
                let elevation = sun_deg.to_radians();
                let to_sun = DVec3::new(0.3 * elevation.cos(), 0.954 * elevation.cos(), elevation.sin()).normalize();
                let below = View::looking(0.3, -f64::to_radians(dip_deg), f64::to_radians(fov_deg), 4.0 / 3.0);
                let above = View { enu_from_view: DMat4::from_mat3(turn) * below.enu_from_view, ..below };
                let body = body_of(&air, DVec3::Z * (radius_m + altitude_m), turn * to_sun);
                let frame = FrameState { far_bodies: vec![body], ..state(turn * to_sun, 2.0) };
                let (w, h) = (width * finer, height * finer);
                let fine = draw(&mut home, &state(to_sun, altitude_m), &below, w, h);
                let mut theirs = vec![0.0; (width * height) as usize];
                for (i, luminance) in (0u32..).zip(&fine) {
                    let pixel = i / w / finer * width + i % w / finer;
                    theirs[pixel as usize] += luminance / f64::from(finer * finer);
                }
                let ours = draw(&mut away, &frame, &above, width, height);
                let most = theirs.iter().copied().fold(0.0, f64::max);
                let pairs = || ours.iter().zip(&theirs);
                let lit = pairs().filter(|(_, b)| **b > 0.01 * most).map(|(a, b)| (a - b).abs() / b);
                let all = pairs().map(|(a, b)| (a - b).abs() / b.max(most / 6.0));
                let at = |errors: &mut dyn Iterator<Item = f64>, share: f64| {
                    let mut errors: Vec<f64> = errors.collect();
                    errors.sort_by(f64::total_cmp);
                    errors.get((share * errors.len() as f64) as usize).copied().unwrap_or(f64::NAN)
                };
                let (p50, p99) = (at(&mut lit.clone(), 0.5), at(&mut all.clone(), 0.99));
                let (count, worst) = (lit.count(), all.fold(0.0, f64::max));
                println!(
                    "{preset} {:.0} km, {dip_deg}°, Sun {sun_deg}°: {count} lit, {most:.2e} cd/m², median {p50:.1e}, 99 % {p99:.1e}, worst {worst:.1e}",
                    altitude_m / 1e3
                );
                let few = 1.0 / 21.0;
                let half = if sun_deg < -10.0 { few } else { 5e-3 };
                if !(p50 < half && p99 < few && most > 0.0 && count > 20) {
                    bad.push(format!("{preset} {altitude_m} {dip_deg} {sun_deg}: {p50} {p99}"));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

/// As many candela from a disc of three pixels, of less than one, and of three hundred, in the mean over nine places on the pixels'
/// grid: in one place the points of a small disc err by up to 4 %.
#[test]
fn small_discs_keep_their_light() {
    let (air, bare) = (Arc::new(atmosphere("mars", true)), atmosphere("mars", false));
    let mut still = Still::new(gpu(), Output::Radiance, &bare).unwrap();
    still.renderer().set_far_airs(&[Arc::clone(&air)]).unwrap();
    let direction = DVec3::new(0.0, 1.0, 0.7).normalize();
    let to_sun = DVec3::new(0.8, -0.5, 0.4).normalize();
    let radius_m = air.medium().bottom_radius_m;
    let body = body_of(&air, direction * radius_m / 0.01, to_sun);
    let frame = FrameState { far_bodies: vec![body], ..state(DVec3::new(0.0, 0.0, -1.0), 2.0) };
    let mut light = |rows: u32, fov_deg: f64, aside: [f64; 2]| {
        let step = 2.0 * (0.5 * fov_deg.to_radians()).tan() / f64::from(rows);
        let view = View::looking(aside[0] * step, direction.z.asin() + aside[1] * step, fov_deg.to_radians(), 1.0);
        let pixels = draw(&mut still, &frame, &view, rows, rows);
        let solid = |i: usize| {
            let place = |k: u32| (f64::from(k) + 0.5 - 0.5 * f64::from(rows)) * step;
            (1.0 + place(i as u32 % rows).powi(2) + place(i as u32 / rows).powi(2)).powf(-1.5) * step * step
        };
        pixels.iter().enumerate().map(|(i, luminance)| luminance * solid(i)).sum::<f64>()
    };
    let large = light(300, 1.3, [0.0; 2]);
    for (rows, fov_deg) in [(60, 4.0), (60, 12.0), (60, 25.0), (61, 40.0), (40, 90.0)] {
        let places = (0..9).map(|i| [f64::from(i % 3) / 3.0, f64::from(i / 3) / 3.0]);
        let ratio = places.map(|aside| light(rows, fov_deg, aside)).sum::<f64>() / 9.0 / large;
        println!("{:.1} pixels: {ratio:.4}", 0.02f64.to_degrees() / fov_deg * f64::from(rows));
        assert!((ratio - 1.0).abs() < 0.02, "{fov_deg}°: {ratio}");
    }
}

/// The home planet's picture and tables, to the last bit, with and without a body that is out of sight.
#[test]
fn airs_do_not_disturb_each_other() {
    let settings = [("air.quality", "low"), ("light.sun.altitude_deg", "15"), ("output.exposure", "12")];
    let model = model("earth", &settings);
    let view = model.view().unwrap();
    let bytes = |still: &mut Still, frame: &FrameState| match still
        .render(frame, &view, 160, 90, &mut |_| true)
        .unwrap()
        .pixels
    {
        Pixels::Display(bytes) => bytes,
        Pixels::Radiance(_) => panic!("display was asked for"),
    };
    let frame = model.frame().unwrap();
    let mut still = Still::new(gpu(), Output::Display, model.atmosphere()).unwrap();
    let alone = bytes(&mut still, &frame);
    let tables = still.renderer().save_tables().unwrap().wait().unwrap();
    let memory = still.renderer().table_bytes();
    let [mars, earth] = ["mars", "earth-haze"].map(|preset| Arc::new(atmosphere(preset, true)));
    still.renderer().set_far_airs(&[Arc::clone(&mars), Arc::clone(&earth)]).unwrap();
    assert!(still.renderer().rebuilding().is_some() && still.renderer().table_bytes() > memory);
    let behind = -view.direction([0.0, 0.0]).unwrap() * 1e8;
    let hidden = FrameState { far_bodies: vec![body_of(&mars, behind, DVec3::Z)], ..frame.clone() };
    assert_eq!(bytes(&mut still, &hidden), alone);
    assert_eq!(still.renderer().save_tables().unwrap().wait().unwrap(), tables);
    // Those of the other bodies: as if each were alone, saved and loaded, kept where the list grows and shrinks.
    let saved = still.renderer().save_far_tables(1).unwrap().wait().unwrap();
    let mut own = Still::new(gpu(), Output::Display, &earth).unwrap();
    own.build(&mut |_| true).unwrap();
    let theirs = own.renderer().save_tables().unwrap();
    assert_eq!(theirs.key(), still.renderer().far_tables_key(1).unwrap());
    assert_eq!(theirs.wait().unwrap(), saved);
    still.renderer().set_far_airs(&[Arc::clone(&mars)]).unwrap();
    assert!(still.renderer().rebuilding().is_none());
    still.renderer().set_far_airs(&[mars, earth]).unwrap();
    assert!(still.renderer().rebuilding().is_some());
    assert!(
        still.renderer().load_far_tables(0, &saved).is_err() && still.renderer().load_far_tables(2, &saved).is_err()
    );
    still.renderer().load_far_tables(1, &saved).unwrap();
    assert!(still.renderer().rebuilding().is_none());
    still.renderer().set_far_airs(&[]).unwrap();
    assert_eq!(bytes(&mut still, &frame), alone);
    // What is left is room for two stations more and the white map.
    assert!(still.renderer().table_bytes() < memory + 200_000);
}

/// Some hundred scenes: cameras on the ground, in the air, in space, in the air of a body; bodies before, behind, under each other.
#[test]
fn no_pixel_of_any_scene_is_not_finite() {
    let home = atmosphere("earth", true);
    let airs = ["moonlet", "mars"].map(|preset| Arc::new(atmosphere(preset, true)));
    let mut still = Still::new(gpu(), Output::Radiance, &home).unwrap();
    still.renderer().set_far_airs(&airs).unwrap();
    let mut seed = 7u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let texels = (0..32 * 16).map(|i| [(i % 256) as u8, 200, 90, 255]).collect();
    let map = Arc::new(AlbedoMap::new(32, 16, texels).unwrap());
    let mut seen = 0;
    for _ in 0..250 {
        let mut unit = || DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5).normalize_or(DVec3::Z);
        let (to_sun, turn, look) = (unit(), unit(), unit());
        let (azimuth, dip) = (look.x.atan2(look.y), look.z.asin());
        let altitude_m = [2.0, 3e4, 4e5, 4e7][(4.0 * random()) as usize];
        let view = View::looking(azimuth, dip, 0.02 + 2.0 * random(), 16.0 / 9.0);
        let far_bodies: Vec<FarBody> = (0..3)
            .map(|i| {
                let air = (i < 2).then_some(i);
                let radius_m = air.map_or(1e6, |air| airs[air].medium().bottom_radius_m);
                let aside = DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5);
                let distance_m = radius_m * (1.0 + 10f64.powf(6.0 * random() - 4.0));
                FarBody {
                    map: (i != 1).then(|| Arc::clone(&map)),
                    air,
                    body_from_enu: DMat3::from_axis_angle(turn, 3.0),
                    ..FarBody::even(
                        (look + aside * random()).normalize_or(DVec3::X) * distance_m,
                        radius_m,
                        0.4,
                        FarLight { direction: to_sun, irradiance: [1.0; 4] },
                    )
                }
            })
            .collect();
        let frame = FrameState { far_bodies, ..state(to_sun, altitude_m) };
        let pixels = draw(&mut still, &frame, &view, 32, 18);
        seen += pixels.iter().filter(|&&luminance| luminance > 1.0).count();
        let wrong =
            pixels.iter().position(|luminance| !(luminance.is_finite() && *luminance > -1.0 && *luminance < 1e6));
        assert!(wrong.is_none(), "{:?} of {frame:?} {view:?}", wrong.map(|at| (at, pixels[at])));
    }
    assert!(seen > 10_000, "{seen} lit pixels");
}

/// Errors that say what to do.
#[test]
fn scenes_with_bad_bodies_are_refused() {
    let scene = |lines: &str| -> himmel::Result<SkyModel> {
        let scene = Scene::from_toml(&format!("version = 1\npreset = \"mars\"\n{lines}"), "s.toml")?;
        let model = SkyModel::new(&scene)?;
        model.frame()?;
        Ok(model)
    };
    let body = "[[bodies]]\nazimuth_deg = 0\naltitude_deg = 40\ndistance_km = 300000\n";
    let good =
        scene(&format!("{body}radius_km = 2000\nname = \"m\"\nalbedo_map = \"nowhere.png\"\nalbedo = 0.3")).unwrap();
    let frame = good.frame().unwrap();
    assert_eq!((frame.far_bodies[0].map.as_ref(), frame.far_bodies[0].albedo), (None, [0.3; 4]));
    assert_eq!(Scene::from_toml(&good.scene().to_toml(), "s.toml").unwrap(), *good.scene());
    for (lines, part) in [
        (body.to_string(), "radius_km"),
        (format!("{body}radius_km = 0"), "1..="),
        (format!("{body}radius_km = 1e30"), "1..="),
        (format!("{body}radius_km = nan"), "NaN"),
        (format!("{body}radius_km = 400000"), "the camera is inside"),
        (format!("{body}preset = \"marz\""), "did you mean"),
        (format!("{body}radius = 3"), "radius_km"),
        (format!("{body}radius_km = 9\ndeclination_deg = 3"), "right_ascension_deg"),
        (format!("{body}radius_km = 9\norbit = \"around-home\""), "semi_major_axis_km"),
        ("[[bodies]]\nradius_km = 9\norbit = \"around-home\"\nsemi_major_axis_km = 9e4\nepoch = \"x\"".into(), "epoch"),
        ("[[bodies]]\nradius_km = 9\nazimuth_deg = 1\naltitude_deg = 2".into(), "distance_km"),
        ("[bodies]\nradius_km = 9".into(), "[[bodies]]"),
        ("bodies = [1]".into(), "[[bodies]]"),
        (format!("{body}{body}{body}{body}"), "at most 3"),
    ] {
        let error = scene(&lines).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(part) && !error.contains('\n'), "{lines}\n→ {error}");
    }
    let airs: Vec<_> = (0..4).map(|_| Arc::new(atmosphere("moonlet", true))).collect();
    let mut still = Still::new(gpu(), Output::Radiance, good.atmosphere()).unwrap();
    let error = still.renderer().set_far_airs(&airs).unwrap_err().to_string();
    assert!(error.contains("at most 3"), "{error}");
    let other = AirParams { wavelength_1_nm: 620.0, ..AirParams::default() };
    let other = Atmosphere::new(&Preset::named("mars").unwrap(), &other, &GroundParams::default());
    assert!(still.renderer().set_far_airs(&[Arc::new(other)]).unwrap_err().to_string().contains("620"));
    let mut frame = good.frame().unwrap();
    frame.far_bodies[0].air = Some(0);
    let error = still.render(&frame, &good.view().unwrap(), 8, 8, &mut |_| true).unwrap_err().to_string();
    assert!(error.contains("air 0, but 0 airs"), "{error}");
}
