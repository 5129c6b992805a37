use super::*;

fn model(settings: &[(&str, &str)]) -> SkyModel {
    let mut scene = Scene::default();
    for (key, value) in settings {
        scene.set(key, value).unwrap_or_else(|error| panic!("{error}"));
    }
    SkyModel::new(&scene).unwrap_or_else(|error| panic!("{error}"))
}

fn moon(settings: &[(&str, &str)]) -> Moon {
    model(settings).moon().unwrap().unwrap()
}

const NEW_YORK: (&str, &str) = ("observer.place", "New York");

/// 0.32 lx above the air at a mean full Moon; on level ground at 30° the table of the Explanatory Supplement has 0.098 lx.
#[test]
fn full_moons_light_the_ground() {
    // 2024-04-23: 397,000 km, φ 2.5°.
    let settings = [("observer.place", "Potsdam"), ("clock.time", "2024-04-23T23:30Z")];
    let full = moon(&settings);
    println!(
        "{:.3} lx above the air, φ {:.2}°, {:.0} km",
        full.illuminance_lx,
        full.phase_angle_deg,
        full.distance_m / 1e3
    );
    assert!((full.illuminance_lx / 0.32 - 1.0).abs() < 0.05 + 1e-9);
    // The same night where it stands at 30°: by itself on level ground, and with the sky that it lights.
    let at_30 = [("observer.place", "41.6,12.0,10"), ("clock.time", "2024-04-23T21:33Z")];
    let (model, full) = (model(&at_30), moon(&at_30));
    let light = model.light().unwrap();
    let direct = light.moon().unwrap();
    let level = direct.illuminance_lx * direct.direction_enu.z;
    let all = light.horizontal_illuminance_lx();
    println!("at {:.1}°: {level:.4} lx by the Moon, {all:.4} lx with the sky", full.altitude_deg);
    assert!((full.altitude_deg - 30.0).abs() < 1.0 && (0.07..0.12).contains(&level), "{level}");
    assert!((0.09..0.16).contains(&all), "{all}");
    // Redder than the Sun, bluer sky.
    assert!(direct.colour[0] > direct.colour[2] && light.sky_colour[2] > light.sky_colour[0]);
}

/// Contacts in almanacs: total from 07:41 to 08:53 UTC, greatest 08:17.
#[test]
fn the_eclipse_of_2010() {
    let at = |time: &str| moon(&[NEW_YORK, ("clock.time", time)]);
    let magnitudes = |moon: &Moon| -2.5 * moon.eclipse_fraction.log10();
    let before = at("2010-12-21T05:20Z");
    assert!(before.state.eclipse.is_none() && before.eclipse_fraction == 1.0);
    let penumbra = at("2010-12-21T06:15Z");
    assert!((0.05..2.0).contains(&magnitudes(&penumbra)), "{}", magnitudes(&penumbra));
    let total = at("2010-12-21T08:17Z");
    println!("mid-totality {:.2} magnitudes fainter", magnitudes(&total));
    assert!((10.0..13.0).contains(&magnitudes(&total)));
    // Redder inside: the ratio of the first to the third wavelength falls outwards; turquoise at the rim.
    let eclipse = total.state.eclipse.as_ref().unwrap();
    let ratio = |distance: f64| {
        let light = eclipse.light(DVec3::X * distance);
        light[0] / light[2]
    };
    for i in 0..40 {
        let light = eclipse.light(DVec3::X * (0.1 * f64::from(i)));
        let rgb = model(&[]).atmosphere().rec709(light);
        println!("{:.1} radii: {:.3e} {:.3} {:.3}", 0.1 * f64::from(i), rgb.x, rgb.y / rgb.x, rgb.z / rgb.x);
    }
    let rim = (10..28).map(|i| ratio(0.1 * f64::from(i))).fold(f64::INFINITY, f64::min);
    println!("red to cyan: {:.1} on the axis, {:.2} least, {:.2} in the penumbra", ratio(0.0), rim, ratio(3.5));
    assert!(ratio(0.0) > ratio(1.0) && ratio(1.0) > ratio(2.0) && ratio(3.5) > 0.99);
    // Clouds and dust darken it.
    let dark = moon(&[NEW_YORK, ("clock.time", "2010-12-21T08:17Z"), ("body.moon.eclipse_dust", "0.05")]);
    assert!(magnitudes(&dark) > magnitudes(&total) + 1.0);
    let boosted = moon(&[NEW_YORK, ("clock.time", "2010-12-21T08:17Z"), ("body.moon.eclipse_boost", "1000")]);
    assert!(boosted.state.sunlit[0] > 500.0 * total.state.sunlit[0] && boosted.irradiance == total.irradiance);
    for rule in ["air", "chauvenet", "thesis"] {
        let moon = moon(&[NEW_YORK, ("clock.time", "2010-12-21T08:17Z"), ("body.moon.eclipse", rule)]);
        assert!(moon.eclipse_fraction < 0.1 && moon.eclipse_fraction > 1e-6, "{rule}: {}", moon.eclipse_fraction);
    }
}

