//! Places against independent tables: DE440 through ERFA (`truth/SOURCE.md`), by the table of accuracies in
//! `docs/astronomy.md`.

use glam::{DMat3, DVec3};
use himmel_astro::events::{CrossingKind, Horizon, ShadowConvention, crossings, lunar_eclipses, solar_eclipses};
use himmel_astro::physical::MoonOrientation;
use himmel_astro::time::{DeltaTModel, JulianDateTdb, JulianDateTt, JulianDateUt1};
use himmel_astro::{Body, Catalogue, Ephemeris, Fast, Instant, Observer, Place, Precise};
use std::collections::BTreeMap;

/// One row by column name.
fn rows(csv: &str) -> impl Iterator<Item = BTreeMap<&str, &str>> {
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines.map(move |line| head.iter().copied().zip(line.split(',')).collect())
}

fn number(row: &BTreeMap<&str, &str>, key: &str) -> f64 {
    row[key].parse().unwrap()
}

fn setting(row: &BTreeMap<&str, &str>) -> (Instant, Place) {
    let tt = JulianDateTt::new(number(row, "jd_tt")).unwrap();
    let ut1 = JulianDateUt1::new(number(row, "jd_ut1")).unwrap();
    let place = Place::from_degrees(number(row, "latitude_deg"), number(row, "longitude_deg"), number(row, "height_m"));
    (Instant::from_tt_ut1(tt, ut1).unwrap(), place.unwrap())
}

/// Great-circle distance of two directions in seconds of arc; differences of nearby angles keep all their digits.
fn separation_arcsec(lon1: f64, lat1: f64, lon2: f64, lat2: f64) -> f64 {
    let d_lon = ((lon1 - lon2 + 540.0).rem_euclid(360.0) - 180.0).to_radians();
    let (a, b) = (lat1.to_radians(), lat2.to_radians());
    let h = ((a - b) / 2.0).sin().powi(2) + a.cos() * b.cos() * (d_lon / 2.0).sin().powi(2);
    2.0 * h.sqrt().asin().to_degrees() * 3600.0
}

fn tolerance_arcsec(level: &str, body: Body) -> f64 {
    match (level, body) {
        ("precise", Body::Sun | Body::Moon) => 0.05,
        ("precise", _) => 0.1,
        (_, Body::Sun) => 5.0,
        (_, Body::Moon) => 10.0,
        _ => 20.0,
    }
}

fn check_bodies(ephemeris: &dyn Ephemeris) {
    let mut worst: BTreeMap<&str, (f64, f64, f64)> = BTreeMap::new();
    for row in rows(include_str!("truth/bodies.csv")) {
        let (instant, place) = setting(&row);
        let body = Body::parse(row["body"]).unwrap();
        let observer = Observer::new(ephemeris, &instant, &place).unwrap();
        let seen = observer.apparent(body).unwrap();
        let degrees = |key| number(&row, key);
        let equatorial = separation_arcsec(
            seen.right_ascension_rad.to_degrees(),
            seen.declination_rad.to_degrees(),
            degrees("ra_deg"),
            degrees("dec_deg"),
        );
        let horizontal = separation_arcsec(
            seen.azimuth_rad.to_degrees(),
            seen.altitude_rad.to_degrees(),
            degrees("azimuth_deg"),
            degrees("altitude_deg"),
        );
        let distance = (seen.distance_m / 1e3 / degrees("distance_km") - 1.0).abs();
        let w = worst.entry(body.name()).or_default();
        *w = (w.0.max(equatorial), w.1.max(horizontal), w.2.max(distance));
        let tolerance = tolerance_arcsec(ephemeris.name(), body);
        assert!(
            equatorial < tolerance && horizontal < tolerance,
            "{} {body} at {}: {equatorial:.4}″ {horizontal:.4}″",
            ephemeris.name(),
            row["jd_tt"]
        );
        assert!(distance < if ephemeris.name() == "precise" { 2e-7 } else { 2e-4 }, "{body}: distance {distance}");
    }
    for (body, (equatorial, horizontal, distance)) in worst {
        println!(
            "{} {body}: {equatorial:.4}″ equatorial, {horizontal:.4}″ horizontal, distance {distance:.1e}",
            ephemeris.name()
        );
    }
}

