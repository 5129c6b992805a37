//! Stars in pictures: where `himmel ephemeris` puts them, as bright as their magnitudes say, in every projection.

use glam::DVec3;
use himmel::parts::air::refraction::Bending;
use himmel::parts::astro::query::{Answer, Target};
use himmel::parts::astro::{AirAtObserver, Catalogue, Instant, Observer, Place, Precise, Star};
use himmel::parts::gpu::phenomena::stars::model;
use himmel::{Output, Pixels, Projection, SkyModel, Still, View};
use himmel_tests::{Kernel, Random, gpu, model as model_of, worst_error};

/// 2012-01-20T22:00Z over Potsdam: Orion in the south.
const ORION: [(&str, &str); 4] = [
    ("observer.place", "52.39,13.06"),
    ("clock.time", "2012-01-20T22:00Z"),
    ("camera.look", "180,35"),
    ("output.exposure", "none"),
];

/// A star as the command line's ephemeris answers for it, and how bright it is here.
struct Expected {
    direction: DVec3,
    v_magnitude: f64,
    luminance_lx: f64,
}

/// Where and how bright all catalogue stars of a model's sky are.
fn sky_of(model: &SkyModel) -> Vec<Expected> {
    let precise = Precise::embedded().unwrap();
    let instant = Instant::from_unix_seconds(model.clock().unix_seconds()).unwrap();
    let place = model.observer();
    let place = Place::from_degrees(place.latitude_deg, place.longitude_deg, model.altitude_m()).unwrap();
    let observer = Observer::new(&precise, &instant, &place).unwrap();
    let air = AirAtObserver::default();
    let expected = |star: &Star| {
        let answer = Answer::of(&Target::Star(Box::new(star.clone())), &observer, &air).unwrap();
        let value = |name| answer.values[Answer::COLUMNS.iter().position(|column| *column == name).unwrap()].unwrap();
        let direction = himmel::direction_enu(value("azimuth_deg"), value("refracted_altitude_deg"));
        let through = model.atmosphere().sun_transmittance(model.altitude_m(), direction.z);
        let lx = 2.54e-6 * 10f64.powf(-0.4 * star.v_magnitude);
        let four = model.atmosphere().starlight().of_black_body(star.temperature_k().unwrap_or(0.0), lx);
        let luminance_lx = model.atmosphere().xyz(std::array::from_fn(|k| four[k] * through[k])).y;
        Expected { direction, v_magnitude: star.v_magnitude, luminance_lx }
    };
    Catalogue::embedded().stars().iter().filter(|star| star.v_magnitude <= 6.5).map(expected).collect()
}

/// Luminances of a picture, cd/m².
fn luminances(still: &mut Still, model: &SkyModel, view: &View, size: [u32; 2]) -> Vec<f64> {
    let picture = still.render(&model.frame().unwrap(), view, size[0], size[1], &mut |_| true).unwrap();
    let Pixels::Radiance(rgb) = picture.pixels else { panic!("radiance was asked for") };
    rgb.chunks_exact(3)
        .map(|c| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]))
        .collect()
}

/// What stars add to a picture, in lx a pixel: with them, less without them.
fn starlight(still: &mut Still, settings: &[(&str, &str)], view: &View, size: [u32; 2]) -> Vec<f64> {
    let with = model_of("earth", settings);
    let without = model_of("earth", &[settings, &[("night.stars.enabled", "off")]].concat());
    let dark = luminances(still, &without, view, size);
    let lit = luminances(still, &with, view, size);
    (lit.iter().zip(dark).enumerate()).map(|(i, (lit, dark))| (lit - dark) * pixel_sr(view, size, i)).collect()
}

/// Solid angle of a pixel by its corners.
fn pixel_sr(view: &View, [width, height]: [u32; 2], index: usize) -> f64 {
    let (x, y) = ((index as u32 % width) as f64, (index as u32 / width) as f64);
    let at = |dx: f64, dy: f64| {
        view.direction([2.0 * (x + dx) / f64::from(width) - 1.0, 1.0 - 2.0 * (y + dy) / f64::from(height)])
    };
    // Half a pixel about the middle: corners may lie outside a fisheye.
    let (Some(a), Some(b), Some(c), Some(d)) = (at(0.25, 0.5), at(0.75, 0.5), at(0.5, 0.25), at(0.5, 0.75)) else {
        return 0.0;
    };
    4.0 * (b - a).cross(d - c).length()
}

