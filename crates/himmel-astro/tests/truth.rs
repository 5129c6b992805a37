//! Places against independent tables: DE440 through ERFA (`truth/SOURCE.md`), by the table of accuracies in
//! `docs/astronomy.md`.

use himmel_astro::time::{JulianDateTt, JulianDateUt1};
use himmel_astro::{Body, Ephemeris, Fast, Instant, Observer, Place, Precise};
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