#[test]
fn precise_bodies() {
    check_bodies(&Precise::embedded().unwrap());
}

#[test]
fn fast_bodies() {
    check_bodies(&Fast);
}

/// Precise 0.02″, fast 0.5″, by the same table of accuracies.
fn check_stars(ephemeris: &dyn Ephemeris, tolerance_arcsec: f64) {
    let mut worst = 0.0_f64;
    for row in rows(include_str!("truth/stars.csv")) {
        let (instant, place) = setting(&row);
        let observer = Observer::new(ephemeris, &instant, &place).unwrap();
        let star = Catalogue::embedded().find(row["body"]).unwrap();
        let seen = observer.apparent_star(star);
        let arcsec = separation_arcsec(
            seen.right_ascension_rad.to_degrees(),
            seen.declination_rad.to_degrees(),
            number(&row, "ra_deg"),
            number(&row, "dec_deg"),
        );
        let horizontal = separation_arcsec(
            seen.azimuth_rad.to_degrees(),
            seen.altitude_rad.to_degrees(),
            number(&row, "azimuth_deg"),
            number(&row, "altitude_deg"),
        );
        worst = worst.max(arcsec).max(horizontal);
        assert!(
            arcsec < tolerance_arcsec && horizontal < tolerance_arcsec,
            "{} at {}: {arcsec:.4}″",
            row["body"],
            row["jd_tt"]
        );
    }
    println!("{} stars: {worst:.4}″", ephemeris.name());
}

#[test]
fn stars() {
    check_stars(&Precise::embedded().unwrap(), 0.02);
    check_stars(&Fast, 0.5);
}

/// Rise, set and twilights of 100 site-days within 1 s (precise) and 10 s (fast), and in number and kind.
fn check_rise_set(ephemeris: &dyn Ephemeris, tolerance_s: f64) {
    let mut days: BTreeMap<String, Vec<BTreeMap<&str, &str>>> = BTreeMap::new();
    for row in rows(include_str!("truth/rise_set.csv")) {
        let key = ["jd_tt_start", "latitude_deg", "longitude_deg"].map(|k| row[k]).join(" ");
        days.entry(key).or_default().push(row);
    }
    assert_eq!(days.len(), 100);
    let (mut worst, mut count, mut beyond) = (0.0_f64, 0, 0);
    for day in days.values() {
        let first = &day[0];
        let start = JulianDateTt::new(number(first, "jd_tt_start")).unwrap();
        let end = JulianDateTt::new(start.jd() + 1.0).unwrap();
        let model = DeltaTModel::fixed(number(first, "delta_t_s")).unwrap();
        let place = Place::from_degrees(
            number(first, "latitude_deg"),
            number(first, "longitude_deg"),
            number(first, "height_m"),
        )
        .unwrap();
        for (name, body, horizon) in [
            ("sun", Body::Sun, Horizon::SunConvention),
            ("civil", Body::Sun, Horizon::CivilTwilight),
            ("nautical", Body::Sun, Horizon::NauticalTwilight),
            ("astronomical", Body::Sun, Horizon::AstronomicalTwilight),
            ("moon", Body::Moon, Horizon::UpperLimb),
        ] {
            let (found, up) = crossings(ephemeris, body, horizon, &place, (start, end), model).unwrap();
            let expected: Vec<_> = day.iter().filter(|r| r["event"].split('_').next() == Some(name)).collect();
            if expected[0]["jd_tt"].is_empty() {
                assert!(found.is_empty() && up == expected[0]["event"].ends_with("_up"), "{name} {expected:?}");
                continue;
            }
            assert_eq!(found.len(), expected.len(), "{name} {expected:?}");
            for (ours, theirs) in found.iter().zip(expected) {
                assert_eq!(ours.kind == CrossingKind::Rise, theirs["event"].ends_with("_rise"));
                let seconds = (ours.instant.tt().jd() - number(theirs, "jd_tt")).abs() * 86_400.0;
                count += 1;
                if seconds < tolerance_s {
                    worst = worst.max(seconds);
                } else {
                    beyond += 1;
                    println!("{} {name} {theirs:?}: {seconds:.2} s", ephemeris.name());
                }
            }
        }
    }
    println!("{}: {count} events, worst {worst:.3} s, {beyond} beyond {tolerance_s} s", ephemeris.name());
    assert_eq!(beyond, 0);
}

