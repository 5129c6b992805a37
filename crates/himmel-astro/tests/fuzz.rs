//! No text and no number makes the crate panic. 2,000 cases each in the ordinary run; a million and more with
//! `HIMMEL_FUZZ_CASES=200000 cargo test -p himmel-astro --release --test fuzz` (seven properties).

use himmel_astro::orbits::OrbitalElements;
use himmel_astro::query::{Conditions, EphemerisTable, Target};
use himmel_astro::satellites::Satellite;
use himmel_astro::stars::constellations;
use himmel_astro::time::{JulianDateTt, JulianDateUt1};
use himmel_astro::{AirAtObserver, Body, Catalogue, Fast, Instant, Observer, Place, Precise};
use proptest::prelude::*;

fn cases() -> ProptestConfig {
    let cases = std::env::var("HIMMEL_FUZZ_CASES").ok().and_then(|v| v.parse().ok()).unwrap_or(2_000);
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// Text that is nearly right, or not at all.
fn text(nearly: &'static str) -> impl Strategy<Value = String> {
    prop_oneof![nearly.prop_map(String::from), any::<String>(), "[0-9:TZ.,+\\-eE \u{e9}]{0,40}".prop_map(String::from)]
}

const TLE: [&str; 2] = [
    "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
];

/// A good TLE with some characters changed and the checksums made right again, so that the orbit itself is reached.
fn bent_tle(changes: &[(usize, u8)]) -> String {
    let mut lines = TLE.map(|l| l.as_bytes().to_vec());
    for (at, value) in changes {
        let line = &mut lines[at % 2];
        let column = at / 2 % 68;
        line[column] = if value % 4 == 0 { 32 + value % 95 } else { b'0' + value % 10 };
    }
    for line in &mut lines {
        let sum: u32 = line[..68]
            .iter()
            .map(|c| if c.is_ascii_digit() { u32::from(c - b'0') } else { u32::from(*c == b'-') })
            .sum();
        line[68] = b'0' + (sum % 10) as u8;
    }
    lines.map(|l| String::from_utf8_lossy(&l).into_owned()).join("\n")
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn times(s in text("-?[0-9]{1,6}-[0-9]{1,2}-[0-9]{1,2}[T ][0-9]{1,2}:[0-9]{1,2}(:[0-9]{1,2}(\\.[0-9]{1,12})?)?(Z|[+-][0-9]{2}:[0-9]{2})?")) {
        if let Ok(i) = Instant::parse(&s) {
            let _ = i.to_iso_utc();
        }
    }

    #[test]
    fn places(s in text("-?[0-9]{1,3}(\\.[0-9]{1,9})?,-?[0-9]{1,3}(\\.[0-9]{1,9})?(,-?[0-9]{1,9})?")) {
        let _ = Place::parse(&s);
    }

    #[test]
    fn table_rows(header in proptest::collection::vec(prop_oneof![
            Just("body".to_owned()), Just("time_utc".into()), Just("jd_tt".into()), Just("jd_ut1".into()),
            Just("latitude_deg".into()), Just("longitude_deg".into()), Just("height_m".into()), any::<String>()], 0..9),
        row in proptest::collection::vec(prop_oneof![
            Just("moon".to_owned()), Just("HIP 32349".into()), Just("saturn".into()), Just("2020-01-01T00:00Z".into()),
            any::<f64>().prop_map(|v| v.to_string()), (-400.0..3_000_000.0f64).prop_map(|v| v.to_string()), any::<String>()], 0..9)) {
        let whole: Vec<String> = ["body", "jd_tt", "jd_ut1", "latitude_deg", "longitude_deg", "height_m"].map(String::from).to_vec();
        for head in [&header, &whole] {
            if let Ok(table) = EphemerisTable::from_header(head) {
                let _ = table.answer(&row, &Fast, &Conditions::default());
            }
        }
    }

    #[test]
    fn tles(changes in proptest::collection::vec((any::<usize>(), any::<u8>()), 0..6), noise in any::<String>(), unix_s in 1e9..1.4e9f64) {
        let _ = Satellite::parse(&noise);
        if let Ok(satellite) = Satellite::parse(&bent_tle(&changes)) {
            let instant = Instant::from_unix_seconds(unix_s).unwrap();
            let observer = Observer::new(&Fast, &instant, &Place::GREENWICH_EQUATOR).unwrap();
            let _ = observer.satellite(&satellite);
        }
    }

    #[test]
    fn elements(q in any::<f64>(), e in 0.0..21.0f64, angles in any::<[f64; 3]>(), tp in 2_000_000.0..3_000_000.0f64, noise in any::<String>(), jd in 2_000_000.0..3_000_000.0f64) {
        let _ = OrbitalElements::parse(&noise);
        let tdb = JulianDateTt::new(jd).unwrap().to_tdb();
        for q in [q, 0.001 + q.abs() % 30.0] {
            let a = angles.map(|v| v.abs() % 180.0);
            if let Ok(orbit) = OrbitalElements::parse(&format!("x q={q} e={e} i={} node={} peri={} tp={tp} h=3", a[0], a[1], a[2])) {
                let _ = orbit.heliocentric(tdb);
            }
        }
    }

    #[test]
    fn catalogues(noise in any::<String>(), row in text("[0-9]{1,3}\\.[0-9],-?[0-9]{1,2},[0-9.]{1,4},[0-9]{0,6}")) {
        let _ = Catalogue::from_csv(&noise);
        let _ = Catalogue::from_csv(&format!("ra_deg,dec_deg,v_magnitude,hip\n{row}"));
        let _ = constellations::parse(&noise);
        let _ = Target::parse(&noise);
    }

    #[test]
    fn numbers(jd in any::<f64>(), near in -1_000_000.0..5_000_000.0f64, dt in any::<f64>(), place in any::<[f64; 3]>(), body in 0usize..11) {
        let _ = Place::from_degrees(place[0], place[1], place[2]);
        let _ = AirAtObserver::new(place[0], place[1]);
        prop_assert!(AirAtObserver::default().refraction_rad(jd).is_finite());
        let _ = Instant::from_unix_seconds(jd);
        let somewhere = Place::from_degrees(place[0] % 90.0, place[1] % 360.0, place[2] % 1e6).unwrap_or(Place::GREENWICH_EQUATOR);
        for (a, b) in [(jd, dt), (near, near - dt % 1.0), (near, near)] {
            let (Ok(tt), Ok(ut1)) = (JulianDateTt::new(a), JulianDateUt1::new(b)) else { continue };
            let Ok(instant) = Instant::from_tt_ut1(tt, ut1) else { continue };
            let precise = Precise::embedded().unwrap();
            let Ok(observer) = Observer::new(&precise, &instant, &somewhere) else { continue };
            if let Ok(seen) = observer.apparent(Body::ALL[body]) {
                prop_assert!(seen.altitude_rad.is_finite() && seen.azimuth_rad.is_finite());
            }
        }
    }
}