/// At the umbra's rim ozone takes red away more than cyan: within 0.3 radii of the edge the ratio of cyan to red is more than a
/// tenth above that of the same air without ozone.
#[test]
fn the_rims_turquoise_is_the_ozones() {
    let time = ("clock.time", "2010-12-21T08:17Z");
    let [with, without] = [&[NEW_YORK, time][..], &[NEW_YORK, time, ("air.absorbers", "0")]].map(moon);
    let ratio = |moon: &Moon, distance: f64| {
        let light = moon.state.eclipse.as_ref().unwrap().light(DVec3::X * distance);
        light[2] / light[0]
    };
    let gains: Vec<f64> = (0..14)
        .map(|i| {
            let distance = 2.0 + 0.05 * f64::from(i);
            let gain = ratio(&with, distance) / ratio(&without, distance);
            println!(
                "{distance:.2} radii: cyan to red {:.3}, without ozone {:.3}",
                ratio(&with, distance),
                ratio(&without, distance)
            );
            gain
        })
        .collect();
    assert!(gains.iter().fold(0.0, |most: f64, gain| most.max(*gain)) > 1.1, "{gains:?}");
}

/// Where the umbra's edge lies by the air's own rays: 2 % of the Moon's radius from Danjon's.
#[test]
fn the_airs_own_umbra_is_danjons() {
    for time in ["2010-12-21T08:17Z", "2022-05-16T04:11Z", "2023-05-05T17:23Z"] {
        let model = model(&[NEW_YORK, ("clock.time", time), ("body.moon.eclipse", "air")]);
        let standing = model.moon_standing().unwrap().unwrap();
        let (sun, moon) = (standing.sun_m + standing.observer_m, standing.observer_m + standing.moon_m);
        let along_m = moon.dot(-sun.normalize());
        let distances = Distances { moon_m: along_m, star_m: sun.length(), star_radius_m: SUN_RADIUS_M };
        let table = model.shadow_table(&distances).unwrap();
        let danjon_m = along_m * ShadowConvention::Danjon.radii_rad(along_m, sun.length()).0.tan();
        let difference = (table.edge_m - danjon_m) / Body::Moon.radius_m();
        println!("{time}: air {:.1} km, Danjon {:.1} km, {difference:.4} radii", table.edge_m / 1e3, danjon_m / 1e3);
        assert!(difference.abs() < 0.02, "{time}: {difference}");
    }
}