/// Where a direction lies in the picture, px from the upper left corner.
pub(crate) fn pixel_of(view: &View, [width, height]: [u32; 2], direction: DVec3) -> Option<[f64; 2]> {
    let seen = view.enu_from_view.transpose().transform_vector3(direction);
    let ndc = match view.projection {
        Projection::Matrix(clip_from_view) => {
            let clip = clip_from_view * seen.extend(0.0);
            if clip.w <= 0.0 {
                return None;
            }
            [clip.x / clip.w, clip.y / clip.w]
        }
        Projection::Fisheye(span) => {
            let angle = seen.truncate().length().atan2(-seen.z);
            let place = seen.truncate().normalize() * (angle / (0.5 * span));
            [place.x / view.aspect, place.y]
        }
        Projection::Equirectangular => {
            let forward = view.enu_from_view.transform_vector3(-DVec3::Z);
            let azimuth = direction.x.atan2(direction.y) - forward.x.atan2(forward.y);
            let turns = azimuth / std::f64::consts::TAU;
            [2.0 * (turns - turns.round()), direction.z.asin() / std::f64::consts::FRAC_PI_2]
        }
    };
    let inside = ndc.iter().all(|c| c.abs() < 1.0);
    inside.then(|| [(0.5 + 0.5 * ndc[0]) * f64::from(width), (0.5 - 0.5 * ndc[1]) * f64::from(height)])
}

/// Flux and centroid of a window of a picture.
fn window(light: &[f64], [width, height]: [u32; 2], at: [f64; 2], reach: i64) -> Option<(f64, [f64; 2])> {
    let (cx, cy) = (at[0].floor() as i64, at[1].floor() as i64);
    if cx < reach || cy < reach || cx + reach >= i64::from(width) || cy + reach >= i64::from(height) {
        return None;
    }
    let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
    for row in cy - reach..=cy + reach {
        for column in cx - reach..=cx + reach {
            let value = light[(row * i64::from(width) + column) as usize];
            sum += value;
            x += value * (column as f64 + 0.5);
            y += value * (row as f64 + 0.5);
        }
    }
    Some((sum, [x / sum, y / sum]))
}

/// Compares the brightest stars of a picture with what is expected; worst distance in px and worst relative flux.
fn compare(
    light: &[f64],
    view: &View,
    size: [u32; 2],
    sky: &[Expected],
    count: usize,
    heights: [f64; 2],
) -> (f64, f64, usize) {
    let mut stars: Vec<(&Expected, [f64; 2])> =
        (sky.iter()).filter_map(|star| pixel_of(view, size, star.direction).map(|at| (star, at))).collect();
    stars.sort_by(|a, b| a.0.v_magnitude.total_cmp(&b.0.v_magnitude));
    let (mut far, mut off, mut seen): (f64, f64, usize) = (0.0, 0.0, 0);
    for (star, at) in &stars {
        let near = |other: &[f64; 2]| (other[0] - at[0]).abs().max((other[1] - at[1]).abs());
        // Those on the window's edge would be cut.
        if seen == count
            || star.direction.z < heights[0]
            || star.direction.z > heights[1]
            || stars.iter().any(|(_, other)| (2.5..8.5).contains(&near(other)))
        {
            continue;
        }
        let Some((flux, centroid)) = window(light, size, *at, 5) else { continue };
        // Doubles are one light.
        let group: Vec<_> = stars.iter().filter(|(_, other)| near(other) < 2.5).collect();
        let expected: f64 = group.iter().map(|(other, _)| other.luminance_lx).sum();
        let middle: [f64; 2] =
            std::array::from_fn(|i| group.iter().map(|(other, at)| at[i] * other.luminance_lx).sum::<f64>() / expected);
        let distance = (centroid[0] - middle[0]).hypot(centroid[1] - middle[1]);
        let relative = flux / expected - 1.0;
        if distance > 0.3 || relative.abs() > 0.03 {
            println!("V {:.2} at {at:?}: {distance:.2} px, {:+.1} %", star.v_magnitude, 100.0 * relative);
        }
        far = far.max(distance);
        off = off.max(relative.abs());
        seen += 1;
    }
    (far, off, seen)
}

