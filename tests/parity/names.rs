//! Names in pictures: beside what they name, above the horizon, and not there unless asked for.

use glam::DVec3;
use himmel::parts::astro::query::{Answer, Target};
use himmel::parts::astro::{AirAtObserver, Instant, Observer, Place, Precise};
use himmel::{Gpu, Output, Pixels, Sky, SkyModel, Still, View};
use himmel_tests::{gpu, model as model_of};

use crate::stars::pixel_of;

/// 2012-01-20T22:00Z over Potsdam: Orion in the south, Jupiter in the west. White letters of 20 px without what
/// twinkles and glows.
const EVENING: [(&str, &str); 11] = [
    ("observer.place", "52.39,13.06"),
    ("clock.time", "2012-01-20T22:00Z"),
    ("output.exposure", "-6"),
    ("output.dither", "off"),
    ("night.stars.scintillation", "0"),
    ("night.stars.glare", "none"),
    ("night.airglow.enabled", "off"),
    ("night.zodiacal.enabled", "off"),
    ("night.milky_way.enabled", "off"),
    ("overlay.names.colour", "white"),
    ("overlay.names.size_px", "20"),
];

/// `still`: made for the first picture; all have the same air.
fn picture(still: &mut Option<Still>, settings: &[(&str, &str)], size: [u32; 2]) -> (Vec<u8>, SkyModel, View) {
    let [width, height] = size.map(|side| side.to_string());
    let all = [&EVENING[..], settings, &[("output.width_px", &width), ("output.height_px", &height)]].concat();
    let model = model_of("earth", &all);
    let view = model.view().unwrap();
    let still = still.get_or_insert_with(|| Still::new(gpu(), Output::Display, model.atmosphere()).unwrap());
    let picture = still.render(&model.frame().unwrap(), &view, size[0], size[1], &mut |_| true).unwrap();
    let Pixels::Display(rgb) = picture.pixels else { panic!("finished pixels were asked for") };
    (rgb, model, view)
}

/// Pixels that names brighten, as columns and rows; and the model and view.
fn letters(still: &mut Option<Still>, settings: &[(&str, &str)], size: [u32; 2]) -> (Vec<[f64; 2]>, SkyModel, View) {
    let on = [settings, &[("overlay.names.enabled", "on")]].concat();
    let ((with, model, view), (without, ..)) = (picture(still, &on, size), picture(still, settings, size));
    let pixel = |index: usize| [(index as u32 % size[0]) as f64 + 0.5, (index as u32 / size[0]) as f64 + 0.5];
    let lit = with.chunks_exact(3).zip(without.chunks_exact(3)).enumerate();
    let bright = lit.filter(|(_, (a, b))| i32::from(a[1]) - i32::from(b[1]) > 60).map(|(index, _)| pixel(index));
    (bright.collect(), model, view)
}

/// Where `himmel ephemeris` sees it, refracted.
fn direction_of(model: &SkyModel, name: &str) -> DVec3 {
    let precise = Precise::embedded().unwrap();
    let instant = Instant::from_unix_seconds(model.clock().unix_seconds()).unwrap();
    let place = model.observer();
    let place = Place::from_degrees(place.latitude_deg, place.longitude_deg, model.altitude_m()).unwrap();
    let observer = Observer::new(&precise, &instant, &place).unwrap();
    let answer = Answer::of(&Target::parse(name).unwrap(), &observer, &AirAtObserver::default()).unwrap();
    let value = |name| answer.values[Answer::COLUMNS.iter().position(|column| *column == name).unwrap()].unwrap();
    himmel::direction_enu(value("azimuth_deg"), value("refracted_altitude_deg"))
}

