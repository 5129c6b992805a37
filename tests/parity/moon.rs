//! The Moon in pictures: numbers measured from pixels against almanac values, and pixels against the f64 twin.

use std::f64::consts::{PI, TAU};
use std::sync::{Mutex, OnceLock, PoisonError};

use glam::{DVec2, DVec3};
use himmel::parts::astro::events::ShadowConvention;
use himmel::parts::astro::{Body, Instant, Observer, Place, Precise};
use himmel::{Output, Pixels, SkyModel, Still};
use himmel_tests::{gpu, model};

/// Ground without albedo and relief of its own.
const SMOOTH: [(&str, &str); 2] = [("body.moon.albedo_map", "none"), ("body.moon.relief", "0")];

/// Luminance of a square picture of the Moon without air, `size` pixels for 0.6°, and the scene.
fn picture(place: &str, time: &str, size: u32, more: &[(&str, &str)]) -> (SkyModel, Vec<f64>) {
    let pixels = size.to_string();
    let mut settings = vec![
        ("observer.place", place),
        ("clock.time", time),
        ("camera.look", "moon"),
        ("camera.fov_deg", "0.6"),
        ("output.width_px", &pixels),
        ("output.height_px", &pixels),
        ("output.exposure", "none"),
        ("air.enabled", "off"),
        ("air.quality", "low"),
        ("body.moon.light", "off"),
        ("night.airglow.enabled", "off"),
        ("night.zodiacal.enabled", "off"),
        ("night.milky_way.enabled", "off"),
        ("night.stars.enabled", "off"),
    ];
    settings.extend_from_slice(more);
    let model = model("earth", &settings);
    let view = model.view().unwrap();
    // Two renderers for all, without air and with it: tables are filled once.
    static STILLS: [OnceLock<Mutex<Still>>; 2] = [const { OnceLock::new() }; 2];
    let still = &STILLS[usize::from(model.scene().air.enabled)];
    let still = still.get_or_init(|| Mutex::new(Still::new(gpu(), Output::Radiance, model.atmosphere()).unwrap()));
    let mut still = still.lock().unwrap_or_else(PoisonError::into_inner);
    let picture = still.render(&model.frame().unwrap(), &view, size, size, &mut |_| true).unwrap();
    let Pixels::Radiance(rgb) = &picture.pixels else { panic!("radiance was asked for") };
    let luminance = |c: &[f32]| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
    let luminance = rgb.chunks_exact(3).map(luminance).collect();
    (model, luminance)
}

/// A pixel's place on the disc in radii, x to the right, y towards the zenith.
fn on_disc(index: usize, size: u32, radius_rad: f64) -> DVec2 {
    let n = size as usize;
    let ndc = |i: usize| 2.0 * (i as f64 + 0.5) / n as f64 - 1.0;
    let tangent = (0.3f64).to_radians().tan();
    DVec2::new(ndc(index % n), -ndc(index / n)) * tangent / radius_rad
}

/// What the almanac says: phase angle, position angle of the bright limb from the zenith, libration, and the axis from the
/// zenith, counter-clockwise.
struct Almanac {
    phase_rad: f64,
    bright_limb_rad: f64,
    longitude_rad: f64,
    latitude_rad: f64,
    axis_rad: f64,
}

fn almanac(model: &SkyModel) -> Almanac {
    let precise = Precise::embedded().unwrap();
    let instant = Instant::from_unix_seconds(model.clock().unix_seconds()).unwrap();
    let observer = model.observer();
    let place = Place::from_degrees(observer.latitude_deg, observer.longitude_deg, model.altitude_m()).unwrap();
    let observer = Observer::new(&precise, &instant, &place).unwrap();
    let seen = observer.apparent(Body::Moon).unwrap();
    let appearance = observer.appearance(Body::Moon, &seen).unwrap();
    let libration = observer.libration(&seen);
    let q = observer.parallactic_angle_rad(&seen);
    Almanac {
        phase_rad: appearance.phase_angle_rad,
        bright_limb_rad: appearance.bright_limb_position_angle_rad - q,
        longitude_rad: libration.longitude_rad,
        latitude_rad: libration.latitude_rad,
        axis_rad: libration.axis_position_angle_rad - q,
    }
}