/// The twenty brightest in view within half a pixel of where `himmel ephemeris` puts them refracted, their fluxes within
/// 5 % of 10^(−0.4 m) times extinction; at three fields of view and sizes.
#[test]
fn stars_of_orion_stand_and_shine_as_they_should() {
    let mut still: Option<Still> = None;
    for (fov, size, count) in
        [("60", [1920, 1080], 20), ("5", [640, 360], 20), ("60", [640, 360], 20), ("20", [640, 360], 20)]
    {
        let [width, height] = size.map(|side: u32| side.to_string());
        let all = [&ORION[..], &[("camera.fov_deg", fov), ("output.width_px", &width), ("output.height_px", &height)]]
            .concat();
        let with = model_of("earth", &all);
        let still = still.get_or_insert_with(|| Still::new(gpu(), Output::Radiance, with.atmosphere()).unwrap());
        let view = with.view().unwrap();
        let light = starlight(still, &all, &view, size);
        let (far, off, seen) = compare(&light, &view, size, &sky_of(&with), count, [0.05, 1.0]);
        println!("fov {fov}° at {width}×{height}: {seen} stars, {far:.3} px, {:.2} %", 100.0 * off);
        assert!(far < 0.5 && off < 0.05, "{far} {off}");
        // A field of 5° holds few stars to 6.5.
        assert!(seen == 20 || (fov == "5" && seen >= 3), "{seen}");
    }
}

/// The same through other projections, down to 6° above the horizon, with the poles of an equirectangular picture.
#[test]
fn stars_keep_their_flux_in_every_projection() {
    let mut still: Option<Still> = None;
    for (projection, fov, look, size) in [
        ("fisheye", "180", "zenith", [900u32, 900u32]),
        ("equirect", "60", "180,0", [2048, 1024]),
        ("perspective", "150", "90,60", [1000, 700]),
    ] {
        let [width, height] = size.map(|side| side.to_string());
        let all = [
            &ORION[..],
            &[("camera.look", look), ("camera.projection", projection), ("camera.fov_deg", fov)],
            &[("output.width_px", &width), ("output.height_px", &height)],
        ]
        .concat();
        let with = model_of("earth", &all);
        let still = still.get_or_insert_with(|| Still::new(gpu(), Output::Radiance, with.atmosphere()).unwrap());
        let view = with.view().unwrap();
        let light = starlight(still, &all, &view, size);
        // Near the zenith an equirectangular picture widens a core beyond the window.
        let highest = if projection == "equirect" { 0.85 } else { 1.0 };
        let (far, off, seen) = compare(&light, &view, size, &sky_of(&with), 60, [0.1, highest]);
        println!("{projection}: {seen} stars, {far:.3} px, {:.2} %", 100.0 * off);
        assert!(far < 0.5 && off < 0.05 && seen > 25, "{projection}: {far} {off} {seen}");
        // Nothing lies below the horizon, and all light together is that of all stars above it.
        let sum: f64 = light.iter().sum();
        assert!(sum.is_finite() && sum > 0.0);
        if projection != "perspective" {
            let all: f64 =
                sky_of(&with).iter().filter(|star| star.direction.z > 0.0).map(|star| star.luminance_lx).sum();
            assert!((sum / all - 1.0).abs() < 0.02, "{projection}: {sum:e} {all:e}");
        }
    }
}