/// Both above the horizon by refraction: Sun and eclipsed Moon of 2014-10-08 from near Wallops Island (selenelion at dawn).
#[test]
fn a_horizontal_eclipse() {
    let found = (0..20).find_map(|minute| {
        let time = format!("2014-10-08T10:{:02}Z", 50 + minute % 10);
        let time = if minute < 10 { time } else { format!("2014-10-08T11:{:02}Z", minute - 10) };
        let model = model(&[("observer.place", "40.0,-74.5,10"), ("clock.time", time.as_str())]);
        let (sun, moon) = (model.sun().unwrap(), model.moon().unwrap().unwrap());
        (sun.altitude_deg > -0.2 && moon.altitude_deg > 0.0).then_some((sun, moon))
    });
    let (sun, moon) = found.unwrap();
    assert!(moon.eclipse_fraction < 1e-2 && moon.state.eclipse.is_some());
    assert!(sun.airless_altitude_deg < 0.0 || moon.airless_altitude_deg < 0.0);
}

#[test]
fn a_sun_by_hand_takes_the_moon_away_and_a_moon_by_hand_stays() {
    let time = ("clock.time", "2024-04-23T23:30Z");
    assert!(model(&[time, ("light.sun.altitude_deg", "-20")]).moon().unwrap().is_none());
    assert!(model(&[time]).moon().unwrap().is_some());
    let by_hand = moon(&[
        time,
        ("light.sun.altitude_deg", "-20"),
        ("light.sun.azimuth_deg", "0"),
        ("body.moon.altitude_deg", "30"),
        ("body.moon.azimuth_deg", "90"),
        ("body.moon.distance_km", "384400"),
    ]);
    assert!((by_hand.altitude_deg - 30.0).abs() < 0.1 && (by_hand.phase_angle_deg - 80.1).abs() < 0.5, "{by_hand:?}");
    assert!((by_hand.state.body_from_enu * -by_hand.state.direction - DVec3::X).length() < 1e-12);
    // Day: its light in the air is left out.
    let noon = model(&[("clock.time", "2024-04-18T12:00Z")]);
    let frame = noon.frame().unwrap();
    assert!(frame.other_suns.is_empty() && frame.moon.is_some());
}

