//! Truth: published values and independent computations, each with its source and a tolerance with its reason.

mod vision;

use himmel::Observer;
use himmel_tests::model;

/// Altitude and azimuth of the Sun from JPL's DE440 by skyfield 1.55 (PyPI; `xtask/data/sun_truth.py`),
/// airless, for the four corners of a year and the globe. 0.01° is the bound; what is left is Delta T and rounding.
#[test]
fn the_sun_stands_where_jpl_says() {
    let mut model = model("earth", &[]);
    for line in include_str!("sun_skyfield.csv").lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse::<f64>().expect("a number");
        let place = format!("{},{},{}", fields[1], fields[2], fields[3]);
        let mut scene = model.scene().clone();
        for (key, value) in
            [("observer.place", place.as_str()), ("clock.time", fields[0]), ("observer.altitude_m", fields[3])]
        {
            scene.set(key, value).expect("a setting");
        }
        model.set_scene(&scene).expect("a scene");
        let sun = model.sun().expect("a sun");
        let altitude = (sun.airless_altitude_deg - number(5)).abs();
        let azimuth =
            ((sun.azimuth_deg - number(4) + 180.0).rem_euclid(360.0) - 180.0).abs() * number(5).to_radians().cos();
        assert!(altitude < 0.001 && azimuth < 0.001, "{line}: {} {}", sun.azimuth_deg, sun.airless_altitude_deg);
        assert!((sun.distance_au - number(6)).abs() < 1e-6);
    }
}

/// Clear-sky horizontal illuminance of the Explanatory Supplement as atmosphere.md §6 prints it. Light that is scattered
/// only once must stay below the table; at 60° the Sun itself dominates and the two must agree within 0.1 dex.
#[test]
fn illuminance_is_near_the_published_one_by_day() {
    for (altitude, published, tolerance_dex) in [("60", 1.03e5, 0.1), ("30", 4.63e4, 0.12), ("10", 1.11e4, 0.25)] {
        let light = model("earth", &[("light.sun.altitude_deg", altitude)]).light().expect("light");
        let dex = (light.horizontal_illuminance_lx() / published).log10();
        println!(
            "Sun at {altitude}°: {:.0} lx, published {published:.0}: {dex:+.3} dex",
            light.horizontal_illuminance_lx()
        );
        assert!(dex.abs() < tolerance_dex, "{altitude}°: {dex}");
    }
}

/// Luminance of the Sun's disc above the air: 1.9e9 cd/m² on average (atmosphere.md §6), brighter in the middle.
#[test]
fn the_disc_has_its_luminance() {
    let model =
        model("earth", &[("air.enabled", "off"), ("light.sun.distance_au", "1"), ("light.sun.altitude_deg", "45")]);
    let sun = model.frame().expect("a frame").sun;
    let luminance = |direction| {
        let rgb = model.luminance(direction).expect("a luminance");
        0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z
    };
    let centre = luminance(sun.disc_direction);
    // Neckel and Labs 1994: the mean is 0.80 of the centre at 560 nm.
    assert!((centre * 0.80 / 1.95e9 - 1.0).abs() < 0.04, "{centre:e}");
}

/// The Earth's shadow: with the Sun 4° low, the zenith is lit by the Sun only above 15.5 km, where a seventh of the air is
/// left; the published illuminance falls 25-fold. Within a factor of 3 of both. At −30° what is left is a thousandth of
/// the starlit sky, 2e-4 cd/m².
#[test]
fn twilight_is_dark_below_the_shadow() {
    let bright = model("earth", &[("light.sun.altitude_deg", "0")]).luminance(glam::DVec3::Z).expect("a sky").y;
    let dim = model("earth", &[("light.sun.altitude_deg", "-4")]).luminance(glam::DVec3::Z).expect("a sky").y;
    let dark = [
        ("light.sun.altitude_deg", "-30"),
        ("night.airglow.enabled", "off"),
        ("night.zodiacal.enabled", "off"),
        ("night.milky_way.enabled", "off"),
    ];
    let night = model("earth", &dark).luminance(glam::DVec3::Z).expect("a sky").y;
    assert!((8.0..75.0).contains(&(bright / dim)) && night < 2e-7, "{bright} {dim} {night}");
}

#[test]
fn places_are_where_they_are() {
    let paranal = Observer::at("Paranal").expect("a place");
    assert!((paranal.latitude_deg + 24.63).abs() < 0.01 && (paranal.longitude_deg + 70.40).abs() < 0.01);
    assert_eq!(paranal.time_zone.iana_name(), Some("America/Santiago"));
}