#[test]
fn rise_and_set() {
    check_rise_set(&Precise::embedded().unwrap(), 1.0);
    check_rise_set(&Fast, 10.0);
}

/// Every lunar eclipse of 1950–2050, contacts within 2 s (precise) and 30 s (fast).
fn check_lunar_eclipses(ephemeris: &dyn Ephemeris, tolerance_s: f64) {
    let span = (JulianDateTt::new(2_433_282.5).unwrap(), JulianDateTt::new(2_469_807.5).unwrap());
    let found = lunar_eclipses(ephemeris, span, ShadowConvention::Danjon).unwrap();
    let expected: Vec<_> = rows(include_str!("truth/lunar_eclipses.csv")).collect();
    assert_eq!(found.len(), expected.len());
    let mut worst = BTreeMap::<&str, f64>::new();
    for (ours, theirs) in found.iter().zip(&expected) {
        assert_eq!(ours.kind.name(), theirs["type"], "{theirs:?}");
        assert!((ours.umbral_magnitude - number(theirs, "umbral_magnitude")).abs() < 0.002);
        let moments = [Some(ours.greatest), ours.p1, ours.u1, ours.u2, ours.u3, ours.u4, ours.p4];
        for (moment, key) in moments.into_iter().zip(["greatest_jd_tt", "p1", "u1", "u2", "u3", "u4", "p4"]) {
            let Some(moment) = moment else {
                assert_eq!(theirs[key], "", "{theirs:?}");
                continue;
            };
            let seconds = (moment.jd() - number(theirs, key)).abs() * 86_400.0;
            let w = worst.entry(key).or_default();
            *w = w.max(seconds);
            assert!(seconds < tolerance_s, "{key} {theirs:?}: {seconds:.2} s");
        }
    }
    println!("{}: {} lunar eclipses, worst {worst:.3?} s", ephemeris.name(), found.len());
}

#[test]
fn lunar_eclipses_of_a_century() {
    check_lunar_eclipses(&Precise::embedded().unwrap(), 2.0);
    check_lunar_eclipses(&Fast, 30.0);
}

/// The Moon's globe against DE421's integrated librations: 0.005° (precise; the same series serves the fast level).
#[test]
fn libration() {
    let mut worst = 0.0_f64;
    for row in rows(include_str!("truth/libration.csv")) {
        let ours = MoonOrientation::at(JulianDateTdb::new(number(&row, "jd_tdb")).unwrap()).body_from_icrs;
        let theirs = DMat3::from_cols_array(
            &["m00", "m10", "m20", "m01", "m11", "m21", "m02", "m12", "m22"].map(|key| number(&row, key)),
        );
        let turn = ours * theirs.transpose();
        // The sine of the turn's angle from the antisymmetric part.
        let sine = 0.5
            * DVec3::new(turn.y_axis.z - turn.z_axis.y, turn.z_axis.x - turn.x_axis.z, turn.x_axis.y - turn.y_axis.x)
                .length();
        worst = worst.max(sine.asin().to_degrees());
    }
    println!("libration: {worst:.5}°");
    assert!(worst < 0.005, "{worst}");
}