/// Phase and terminator of three moons. Position angles grow from the zenith to the left, as from north through east.
#[test]
fn phase_and_terminator_are_the_almanacs() {
    const SIZE: u32 = 400;
    for (name, place, time) in [
        ("waxing gibbous 2024-04-20", "Potsdam", "2024-04-20T20:00Z"),
        ("first quarter", "Paranal", "2024-04-15T23:30Z"),
        ("thin crescent", "Potsdam", "2024-04-10T18:50Z"),
        ("2023-10-28, before the eclipse", "Potsdam", "2023-10-28T17:00Z"),
        ("2024-04-23", "Potsdam", "2024-04-23T23:30Z"),
    ] {
        let (model, light) = picture(place, time, SIZE, &[SMOOTH[0], SMOOTH[1], ("body.moon.earthshine", "0")]);
        let almanac = almanac(&model);
        let moon = model.moon().unwrap().unwrap();
        let radius_rad = moon.radius_deg.to_radians();
        let (mut lit, mut all, mut middle, mut sum) = (0.0, 0.0, DVec2::ZERO, 0.0);
        for (index, value) in light.iter().enumerate() {
            let place = on_disc(index, SIZE, radius_rad);
            if place.length() < 1.0 {
                all += 1.0;
                lit += f64::from(u8::from(*value > 0.0));
                middle += place * *value;
                sum += value;
            }
        }
        let fraction = 0.5 * (1.0 + almanac.phase_rad.cos());
        let middle = middle / sum;
        let angle = (-middle.x).atan2(middle.y);
        let off = (angle - almanac.bright_limb_rad + PI).rem_euclid(TAU) - PI;
        println!(
            "{name}: lit {:.4} (almanac {fraction:.4}), bright limb {:.2}° from the zenith (almanac {:.2}°)",
            lit / all,
            angle.to_degrees(),
            ((almanac.bright_limb_rad + PI).rem_euclid(TAU) - PI).to_degrees()
        );
        assert!((lit / all - fraction).abs() < 5e-3, "{name}: {} {fraction}", lit / all);
        // Near full the light's middle is the disc's: a tenth of a degree of phase tells little of its direction.
        let tolerance_deg = if almanac.phase_rad < 0.1 { 3.0 } else { 0.3 };
        assert!(off.to_degrees().abs() < tolerance_deg, "{name}: {}", off.to_degrees());
    }
}

/// Where bright craters stand in the picture, against the almanac's libration and axis.
#[test]
fn libration_is_the_almanacs() {
    const SIZE: u32 = 700;
    for (place, time) in
        [("Potsdam", "2024-04-23T23:30Z"), ("Potsdam", "2023-10-28T17:00Z"), ("Paranal", "2022-05-16T01:30Z")]
    {
        let (model, light) = picture(place, time, SIZE, &[("body.moon.eclipse_boost", "1")]);
        let almanac = almanac(&model);
        let radius_rad = model.moon().unwrap().unwrap().radius_deg.to_radians();
        // Aristarchus, Proclus: bright spots among dark ground [IAU gazetteer of planetary nomenclature].
        for (name, longitude_deg, latitude_deg) in [("Aristarchus", -47.49f64, 23.73f64), ("Proclus", 46.89, 16.09)] {
            let expected = place_on_disc(&almanac, longitude_deg, latitude_deg);
            let near: Vec<(DVec2, f64)> = (light.iter().enumerate())
                .map(|(index, value)| (on_disc(index, SIZE, radius_rad), *value))
                .filter(|(place, _)| (*place - expected).length() < 0.06)
                .collect();
            let mean = near.iter().map(|(_, value)| value).sum::<f64>() / near.len() as f64;
            let brightest = near.iter().map(|(_, value)| *value).fold(0.0, f64::max);
            let level = 0.5 * (mean + brightest);
            let bright = near.iter().filter(|(_, value)| *value > level);
            let (sum, weight) = bright.fold((DVec2::ZERO, 0.0), |(s, w), (p, v)| (s + *p * (v - level), w + v - level));
            let off = (sum / weight - expected).length();
            println!("{time} {name}: {:.4} expected {expected:.4}, off {off:.4} radii", sum / weight);
            // The crater has 0.012 radii, and brighter walls than floor; a degree of libration is 0.017.
            assert!(off < 0.012, "{time} {name}: {off}");
        }
    }
}