/// The first letter begins half an em right of its star, the line's middle is at its height; within 2 px of where `himmel
/// ephemeris` puts the star, in every projection and field.
#[test]
fn names_stand_beside_what_they_name() {
    let mut still = None;
    let only_stars = [("overlay.names.constellations", "off"), ("overlay.names.cardinal_points", "off")];
    for (projection, fov, look, names) in [
        ("perspective", "60", "180,35", &["rigel", "sirius"][..]),
        ("perspective", "4", "rigel", &["rigel"]),
        ("fisheye", "180", "zenith", &["capella"]),
        ("equirect", "60", "180,0", &["sirius"]),
        ("perspective", "40", "jupiter", &["jupiter"]),
        ("perspective", "0.05", "jupiter", &["jupiter"]),
    ] {
        let size = if projection == "equirect" { [800, 400] } else { [400, 300] };
        let camera = [("camera.projection", projection), ("camera.fov_deg", fov), ("camera.look", look)];
        let (lit, model, view) = letters(&mut still, &[&only_stars[..], &camera[..]].concat(), size);
        for name in names {
            // In the telescope the two formulae of refraction are 16 px apart; the camera looks at the middle of the disc.
            let telescope = fov == "0.05";
            let [x, y] = if telescope {
                size.map(|side| 0.5 * f64::from(side))
            } else {
                pixel_of(&view, size, direction_of(&model, name)).expect("in the picture")
            };
            let em = if *name == "jupiter" { 22.0 } else { 20.0 };
            // Half of 0.011277°, as `himmel ephemeris` has Jupiter's disc.
            let disc = if telescope { f64::from(size[1]) * 0.5 * 0.011277 / 0.05 } else { 0.0 };
            let near =
                |at: &&[f64; 2]| (-0.3 * em..2.5 * em).contains(&(at[0] - x - disc)) && (at[1] - y).abs() < 0.8 * em;
            let own: Vec<&[f64; 2]> = lit.iter().filter(near).collect();
            assert!(own.len() > 20, "{name} at {fov}° in {projection}: {} pixels near {x:.0}, {y:.0}", own.len());
            let left = own.iter().map(|at| at[0]).fold(f64::INFINITY, f64::min);
            let [top, bottom] =
                [-1.0, 1.0].map(|sign| sign * own.iter().map(|at| sign * at[1]).fold(0.0 - 1e9, f64::max));
            // Side bearings of capitals are up to 0.1 em; capitals reach from the baseline, 0.26 em below, to 0.45 above,
            // a g or p to 0.47 below.
            let (aside, above, below) = (left - x - disc - 0.5 * em, y - top, bottom - y);
            println!(
                "{name} {fov}° {projection}: {aside:.1} px aside of half an em, {above:.1} above, {below:.1} below"
            );
            assert!((-2.0..=0.1 * em + 2.0).contains(&aside), "{name} at {fov}° in {projection}: {aside:.1} px");
            assert!((0.45 * em - above).abs() < 3.0, "{name} at {fov}° in {projection}: {above:.1} px above");
            assert!(
                (0.26 * em - 2.0..0.47 * em + 2.0).contains(&below),
                "{name} at {fov}° in {projection}: {below:.1} px"
            );
        }
    }
}

#[test]
fn nothing_has_a_name_below_the_horizon() {
    let mut still = None;
    let off = [("overlay.names.cardinal_points", "off")];
    let (lit, ..) =
        letters(&mut still, &[&off[..], &[("camera.look", "180,-40"), ("camera.fov_deg", "60")]].concat(), [320, 240]);
    assert!(lit.is_empty(), "{:?}", lit.first());
    let (lit, ..) =
        letters(&mut still, &[&off[..], &[("camera.look", "180,40"), ("camera.fov_deg", "60")]].concat(), [320, 240]);
    assert!(!lit.is_empty());
}

/// Below the middle of the horizon.
#[test]
fn south_is_in_the_south() {
    let only =
        [("overlay.names.stars", "off"), ("overlay.names.letters", "off"), ("overlay.names.constellations", "off")];
    let camera = [("camera.look", "180,10"), ("camera.fov_deg", "30")];
    let (lit, _, view) = letters(&mut None, &[&only[..], &camera[..]].concat(), [320, 240]);
    let [x, y] = pixel_of(&view, [320, 240], DVec3::new(0.0, -1.0, 0.0)).unwrap();
    let middle = lit.iter().map(|at| at[0]).sum::<f64>() / lit.len() as f64;
    assert!(lit.len() > 20 && (middle - x).abs() < 2.0, "{middle} {x}");
    assert!(lit.iter().all(|at| at[1] > y && at[1] < y + 30.0));
}

