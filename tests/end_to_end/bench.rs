//! `himmel bench`: a document that scripts can rely on, with numbers that fit together.

use crate::{himmel, succeed};

/// Every number of a document, with its path.
fn numbers(path: &str, value: &serde_json::Value, found: &mut Vec<(String, f64)>) {
    match value {
        serde_json::Value::Number(number) => found.push((path.into(), number.as_f64().expect("a float"))),
        serde_json::Value::Object(map) => {
            map.iter().for_each(|(key, value)| numbers(&format!("{path}/{key}"), value, found));
        }
        _ => {}
    }
}

/// Small, few frames: the numbers mean little, but they are there, positive, and their ratios are those of the medians.
#[test]
fn a_bench_fits_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = ["bench", "--size", "64x36", "--frames", "3", "--warm-up", "1", "--quality", "low", "--quiet", "--json"];
    let text = succeed(folder.path(), &args);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let mut found = Vec::new();
    numbers("", &json, &mut found);
    for (path, value) in &found {
        // A pass may be shorter than the clock's tick.
        let least = if path.starts_with("/pass_median_ms") { 0.0 } else { f64::MIN_POSITIVE };
        assert!(value.is_finite() && *value >= least, "{path} {value}\n{text}");
    }
    let at =
        |path: &str| json.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("{path}\n{text}"));
    assert_eq!((at("/width_px"), at("/height_px"), at("/frames"), at("/warm_up_frames")), (64.0, 36.0, 3.0, 1.0));
    assert_eq!((json["quality"].as_str(), json["preset"].as_str()), (Some("low"), Some("earth")));
    let [empty, sky, hillaire, every] =
        ["empty", "sky", "hillaire", "hillaire_every_table"].map(|kind| at(&format!("/frame_median_ms/{kind}")));
    for (path, expected) in [
        ("/ratio/sky_to_hillaire", sky / hillaire),
        ("/ratio/sky_to_hillaire_above_empty", (sky - empty) / (hillaire - empty)),
        ("/ratio/sky_to_hillaire_every_table", sky / every),
        ("/ratio/sky_to_hillaire_every_table_above_empty", (sky - empty) / (every - empty)),
        ("/edit/first_frame_in_frames", at("/edit/first_frame_ms") / sky),
    ] {
        assert!((at(path) / expected - 1.0).abs() < 1e-9, "{path} {expected}\n{text}");
    }
    assert!(at("/edit/complete_frames") >= 1.0 && at("/tables_mib/sky") > 0.1 && at("/tables_mib/hillaire") > 0.1);
    assert!(json["adapter"]["name"].is_string() && json["adapter"]["driver"].is_string());
}

#[test]
fn what_the_comparison_cannot_draw_is_bad_usage() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, word) in [
        (vec!["bench", "--projection", "fisheye", "--frames", "1"], "perspective"),
        (vec!["bench", "--altitude", "400000", "--frames", "1"], "400 km"),
        (vec!["bench", "--quality", "best"], "air.quality"),
        (vec!["bench", "--frames", "0"], "--frames"),
    ] {
        let output = himmel(folder.path(), &args);
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && err.contains(word), "{args:?}: {err}");
    }
}