/// The umbra's edge in pictures: where light changes fastest with the distance from the shadow's axis. 2 % of the Moon's
/// radius from Danjon's; a penumbral eclipse has none. Through the air: the shadow's light is that of its rays, and the Moon stands high.
#[test]
fn the_umbra_ends_at_danjons_radius() {
    const SIZE: u32 = 500;
    for (place, time, umbral) in [
        ("New York", "2010-12-21T07:10Z", true),
        ("New York", "2010-12-21T06:55Z", true),
        ("New York", "2022-05-16T03:00Z", true),
        ("Perth", "2023-05-05T17:23Z", false),
    ] {
        let (model, light) =
            picture(place, time, SIZE, &[("air.enabled", "on"), SMOOTH[0], SMOOTH[1], ("body.moon.earthshine", "0")]);
        let moon = model.moon().unwrap().unwrap();
        let eclipse = moon.state.eclipse.as_ref().unwrap();
        // The disc's axes in space: right and up as the picture has them.
        let up = (DVec3::Z - moon.state.direction * moon.state.direction.z).normalize();
        let right = moon.state.direction.cross(up);
        let mut bins = vec![(0.0, 0.0); 300];
        for (index, value) in light.iter().enumerate() {
            let place = on_disc(index, SIZE, moon.radius_deg.to_radians());
            if place.length() < 0.98 && *value > 0.0 {
                let distance = (eclipse.offset + right * place.x + up * place.y).length();
                if let Some(bin) = bins.get_mut((distance * 50.0) as usize) {
                    *bin = (bin.0 + value.ln(), bin.1 + 1.0);
                }
            }
        }
        let mean = |i: usize| (bins[i].1 > 20.0).then(|| bins[i].0 / bins[i].1);
        let slopes = (1..300).filter_map(|i| Some((i, mean(i)? - mean(i - 1)?)));
        let (bin, steepest) = slopes.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let slope = |i: usize| mean(i).zip(mean(i - 1)).map_or(0.0, |(a, b)| a - b);
        let (a, c) = (slope(bin - 1), slope(bin + 1));
        let edge = (bin as f64 + 0.5 * (a - c) / (a - 2.0 * steepest + c)) / 50.0;
        let precise = Precise::embedded().unwrap();
        let instant = Instant::from_unix_seconds(model.clock().unix_seconds()).unwrap();
        let centre = Observer::geocentric(&precise, &instant).unwrap();
        let (moon_m, sun_m) =
            (centre.apparent(Body::Moon).unwrap().distance_m, centre.apparent(Body::Sun).unwrap().distance_m);
        let danjon = ShadowConvention::Danjon.radii_rad(moon_m, sun_m).0.tan() * moon_m / Body::Moon.radius_m();
        println!("{time}: edge at {edge:.3} radii (factor {:.2} over 0.02), Danjon {danjon:.3}", steepest.exp());
        if umbral {
            assert!((edge - danjon).abs() < 0.02, "{time}: {edge} {danjon}");
            // Within the edge light changes by 1.6 in 0.02 radii; in the penumbra beside it by 1.2.
            assert!((1.33..1.8).contains(&steepest.exp()), "{time}: {}", steepest.exp());
        } else {
            assert!(steepest.exp() < 1.3, "{time}: {}", steepest.exp());
        }
    }
}