#[test]
fn wrong_settings_are_errors_or_defined() {
    let mut scene = Scene::default();
    for (key, value) in [
        ("body.moon.radius_scale", "0"),
        ("body.moon.radius_scale", "1e9"),
        ("body.moon.distance_km", "0"),
        ("body.moon.distance_km", "nan"),
        ("body.moon.eclipse", "purple"),
        ("body.moon.relief", "-1"),
    ] {
        let error = scene.set(key, value).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
    // Inside the Earth, inside the observer's horizon: pictures without an eclipse, all numbers finite.
    for (altitude, km) in [("-90", "6378"), ("-80", "2000"), ("90", "2000"), ("0", "1e9")] {
        for sun in ["90", "-90", "10"] {
            let model = model(&[
                ("clock.time", "2024-04-23T23:30Z"),
                ("body.moon.altitude_deg", altitude),
                ("body.moon.distance_km", km),
                ("light.sun.altitude_deg", sun),
                ("body.moon.radius_scale", "100"),
            ]);
            let moon = model.moon().unwrap().unwrap();
            assert!(moon.illuminance_lx.is_finite() && moon.state.radius_rad <= 1.5, "{altitude} {km} {sun}");
            assert!(moon.state.sunlit.iter().chain(&moon.state.earthlit).all(|value| value.is_finite()));
            assert!(model.frame().is_ok());
        }
    }
    // Maps that are not there: even ground.
    let even = moon(&[("body.moon.albedo_map", "nowhere.png"), ("body.moon.normal_map", "nowhere.png")]);
    assert_eq!(*even.state.maps, MoonMaps::even());
    let none = moon(&[("body.moon.albedo_map", "none"), ("body.moon.normal_map", "none")]);
    assert_eq!(*none.state.maps, MoonMaps::even());
    // Without a map of normals there are craters; a catalogue that is broken is named in a warning and smooth.
    let craters = moon(&[("body.moon.albedo_map", "none")]).state.maps.relief.clone().unwrap();
    assert!(craters.craters().len() > 8000);
    assert!(super::craters(MoonMaps::even(), &[1, 2, 3]).relief.is_none());
}

#[test]
fn the_thesis_map_of_colours() {
    assert_eq!(thesis_colour(1.0), [1.0; 3]);
    let [r, g, b] = thesis_colour(0.0);
    assert!(r < 0.01 && r > g && g >= b && b >= 0.0, "{r} {g} {b}");
    let [r, _, b] = thesis_colour(0.5);
    assert!(b > r);
    assert!((0..=128).all(|i| thesis_colour(f64::from(i) / 128.0).iter().all(|c| (0.0..=1.1).contains(c))));
    let (umbra, penumbra) = thesis_radii(384.4e6, 1.496e11);
    assert!((umbra - 2.648).abs() < 0.002 && (penumbra - 4.707).abs() < 0.002, "{umbra} {penumbra}");
    // Continuous where the cases meet, ½ there, 1 where the disc leaves the penumbra.
    let t = |d: f64| thesis_phase_of_disc(d, umbra, penumbra);
    assert!((t(umbra + 1.0) - 0.5).abs() < 1e-12 && (t(umbra + 1.0 - 1e-9) - 0.5).abs() < 1e-8);
    assert!((t(penumbra + 1.0) - 1.0).abs() < 1e-12 && t(0.0) == 0.0);
    assert!((at_wavelength([0.92, 0.79, 0.64], 550.0) - 0.79).abs() < 1e-12);
}

/// Thin crescents: the Earth's light has 12 to 13.5 magnitudes per square arcsecond, 0.4 to 1.7 cd/m².
#[test]
fn earthshine_is_as_bright_as_measured() {
    let thin = moon(&[("observer.place", "Potsdam"), ("clock.time", "2024-04-10T18:50Z")]);
    let model = model(&[]);
    let luminance = model.atmosphere().xyz(thin.state.earthlit).y * 0.5;
    println!("φ {:.1}°: earthshine {luminance:.2} cd/m²", thin.phase_angle_deg);
    assert!((0.4..1.7).contains(&luminance));
    assert!(thin.state.earthlit[3] / thin.state.sunlit[3] > thin.state.earthlit[0] / thin.state.sunlit[0]);
    let thesis =
        moon(&[("observer.place", "Potsdam"), ("clock.time", "2024-04-10T18:50Z"), ("body.moon.photometry", "thesis")]);
    let luminance = model.atmosphere().xyz(thesis.state.earthlit).y * 0.5;
    println!("thesis {luminance:.2} cd/m²");
    assert!((0.1..1.7).contains(&luminance));
}

/// The disc's pixels sum to its illuminance: 1 % for the nearness of the Moon, whose limb is seen past its middle.
#[test]
fn the_disc_sums_to_the_illuminance() {
    for time in ["2024-04-20T20:00Z", "2024-04-12T19:30Z"] {
        let model = model(&[
            ("clock.time", time),
            ("body.moon.albedo_map", "none"),
            ("body.moon.earthshine", "0"),
            ("body.moon.relief", "0"),
        ]);
        let moon = model.moon().unwrap().unwrap();
        let state = &moon.state;
        let x = state.direction.any_orthonormal_vector();
        let y = state.direction.cross(x);
        let sine = state.radius_rad.sin();
        let n = 600;
        let mut sum = 0.0;
        for i in 0..n * n {
            let [u, v] = [i % n, i / n].map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
            let q_2 = u * u + v * v;
            if q_2 < 1.0 {
                let normal =
                    himmel_gpu::phenomena::moon::model::sphere_normal((x * u + y * v) * sine, state.direction, sine);
                let eye = -(state.direction + (x * u + y * v) * sine).normalize();
                let light = state.ground_radiance(normal, eye, (1.0 - q_2).sqrt());
                sum += model.atmosphere().xyz(light).y * (2.0 * sine / f64::from(n)).powi(2);
            }
        }
        println!("{time} φ {:.2}: {sum:.6} {:.6}", moon.phase_angle_deg, moon.illuminance_lx);
        assert!((sum / moon.illuminance_lx - 1.0).abs() < 0.012);
    }
}