/// Around the pole at 90°: stars turn on circles, and the flux of each is constant within 2 % over parts of a pixel.
#[test]
fn stars_turn_around_the_pole_without_flicker() {
    let size = [480u32, 480u32];
    let settings = |time: &'static str| {
        [
            ("observer.place", "52.39,13.06"),
            ("clock.time", time),
            ("camera.look", "0,52.39"),
            ("camera.fov_deg", "90"),
            ("output.exposure", "none"),
            ("output.width_px", "480"),
            ("output.height_px", "480"),
            // Extinction and refraction change on the way round.
            ("air.enabled", "off"),
            ("night.stars.limiting_magnitude", "4"),
        ]
    };
    let times = ["22:00:00", "22:00:20", "22:00:40", "22:01:00", "22:01:20", "22:02:00", "23:30:00", "23:31:00"]
        .map(|time| &*format!("2012-01-20T{time}Z").leak());
    let mut still: Option<Still> = None;
    let mut tracks: Vec<Vec<(f64, f64)>> = Vec::new();
    for time in times {
        let all = settings(time);
        let with = model_of("earth", &all);
        let still = still.get_or_insert_with(|| Still::new(gpu(), Output::Radiance, with.atmosphere()).unwrap());
        let view = with.view().unwrap();
        let light = starlight(still, &all, &view, size);
        // True places: without air nothing is refracted.
        let precise = Precise::embedded().unwrap();
        let instant = Instant::from_unix_seconds(with.clock().unix_seconds()).unwrap();
        let place = Place::from_degrees(52.39, 13.06, with.altitude_m()).unwrap();
        let observer = Observer::new(&precise, &instant, &place).unwrap();
        let bright: Vec<&Star> = Catalogue::embedded().stars().iter().filter(|s| s.v_magnitude <= 4.0).collect();
        let at: Vec<_> =
            bright.iter().map(|s| pixel_of(&view, size, observer.apparent_star(s).direction_enu)).collect();
        tracks.resize(bright.len(), Vec::new());
        for (i, here) in at.iter().enumerate() {
            let Some(here) = here else { continue };
            let lonely = at.iter().enumerate().all(|(j, other)| {
                j == i || other.is_none_or(|o| (o[0] - here[0]).abs().max((o[1] - here[1]).abs()) > 8.0)
            });
            let Some((flux, centroid)) = window(&light, size, *here, 3).filter(|_| lonely) else { continue };
            let [x, y] = centroid.map(|c| c - 240.0);
            let off = (centroid[0] - here[0]).hypot(centroid[1] - here[1]);
            assert!(off < 0.1, "HIP {}: {off} px", bright[i].hip);
            tracks[i].push((flux, x.hypot(y)));
        }
    }
    let whole: Vec<_> = tracks.iter().filter(|track| track.len() == times.len()).collect();
    assert!(whole.len() > 30, "{}", whole.len());
    let (mut flicker, mut wander): (f64, f64) = (0.0, 0.0);
    for track in whole {
        let mean = track.iter().map(|t| t.0).sum::<f64>() / track.len() as f64;
        flicker = track.iter().map(|t| (t.0 / mean - 1.0).abs()).fold(flicker, f64::max);
        // In a perspective picture circles about its middle stay circles.
        wander = track.iter().map(|t| (t.1 - track[0].1).abs()).fold(wander, f64::max);
    }
    println!("flicker {:.3} %, off the circle {wander:.3} px", 100.0 * flicker);
    assert!(flicker < 0.02 && wander < 0.3);
}

/// From above the air nothing is lost; behind the planet nothing is seen.
#[test]
fn stars_shine_in_space() {
    let all = [&ORION[..], &[("observer.altitude_m", "2000000"), ("camera.fov_deg", "40")]].concat();
    let with = model_of("earth", &all);
    let mut still = Still::new(gpu(), Output::Radiance, with.atmosphere()).unwrap();
    let view = with.view().unwrap();
    let size = [1280, 720];
    let light = starlight(&mut still, &all, &view, size);
    let sum: f64 = light.iter().sum();
    let all: f64 = (sky_of(&with).iter())
        .filter(|star| pixel_of(&view, size, star.direction).is_some())
        .map(|star| 2.54e-6 * 10f64.powf(-0.4 * star.v_magnitude))
        .sum();
    assert!((sum / all - 1.0).abs() < 0.03, "{sum:e} {all:e}");
    let down = View::looking(0.0, -1.2, 0.5, 1.0);
    assert!(starlight(&mut still, &ORION, &down, [128, 128]).iter().all(|value| *value == 0.0));
}

/// In a finished picture stars show, twinkle with time and no picture has holes; the narrowest and widest views work.
#[test]
fn finished_pictures_have_stars_at_any_field_of_view() {
    let base =
        [&ORION[..3], &[("output.width_px", "320"), ("output.height_px", "180"), ("output.exposure", "-6")]].concat();
    let with = model_of("earth", &base);
    let mut still = Still::new(gpu(), Output::Display, with.atmosphere()).unwrap();
    for (fov, psf, glare) in [
        ("60", "physical", "eye"),
        ("179", "physical", "lens"),
        ("0.001", "physical", "eye"),
        ("60", "thesis", "none"),
        ("60", "physical", "none"),
    ] {
        let all = [
            &base[..],
            &[
                ("camera.fov_deg", fov),
                ("night.stars.psf", psf),
                ("night.stars.glare", glare),
                ("night.stars.ciliary_corona", "on"),
            ],
        ]
        .concat();
        let with = model_of("earth", &all);
        let picture = still.render(&with.frame().unwrap(), &with.view().unwrap(), 320, 180, &mut |_| true).unwrap();
        let Pixels::Display(rgb) = picture.pixels else { panic!("display was asked for") };
        let bright = rgb.iter().filter(|value| **value > 60).count();
        println!("{fov}° {psf} {glare}: {bright}");
        assert!(fov == "0.001" || bright > 20, "{fov} {psf} {glare}: {bright}");
    }
}