/// Any field, any projection, pictures of a few pixels, letters of any size.
#[test]
fn extremes_draw_something_or_nothing() {
    let mut still = None;
    for (projection, fov, sizes) in [
        ("perspective", "0.001", [([1, 1], "20"), ([200, 100], "4")]),
        ("perspective", "179", [([3, 200], "400"), ([200, 100], "4")]),
        ("fisheye", "360", [([1, 1], "20"), ([3, 200], "400")]),
        ("equirect", "60", [([3, 200], "4"), ([200, 100], "400")]),
    ] {
        for (size, letters) in sizes {
            let camera = [("camera.projection", projection), ("camera.fov_deg", fov), ("camera.look", "sirius")];
            let grids = [("overlay.equatorial_grid", "on"), ("overlay.horizontal_grid", "on")];
            let names = [("overlay.names.enabled", "on"), ("overlay.names.size_px", letters)];
            let (rgb, ..) = picture(&mut still, &[&camera[..], &grids[..], &names[..]].concat(), size);
            assert_eq!(rgb.len() as u32, 3 * size[0] * size[1]);
        }
    }
}

/// Without names there is no overlay in a frame, and no atlas on the device; with them there is one, and frames after the
/// first allocate nothing.
#[test]
fn names_that_are_off_cost_nothing() {
    assert!(model_of("earth", &EVENING).frame().unwrap().overlay.is_none());
    let gpu = Gpu::open(Some(&gpu().report().name)).unwrap();
    let letters = |names: &str| {
        let model = model_of("earth", &[&EVENING[..], &[("overlay.names.enabled", names)]].concat());
        let target = himmel::Target::new(wgpu::TextureFormat::Rgba8Unorm, Output::Display);
        let mut sky = Sky::with_scene(&gpu.device, &gpu.queue, &target, model.scene()).unwrap();
        let mut frame = || {
            sky.clock_mut().advance(60.0);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            sky.prepare(&mut encoder, &[View::looking(0.0, 0.3, 1.0, 1.0), View::looking(3.0, 0.3, 1.0, 1.0)]).unwrap();
            gpu.queue.submit([encoder.finish()]);
            gpu.wait().unwrap();
        };
        let allocations = || {
            let report = gpu.device.generate_allocator_report().expect("this adapter reports allocations");
            let named = report.allocations.iter().filter(|own| own.name.contains("letters")).count();
            (named, report.total_allocated_bytes)
        };
        (0..5).for_each(|_| frame());
        let before = allocations();
        (0..20).for_each(|_| frame());
        assert_eq!(allocations(), before);
        before.0
    };
    assert_eq!(letters("off"), 0);
    assert!(letters("on") >= 1);
}

/// `cargo test -p himmel-tests --test parity cost_of_names -- --ignored --nocapture`: frames of 1280 × 720 with and without names in
/// turn, the fastest of 21 each.
#[test]
#[ignore = "measures time"]
fn cost_of_names() {
    let target = himmel::Target::new(wgpu::TextureFormat::Rgba8Unorm, Output::Display);
    let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: Some("host"),
        size: wgpu::Extent3d { width: 1280, height: 720, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: target.colour,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let attachment = texture.create_view(&Default::default());
    for fov in ["60", "5"] {
        let settings = |names| [("camera.look", "rigel"), ("camera.fov_deg", fov), ("overlay.names.enabled", names)];
        let mut skies = ["off", "on"].map(|names| {
            let model = model_of("earth", &[&EVENING[..9], &settings(names)].concat());
            let view = model.view().unwrap();
            (Sky::with_scene(&gpu().device, &gpu().queue, &target, model.scene()).unwrap(), view)
        });
        let mut fastest = [f64::INFINITY; 2];
        let mut first = [0.0; 2];
        for turn in 0..21 {
            for ((sky, view), fastest_ms) in skies.iter_mut().zip(&mut fastest) {
                let started = std::time::Instant::now();
                let mut encoder = gpu().device.create_command_encoder(&Default::default());
                sky.prepare(&mut encoder, &[*view]).unwrap();
                let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &attachment,
                        depth_slice: None,
                        resolve_target: None,
                        ops: Default::default(),
                    })],
                    ..Default::default()
                });
                sky.draw(&mut pass, 0);
                drop(pass);
                gpu().queue.submit([encoder.finish()]);
                gpu().wait().unwrap();
                *fastest_ms = fastest_ms.min(1e3 * started.elapsed().as_secs_f64());
            }
            if turn == 0 {
                first = fastest;
            }
        }
        println!("{fov}°: {fastest:.1?} ms without and with names; first frames {first:.0?} ms");
    }
}
