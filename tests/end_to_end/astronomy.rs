//! `himmel ephemeris`, `almanac`, `eclipses`: the formats that scripts rely on.

use crate::{himmel, succeed};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// Good rows are answered, bad rows are named with their number and reason; unknown columns pass through.
#[test]
fn tables_are_answered_row_by_row() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(
        folder.path().join("q.csv"),
        "note,body,jd_ut1,jd_tt,latitude_deg,longitude_deg,height_m\n\
         one,sun,2451545.0,2451545.0007,50,10,100\n\
         two,vulcan,2451545.0,2451545.0007,50,10,100\n\
         three,moon,2451545.0,NaN,50,10,100\n\
         four,HIP 32349,2451545.0,2451545.0007,91,10,100\n\
         five,sun,2451545.0\n\
         six,Moon,2451545.0,2451545.0007,-33,151,0\n",
    )
    .expect("written");
    let output = himmel(folder.path(), &["ephemeris", "--input", "q.csv", "--output", "a.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    for words in ["row 2:", "vulcan", "row 3:", "13,000 BC", "row 4:", "latitude", "row 5:", "it is empty"] {
        assert!(errors.contains(words), "{words}: {errors}");
    }
    let answers = std::fs::read_to_string(folder.path().join("a.csv")).expect("answers");
    let lines: Vec<Vec<&str>> = answers.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(lines.len(), 7);
    assert!(lines.iter().all(|l| l.len() == 7 + 15));
    let column = |name: &str| lines[0].iter().position(|h| *h == name).expect(name);
    assert_eq!(lines[1][0], "one");
    assert!(lines[1][column("altitude_deg")].parse::<f64>().is_ok());
    assert!(lines[2][column("altitude_deg")].is_empty());
    assert!(lines[6][column("libration_longitude_deg")].parse::<f64>().is_ok());
    for (input, words) in [("missing.csv", "cannot read missing.csv"), ("a.csv", "")] {
        let output = himmel(folder.path(), &["ephemeris", "--input", input]);
        assert!(String::from_utf8_lossy(&output.stderr).contains(words));
    }
}

/// Issue 3: Stuttgart, 11 August 1999, totality 10:32:53.7 to 10:35:14.8 UTC within 2 s.
#[test]
fn the_eclipse_of_stuttgart() {
    let folder = tempfile::tempdir().expect("a folder");
    let args =
        ["eclipses", "solar", "--place", "48.7758,9.1829,245", "--from", "1999-01-01", "--to", "1999-12-31", "--json"];
    let list = json(&succeed(folder.path(), &args));
    assert_eq!(list.as_array().map(Vec::len), Some(1));
    let eclipse = &list[0];
    assert_eq!(eclipse["type"], "total");
    for (key, utc_s) in [("c2", 10.0 * 3600.0 + 32.0 * 60.0 + 53.7), ("c3", 10.0 * 3600.0 + 35.0 * 60.0 + 14.8)] {
        // TT − UTC was 64.184 s.
        let jd_tt = eclipse[key].as_f64().expect(key);
        let seconds = (jd_tt - 2_451_401.5) * 86_400.0 - 64.184;
        assert!((seconds - utc_s).abs() < 2.0, "{key}: {seconds}");
    }
    assert!(
        !himmel(folder.path(), &["eclipses", "solar", "--from", "1999-01-01", "--to", "1999-12-31"]).status.success()
    );
}

#[test]
fn a_century_of_lunar_eclipses_and_a_day() {
    let folder = tempfile::tempdir().expect("a folder");
    let list =
        json(&succeed(folder.path(), &["eclipses", "lunar", "--from", "1950-01-01", "--to", "2050-12-31", "--json"]));
    let list = list.as_array().expect("a list");
    assert!(list.iter().all(|e| e["penumbral_magnitude"].as_f64().is_some_and(|m| m > 0.0)));
    assert!(list.iter().all(|e| e["u2"].is_null() != (e["type"] == "total")));
    let day = json(&succeed(folder.path(), &["almanac", "--place", "52.4,13.06,35", "--date", "2012-09-06", "--json"]));
    assert_eq!(day["sun"], "rises or sets");
    let at = |key: &str| day[key]["jd_ut1"].as_f64().unwrap_or_else(|| panic!("{key}: {day}"));
    assert!(
        at("astronomical_dawn") < at("civil_dawn") && at("civil_dawn") < at("sunrise") && at("sunrise") < at("sunset")
    );
    assert!(day["sunrise"]["utc"].as_str().is_some_and(|t| t.starts_with("2012-09-06T04:27")));
    let polar = json(&succeed(folder.path(), &["almanac", "--place", "78.22,15.63", "--date", "2012-06-06", "--json"]));
    assert_eq!(polar["sun"], "polar day");
    assert!(polar["sunrise"].is_null());
    for args in [["almanac", "--date", "soon"], ["almanac", "--place", "95,10"]] {
        assert_eq!(himmel(folder.path(), &args).status.code(), Some(2));
    }
}

#[test]
fn one_body_or_star_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let moon = json(&succeed(
        folder.path(),
        &["ephemeris", "moon", "--place", "Potsdam", "--time", "2012-09-06T20:00", "--json"],
    ));
    assert!((moon["distance_km"].as_f64().expect("a distance") - 405_467.5).abs() < 1.0);
    let out = succeed(folder.path(), &["ephemeris", "Sirius", "--time", "2012-09-06T20:00Z"]);
    assert!(out.contains("altitude_deg"));
    let output = himmel(folder.path(), &["ephemeris", "Sirus"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("did you mean `sirius`"));
}

/// Rows that would be answered wrongly are refused by number; the same questions as JSON have the same answers.
#[test]
fn tables_are_read_strictly() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let header = "body,time_utc,latitude_deg,longitude_deg,height_m\n";
    write("q.csv", &format!("{header}sun,2012-09-06T16:00Z,52.4,13.06,35\nsun,2012-09-06T16:00Z,52,4,13.06,35\n"));
    let output = crate::himmel(folder.path(), &["ephemeris", "--input", "q.csv", "--output", "a.csv"]);
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && err.contains("row 2: 6 fields, the header has 5"), "{err}");
    write("twice.csv", "body,body,time_utc,latitude_deg,longitude_deg\nsun,moon,2012-09-06T16:00Z,52,13\n");
    let output = crate::himmel(folder.path(), &["ephemeris", "--input", "twice.csv"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("stands twice"));

    let object =
        r#"{"body":"sun","time_utc":"2012-09-06T16:00Z","latitude_deg":52.4,"longitude_deg":13.06,"height_m":35}"#;
    write("q.json", &format!("[{object}]"));
    let json = crate::succeed(folder.path(), &["ephemeris", "--input", "q.json", "--json"]);
    let answers: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let answered = std::fs::read_to_string(folder.path().join("a.csv")).expect("answers");
    let first: Vec<&str> = answered.lines().nth(1).expect("a row").split(',').collect();
    assert_eq!(answers[0]["azimuth_deg"].as_f64(), first[5].parse().ok());

    let output = crate::himmel(folder.path(), &["ephemeris", "sun", "--output", "x.csv"]);
    assert_eq!(output.status.code(), Some(2));
    let output = crate::himmel(folder.path(), &["almanac", "--place", "Apia", "--date", "2011-12-30"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("does not exist"));
}