/// Pixels against the f64 twin, and the sum of a picture against the illuminance; 3 pixels wide to 1,500.
#[test]
fn pixels_are_the_twins_and_sum_to_the_illuminance() {
    // The law is that of a distant sphere; the near one has 1 % less at 126°. Small discs are half limb.
    for (size, tolerance) in [(5u32, 0.03), (40, 0.03), (400, 0.012), (1700, 0.012)] {
        for time in ["2024-04-20T20:00Z", "2024-04-12T19:30Z"] {
            let sum = |relief: &str| {
                let settings = [("body.moon.albedo_map", "none"), ("body.moon.relief", relief)];
                let (model, light) = picture("Potsdam", time, size, &settings);
                (model, light.iter().sum::<f64>())
            };
            let ((model, smooth), (_, rough)) = (sum("0"), sum("1"));
            let moon = model.moon().unwrap().unwrap();
            let pixel = (2.0 * (0.3f64).to_radians().tan() / f64::from(size)).powi(2);
            let sum = smooth * pixel;
            // With the Earth's light, which is no part of the illuminance: a full disc of it.
            let earth = model.atmosphere().xyz(moon.state.earthlit).y * PI * 0.5 * moon.radius_deg.to_radians().powi(2);
            let expected = moon.illuminance_lx + earth;
            println!(
                "{size} px {time}: {sum:.5} lx, expected {expected:.5}; {:+.2} % by relief",
                100.0 * (rough / smooth - 1.0)
            );
            assert!((sum / expected - 1.0).abs() < tolerance, "{size} {time}: {sum} {expected}");
        }
    }
    const SIZE: u32 = 300;
    // Even ground: f32 alone. The map: the twin reads its finest level, pixels the mean of what they cover.
    for (map, relief, median, most) in [("none", "0", 1e-4, 2e-3), ("", "0", 0.03, 0.12)] {
        let settings = [("body.moon.albedo_map", map), ("body.moon.relief", relief)];
        let (model, light) = picture("Potsdam", "2024-04-20T20:00Z", SIZE, &settings);
        let radius_rad = model.moon().unwrap().unwrap().radius_deg.to_radians();
        let errors = errors_of_disc(&model, &light, SIZE, radius_rad, 7);
        let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
        println!("errors: median {:.1e}, 95 % {:.1e}", at(0.5), at(0.95));
        assert!(at(0.5) < median && at(0.95) < most, "{} {}", at(0.5), at(0.95));
    }
}