/// Contacts of solar eclipses at places, against DE440 through ERFA: 1 s (precise), 20 s (fast).
fn check_solar_eclipses(ephemeris: &dyn Ephemeris, tolerance_s: f64) {
    let mut worst = 0.0_f64;
    for row in rows(include_str!("truth/solar_eclipses.csv")) {
        let model = DeltaTModel::fixed(number(&row, "delta_t_s")).unwrap();
        let place =
            Place::from_degrees(number(&row, "latitude_deg"), number(&row, "longitude_deg"), number(&row, "height_m"))
                .unwrap();
        let max = number(&row, "max_jd_tt");
        let span = (JulianDateTt::new(max - 1.0).unwrap(), JulianDateTt::new(max + 1.0).unwrap());
        let found = solar_eclipses(ephemeris, &place, span, model).unwrap();
        assert_eq!(found.len(), 1, "{row:?}");
        let e = found[0];
        assert_eq!(e.kind.name(), row["type"], "{row:?}");
        assert!((e.magnitude - number(&row, "magnitude")).abs() < 0.005, "{row:?}: {}", e.magnitude);
        for (key, moment) in
            [("c1", Some(e.c1)), ("c2", e.c2), ("max_jd_tt", Some(e.greatest)), ("c3", e.c3), ("c4", Some(e.c4))]
        {
            let Some(moment) = moment else {
                assert_eq!(row[key], "");
                continue;
            };
            let seconds = (moment.instant.tt().jd() - number(&row, key)).abs() * 86_400.0;
            worst = worst.max(seconds);
            assert!(seconds < tolerance_s, "{key} {row:?}: {seconds:.2} s");
        }
    }
    println!("{}: solar eclipses, worst {worst:.3} s", ephemeris.name());
}

#[test]
fn solar_eclipses_at_places() {
    check_solar_eclipses(&Precise::embedded().unwrap(), 1.0);
    check_solar_eclipses(&Fast, 20.0);
}

/// Visual magnitudes and phase angles against skyfield's own reading of [mallama2018]: 0.01 mag (Uranus and Saturn take another pole), 0.01°.
#[test]
fn magnitudes() {
    let precise = Precise::embedded().unwrap();
    let mut worst = 0.0_f64;
    for row in rows(include_str!("truth/magnitudes.csv")) {
        let (instant, place) = setting(&row);
        let observer = Observer::new(&precise, &instant, &place).unwrap();
        let body = Body::parse(row["body"]).unwrap();
        let look = observer.appearance(body, &observer.apparent(body).unwrap()).unwrap();
        let difference = (look.magnitude - number(&row, "magnitude")).abs();
        worst = worst.max(difference);
        assert!(difference < 0.01, "{row:?}: {}", look.magnitude);
        assert!((look.phase_angle_rad.to_degrees() - number(&row, "phase_angle_deg")).abs() < 0.01, "{row:?}");
    }
    println!("magnitudes: {worst:.4}");
}

/// Where the pack ends the series take over: the jump is within the two levels' tolerances.
#[test]
fn the_packs_ends_are_no_cliffs() {
    let precise = Precise::embedded().unwrap();
    let place = Place::from_degrees(20.0, 30.0, 0.0).unwrap();
    for jd in [2_396_758.5, 2_506_331.5] {
        let at = |jd: f64| {
            let instant = Instant::from_tt(JulianDateTt::new(jd).unwrap(), DeltaTModel::Fixed(60.0));
            Observer::new(&precise, &instant, &place)
        };
        for body in [Body::Sun, Body::Moon].into_iter().chain(Body::PLANETS) {
            let seen = |jd: f64| at(jd).unwrap().apparent(body).unwrap().direction_gcrs;
            // Half a second either side; the bodies' own motion (Moon 0.3″) is taken out by equal steps inside.
            let s = 0.5 / 86_400.0;
            let jump = (seen(jd + s) - seen(jd - s)).length().to_degrees() * 3600.0;
            assert!(jump < tolerance_arcsec("fast", body), "{body} at {jd}: {jump}″");
        }
    }
    // Far outside any validity an error says so.
    let instant = Instant::from_tt(JulianDateTt::new(-500_000.0).unwrap(), DeltaTModel::Standard);
    let e = Observer::new(&precise, &instant, &place).err().unwrap().to_string();
    assert!(e.contains("2000 BC to AD 6000"), "{e}");
}