#[test]
fn spread_functions_are_those_of_the_model() {
    let mut random = Random::new(3);
    let inputs: Vec<[f32; 4]> = (0..3000)
        .map(|_| {
            [
                random.within(-3.0, 3.0),
                random.within(0.001, 0.08),
                random.within(0.0004, 0.003),
                random.within(0.0, 1.0),
            ]
            .map(|value| value as f32)
        })
        .collect();
    let glare = model::glare_coefficients(himmel::Glare::Eye);
    let vector = format!("vec2f({:?}, {:?})", glare[0] as f32, glare[1] as f32);
    let gpu = Kernel::of("phenomena/stars/psf.wgsl").evaluate(
        &format!(
            "vec4f(core_weight(in.x), glare_share({vector}, in.y, in.z), glare_per_sr({vector}, in.y, in.z) * 1e-3, air_mass(in.w))"
        ),
        &inputs,
    );
    let cpu: Vec<_> = (inputs.iter())
        .map(|input| input.map(f64::from))
        .map(|[x, r, soft, sine]| {
            [
                model::core_weight(x),
                model::glare_share(glare, r, soft),
                model::glare_per_sr(glare, r, soft) * 1e-3,
                model::air_mass(sine),
            ]
        })
        .collect();
    let (worst, at) = worst_error(&gpu, &cpu, 0.05);
    assert!(worst < 1e-3, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
    let phases = model::wave_phases(1234.5, 0.05);
    let strength = model::wavelength_strength([630.0, 560.0, 490.0, 430.0]);
    let shift = model::wavelength_shift(2.8e-4, [0.99, 1.0, 1.01, 1.02]);
    let four = |v: &[f64]| format!("vec4f({:?}, {:?}, {:?}, {:?})", v[0] as f32, v[1] as f32, v[2] as f32, v[3] as f32);
    let gpu = Kernel::of("phenomena/stars/psf.wgsl").evaluate(
        &format!(
            "twinkle(in.w, 0.4 + 0.2 * in.x, 0.08, {}, {}, {}, {})",
            four(&phases[..4]),
            four(&phases[4..]),
            four(&shift),
            four(&strength)
        ),
        &inputs,
    );
    let cpu: Vec<_> = (inputs.iter())
        .map(|[x, .., seed]| model::twinkle(f64::from(*seed), f64::from(0.4 + 0.2 * x), 0.08, &phases, shift, strength))
        .collect();
    let (worst, at) = worst_error(&gpu, &cpu, 0.1);
    assert!(worst < 5e-3, "{worst:e} at {:?}: {:?} {:?}", inputs[at], gpu[at], cpu[at]);
}

/// A point's place in the picture needs its apparent elevation, the disc's pixel its true one: one map, read both ways.
#[test]
fn stars_and_the_suns_disc_are_lifted_alike() {
    let earth = himmel::Preset::named("earth").unwrap();
    let bending = Bending::new(&earth.medium, &[630.0, 560.0, 490.0, 430.0], 2.0);
    let lift = bending.lift();
    for degrees in [0.0f64, 0.5, 2.0, 10.0, 50.0] {
        let apparent = degrees.to_radians() + lift.deviation(degrees.to_radians()).0;
        assert!((bending.true_rad(apparent, 1) - degrees.to_radians()).abs() < 5e-6, "{degrees}");
    }
}

#[test]
fn shades_of_planets_are_those_of_the_model() {
    use glam::DVec2;
    use himmel::parts::gpu::PlanetDisc;
    use himmel::parts::gpu::phenomena::planets::model::planet_shade;
    let mut random = Random::new(8);
    for (rings, phase_deg, tilt_deg) in [(false, 70.0f64, 5.0f64), (true, 5.0, 14.0), (true, 6.0, -22.0)] {
        let (alpha, tilt) = (phase_deg.to_radians(), tilt_deg.to_radians());
        let disc = PlanetDisc {
            body: 0,
            direction: DVec3::Y,
            radius_rad: 1e-4,
            polar: 0.9,
            sun: DVec3::new(alpha.sin(), -alpha.cos(), 0.0),
            pole: DVec3::new(0.1, -tilt.sin(), tilt.cos()).normalize(),
            rings,
            irradiance: [1.0; 4],
        };
        let frame = disc.frame();
        let inputs: Vec<[f32; 4]> =
            (0..6000).map(|_| [random.within(-2.4, 2.4) as f32, random.within(-1.2, 1.2) as f32, 0.0, 0.0]).collect();
        let vector = |v: DVec3| format!("vec3f({:?}, {:?}, {:?})", v.x as f32, v.y as f32, v.z as f32);
        let gpu = Kernel::of("phenomena/planets/shade.wgsl").evaluate(
            &format!(
                "vec4f(planet_shade(in.xy, {:?}, {}, {}, {:?}), 0.0, 0.0, 0.0)",
                frame.flat_radius as f32,
                vector(frame.sun),
                vector(frame.pole),
                f32::from(u8::from(rings))
            ),
            &inputs,
        );
        // Edges move by 1e-6 radii: a few points in ten thousand fall on the other side.
        let off = (gpu.iter().zip(&inputs))
            .filter(|(value, input)| {
                let twin = planet_shade(DVec2::new(f64::from(input[0]), f64::from(input[1])), &frame, rings);
                (f64::from(value[0]) - twin).abs() > 1e-3
            })
            .count();
        assert!(off <= 6, "{rings} {phase_deg}: {off}");
    }
}

/// Jupiter and its moons give the light of their magnitudes as points and as discs, and Venus shows by day where a pixel is
/// small enough.
#[test]
fn planets_shine_as_their_magnitudes_say() {
    let evening = [("observer.place", "52.39,13.06"), ("clock.time", "2012-03-14T19:30Z"), ("output.exposure", "none")];
    let mut still: Option<Still> = None;
    for (planet, fov) in
        [("jupiter", "4"), ("jupiter", "0.2"), ("venus", "4"), ("venus", "0.05"), ("mars", "0.05"), ("saturn", "0.05")]
    {
        // Saturn rises later.
        let time = [("clock.time", if planet == "saturn" { "2012-03-15T01:00Z" } else { "2012-03-14T19:30Z" })];
        let all = [
            &evening[..],
            &time,
            &[
                ("camera.look", planet),
                ("camera.fov_deg", fov),
                ("output.width_px", "256"),
                ("output.height_px", "256"),
            ],
            &[("night.stars.enabled", "off"), ("night.planets.moons", "off")],
        ]
        .concat();
        let with = model_of("earth", &all);
        let without = model_of("earth", &[&all[..], &[("night.planets.enabled", "off")]].concat());
        let still = still.get_or_insert_with(|| Still::new(gpu(), Output::Radiance, with.atmosphere()).unwrap());
        let (view, size) = (with.view().unwrap(), [256, 256]);
        let (dark, lit) = (luminances(still, &without, &view, size), luminances(still, &with, &view, size));
        let flux: f64 = (0..lit.len()).map(|i| (lit[i] - dark[i]) * pixel_sr(&view, size, i)).sum();
        let precise = Precise::embedded().unwrap();
        let instant = Instant::from_unix_seconds(with.clock().unix_seconds()).unwrap();
        let place = Place::from_degrees(52.39, 13.06, with.altitude_m()).unwrap();
        let observer = Observer::new(&precise, &instant, &place).unwrap();
        let target = Target::parse(planet).unwrap();
        let answer = Answer::of(&target, &observer, &AirAtObserver::default()).unwrap();
        let (altitude, magnitude) = (answer.values[2].unwrap(), answer.values[9].unwrap());
        let lx = 2.54e-6 * 10f64.powf(-0.4 * magnitude);
        let through = with.atmosphere().sun_transmittance(with.altitude_m(), altitude.to_radians().sin());
        // Their colours shift extinction by a few per cent.
        let expected = lx * with.atmosphere().xyz(through).y / with.atmosphere().xyz([1.0; 4]).y;
        println!("{planet} at {fov}°: {:+.1} %", 100.0 * (flux / expected - 1.0));
        assert!((flux / expected - 1.0).abs() < 0.05, "{planet} {fov}: {flux:e} {expected:e}");
    }
}