/// How far pixels within 0.9 radii are from the twin, one of every `step`, sorted.
fn errors_of_disc(model: &SkyModel, light: &[f64], size: u32, radius_rad: f64, step: usize) -> Vec<f64> {
    let view = model.view().unwrap();
    let ndc = |i: usize| 2.0 * (i as f64 + 0.5) / f64::from(size) - 1.0;
    let mut errors: Vec<f64> = (light.iter().enumerate().step_by(step))
        .filter(|(index, _)| on_disc(*index, size, radius_rad).length() < 0.9)
        .map(|(index, value)| {
            let direction = view.direction([ndc(index % size as usize), -ndc(index / size as usize)]).unwrap();
            let twin = model.luminance(direction).unwrap();
            let twin = 0.2126 * twin.x + 0.7152 * twin.y + 0.0722 * twin.z;
            (value - twin).abs() / twin.max(1.0)
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// Where a place of the Moon lies on the disc, in radii.
fn place_on_disc(almanac: &Almanac, longitude_deg: f64, latitude_deg: f64) -> DVec2 {
    let (lon, lat) = (longitude_deg.to_radians() - almanac.longitude_rad, latitude_deg.to_radians());
    let b0 = almanac.latitude_rad;
    // Orthographic: towards the east limb (to the right with north up), towards north.
    let east = lat.cos() * lon.sin();
    let north = lat.sin() * b0.cos() - lat.cos() * b0.sin() * lon.cos();
    let (sin, cos) = almanac.axis_rad.sin_cos();
    // The axis leans by its angle to the left.
    DVec2::new(east * cos - north * sin, east * sin + north * cos)
}

/// At first quarter craters stand where the gazetteer has them: the wall towards the Sun is darker than a smooth Moon, the one
/// across it brighter; and pixels are the f64 twin's.
#[test]
fn craters_stand_where_the_gazetteer_has_them() {
    const SIZE: u32 = 1400;
    let shot = |relief: &str| {
        picture("Paranal", "2024-04-15T23:30Z", SIZE, &[("body.moon.albedo_map", "none"), ("body.moon.relief", relief)])
    };
    let ((_, smooth), (model, rough)) = (shot("0"), shot("1"));
    let almanac = almanac(&model);
    let moon = model.moon().unwrap().unwrap();
    let radius_rad = moon.radius_deg.to_radians();
    let to_sun = DVec2::new(-almanac.bright_limb_rad.sin(), almanac.bright_limb_rad.cos());
    for (name, latitude_deg, longitude_deg, diameter_km) in [
        ("Theophilus", -11.4524, 26.2847, 98.5919),
        ("Maurolycus", -41.7719, 13.9201, 115.35),
        ("Aristoteles", 50.243, 17.32, 87.5669),
        ("Piccolomini", -29.6998, 32.1986, 87.5814),
    ] {
        let middle = place_on_disc(&almanac, longitude_deg, latitude_deg);
        // Half way up the wall: floor and rim of Pike's law for 90 to 110 km, 0.59 and 1 radii.
        let wall = 0.8 * 0.5 * diameter_km / 1737.4;
        let at = |light: &[f64], place: DVec2| {
            let near =
                (light.iter().enumerate()).filter(|(i, _)| (on_disc(*i, SIZE, radius_rad) - place).length() < 0.003);
            let (sum, count) = near.fold((0.0, 0.0), |(s, n), (_, value)| (s + value, n + 1.0));
            sum / count
        };
        let [sunward, across] =
            [wall, -wall].map(|w| at(&rough, middle + to_sun * w) / at(&smooth, middle + to_sun * w));
        println!("{name}: wall towards the Sun {sunward:.2} of a smooth Moon's light, across {across:.2}");
        assert!(sunward < 0.75 && across > 1.2, "{name}: {sunward} {across}");
    }
    let errors = errors_of_disc(&model, &rough, SIZE, radius_rad, 397);
    let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    println!("errors: median {:.1e}, 90 % {:.1e}, 95 % {:.1e}", at(0.5), at(0.9), at(0.95));
    // The twin reads the finest level, pixels the mean of what they cover; shadows have edges.
    assert!(at(0.5) < 2e-3 && at(0.9) < 0.1, "{} {}", at(0.5), at(0.9));
}

#[test]
fn extremes_are_pictures() {
    for more in [
        &[("body.moon.radius_scale", "100")][..],
        &[("body.moon.radius_scale", "0.01")],
        &[("body.moon.altitude_deg", "-90"), ("body.moon.distance_km", "6378")],
        &[("body.moon.altitude_deg", "40"), ("body.moon.distance_km", "2000")],
        &[("body.moon.photometry", "thesis"), ("body.moon.eclipse", "thesis")],
    ] {
        let (_, light) = picture("New York", "2010-12-21T07:10Z", 64, more);
        assert!(light.iter().all(|value| value.is_finite()), "{more:?}");
    }
}

/// What the disc costs at 1280 × 720; printed by `cargo test -p himmel-tests --test parity -- --ignored --nocapture moon`.
#[test]
#[ignore = "a measurement, not a test"]
fn what_the_disc_costs() {
    for (name, fov, time, eclipse) in [
        ("natural size", "60", "2024-04-23T23:30Z", false),
        ("natural size, narrower", "20", "2024-04-23T23:30Z", false),
        ("natural size, by day", "60", "2024-04-18T14:30Z", false),
        ("half, fills the frame", "0.3", "2024-04-15T20:00Z", false),
        ("fills the frame", "0.3", "2024-04-23T23:30Z", false),
        ("fills the frame, eclipsed", "0.3", "2022-05-16T04:11Z", true),
    ] {
        let place = if eclipse { "New York" } else { "Potsdam" };
        let scene = |disc: &str, relief: &str| {
            let settings = [
                ("observer.place", place),
                ("clock.time", time),
                ("camera.look", "moon"),
                ("camera.fov_deg", fov),
                ("output.width_px", "1280"),
                ("output.height_px", "720"),
                ("output.exposure", "5"),
                ("body.moon.light", "off"),
                ("body.moon.disc", disc),
                ("body.moon.relief", relief),
            ];
            model("earth", &settings)
        };
        let models = [scene("off", "1"), scene("on", "0"), scene("on", "1")];
        let mut still = Still::new(gpu(), Output::Display, models[0].atmosphere()).unwrap();
        let mut least = [f64::INFINITY; 3];
        for _ in 0..12 {
            for (model, least) in models.iter().zip(&mut least) {
                let (frame, view) = (model.frame().unwrap(), model.view().unwrap());
                let picture = still.render(&frame, &view, 1280, 720, &mut |_| true).unwrap();
                let sky =
                    picture.times.passes.iter().filter(|(label, _)| *label == "sky").map(|(_, ms)| ms).sum::<f64>();
                *least = least.min(sky);
            }
        }
        println!(
            "{name}: {:.2} ms without, {:.2} more with a smooth disc, {:.2} more with relief",
            least[0],
            least[1] - least[0],
            least[2] - least[0]
        );
    }
}
