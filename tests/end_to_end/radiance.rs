//! `himmel radiance` and `himmel light`: the formats that scripts rely on.

use std::collections::HashMap;
use std::path::Path;

use crate::{himmel, listing, succeed};

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("written");
}

/// A table of answers by column name.
fn rows(text: &str) -> Vec<HashMap<String, String>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {row:?}"))
}

const QUESTIONS: &str = "altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm\n\
    0,60,45,90,550\n1000,30,80,10,440\n0,95,70,0,550\n20000,85,120,-170,680\n";

/// Columns in any order, others passed through, digits enough to read the same number again.
#[test]
fn tables_keep_their_columns_and_order() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "q.csv", QUESTIONS);
    write(
        folder.path(),
        "permuted.csv",
        "wavelength_nm,note,azimuth_deg, view_zenith_deg ,radiance_per_sr,sun_zenith_deg,altitude_m\n\
         550,\"a, b\",90,45,old,60,0\n440,,10,80,old,30,1000\n550,c,0,70,old,95,0\n680,d,-170,120,old,85,20000\n",
    );
    let common = ["radiance", "--preset", "bruneton2017", "--samples", "256", "--transmittance", "--quiet"];
    let ask = |more: &[&str]| succeed(folder.path(), &[&common[..], more].concat());
    let plain = ask(&["--input", "q.csv"]);
    assert_eq!(ask(&["--input", "permuted.csv", "--output", "a.csv"]), "");
    let permuted = std::fs::read_to_string(folder.path().join("a.csv")).expect("answers");
    let header = "wavelength_nm,note,azimuth_deg,view_zenith_deg,sun_zenith_deg,altitude_m,\
                  radiance_per_sr,standard_error_per_sr,transmittance";
    assert_eq!(permuted.lines().next(), Some(header));
    assert!(permuted.lines().nth(1).is_some_and(|line| line.starts_with("550,\"a, b\",90,45,60,0,")));
    for (a, b) in rows(&plain).iter().zip(rows(&permuted)) {
        for column in ["radiance_per_sr", "standard_error_per_sr", "transmittance"] {
            assert_eq!(a[column], b[column]);
            assert_eq!(format!("{:e}", number(a, column)), a[column]);
        }
        assert!(number(a, "radiance_per_sr") > 0.0);
    }
    // The ground is in the way of the last one.
    assert_eq!(number(&rows(&plain)[3], "transmittance"), 0.0);
    let list: serde_json::Value = serde_json::from_str(&ask(&["--input", "q.csv", "--json"])).expect("JSON");
    assert_eq!(list[1]["wavelength_nm"], 440.0);
    assert_eq!(list[1]["radiance_per_sr"].as_f64(), Some(number(&rows(&plain)[1], "radiance_per_sr")));
    assert_eq!(ask(&["--input", "q.csv", "--output", "-"]), plain);
    assert_eq!(listing(folder.path()), ["a.csv", "permuted.csv", "q.csv"]);
}

/// The same seed gives the same bytes; a row does not depend on those after it; another seed agrees within the errors.
#[test]
fn chance_is_reproducible() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "q.csv", QUESTIONS);
    write(folder.path(), "first.csv", &QUESTIONS.lines().take(3).map(|line| format!("{line}\n")).collect::<String>());
    let ask = |input: &str, seed: &str| {
        let args = ["radiance", "--input", input, "--seed", seed, "--samples", "512", "--quiet"];
        succeed(folder.path(), &args)
    };
    let (once, first) = (ask("q.csv", "7"), ask("first.csv", "7"));
    assert_eq!(once, ask("q.csv", "7"));
    assert!(once.starts_with(&first));
    let other = ask("q.csv", "8");
    assert_ne!(once, other);
    for (a, b) in rows(&once).iter().zip(rows(&other)) {
        let error = number(a, "standard_error_per_sr").hypot(number(&b, "standard_error_per_sr"));
        let difference = number(a, "radiance_per_sr") - number(&b, "radiance_per_sr");
        assert!(difference.abs() < 6.0 * error, "{difference} {error}");
    }
}

#[test]
fn settings_presets_and_solvers() {
    let folder = tempfile::tempdir().expect("a folder");
    let ask = |more: &[&str]| -> serde_json::Value {
        let common = ["radiance", "--sun-zenith", "60", "--view-zenith", "45", "--json"];
        serde_json::from_str(&succeed(folder.path(), &[&common[..], more].concat())).expect("JSON")
    };
    let value = |answer: &serde_json::Value| answer["radiance_per_sr"].as_f64().expect("a number");
    let plain = ask(&["--samples", "1024"]);
    assert!(value(&ask(&["--samples", "1024", "--set", "ground.albedo=1"])) > 1.05 * value(&plain));
    assert_eq!(value(&ask(&["--set", "air.enabled=off"])), 0.0);
    let orders: f64 = plain["orders_per_sr"].as_array().expect("orders").iter().filter_map(|v| v.as_f64()).sum();
    assert!((orders / value(&plain) - 1.0).abs() < 1e-9);
    let moments = ask(&["--solver", "moments", "--azimuth", "0"]);
    assert!((value(&moments) / value(&plain) - 1.0).abs() < 0.05, "{moments} {plain}");
    let exact = ask(&["--samples", "64", "--target-error", "0.002"]);
    assert!(exact["standard_error_per_sr"].as_f64().expect("an error") <= 0.002 * value(&exact));
    let words = succeed(folder.path(), &["radiance", "--sun-zenith", "60", "--view-zenith", "45", "--samples", "64"]);
    assert!(words.contains("order 2") && words.contains("a second"), "{words}");
    let preset = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/presets/earth.toml");
    assert_eq!(value(&ask(&["--samples", "1024", "--preset", preset])), value(&plain));
}

/// Whatever is wrong with a table is said in one sentence with line and column, and leaves no file behind.
#[test]
fn bad_tables_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let header = "altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm\n";
    let good = "0,60,45,90,550\n";
    let line = |text: &str| format!("{header}{good}{text}\n");
    for (text, words) in [
        (String::new(), vec!["it is empty", "altitude_m"]),
        ("altitude_m,sun_zenith_deg,azimuth_deg\n0,1,2\n".into(), vec!["line 1", "view_zenith_deg, wavelength_nm"]),
        (header.replace("azimuth_deg", "altitude_m,azimuth_deg"), vec!["line 1", "altitude_m stands twice"]),
        (line("0,60,45"), vec!["line 3", "3 fields", "cut off"]),
        (line("0,60,45,90,550,1"), vec!["line 3", "6 fields"]),
        (line("0,nan,45,90,550"), vec!["line 3", "sun_zenith_deg", "0..=180", "NaN"]),
        (line("inf,60,45,90,550"), vec!["line 3", "altitude_m", "inf"]),
        (line("0,60,1e30,90,550"), vec!["line 3", "view_zenith_deg"]),
        (line("-2,60,45,90,550"), vec!["line 3", "altitude_m", "inside the ground", "-2"]),
        (line("0,181,45,90,550"), vec!["line 3", "sun_zenith_deg"]),
        (line("0,60,-1,90,550"), vec!["line 3", "view_zenith_deg"]),
        (line("0,60,45,1e9,550"), vec!["line 3", "azimuth_deg"]),
        (line("0,60,45,90,200"), vec!["line 3", "wavelength_nm", "360..=830"]),
        (line("0,60,45,90,green"), vec!["line 3", "wavelength_nm takes a number", "green"]),
        (line("0,60,45,90,"), vec!["line 3", "wavelength_nm takes a number"]),
        ("[1, 2]".into(), vec!["no object"]),
    ] {
        write(folder.path(), "q.csv", &text);
        let output = himmel(folder.path(), &["radiance", "--input", "q.csv", "--output", "a.csv"]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.starts_with("himmel: q.csv: ") && error.trim_end().lines().count() == 1, "{error}");
        for word in words {
            assert!(error.contains(word), "{error} lacks {word}");
        }
        assert_eq!(listing(folder.path()), ["q.csv"]);
    }
    // No questions have no answers.
    write(folder.path(), "q.csv", header);
    assert_eq!(succeed(folder.path(), &["radiance", "--input", "q.csv"]).lines().count(), 1);
}

#[test]
fn bad_usage_exits_with_2() {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "q.csv", QUESTIONS);
    let table = ["--input", "q.csv", "--output", "a.csv"];
    let one = ["--sun-zenith", "60", "--view-zenith", "45"];
    for (args, more, code, words) in [
        (table, vec!["--solver", "gpu", "--samples", "64"], 2, "chance"),
        (table, vec!["--solver", "magic"], 2, "reference, moments and gpu"),
        (table, vec!["--samples", "0"], 2, "32"),
        (table, vec!["--samples", "31"], 2, "32"),
        (table, vec!["--samples", "many"], 2, "--samples"),
        (table, vec!["--target-error", "nan"], 2, "target error"),
        (table, vec!["--target-error", "0"], 2, "target error"),
        (table, vec!["--solver", "moments", "--samples", "64"], 2, "chance"),
        (table, vec!["--preset", "erth"], 2, "did you mean earth?"),
        (table, vec!["--preset", "none.toml"], 1, "none.toml"),
        (table, vec!["--set", "air.aerosol=2"], 2, "did you mean air.aerosols?"),
        (table, vec!["--set", "camera.fov_deg=20"], 2, "camera.fov_deg does not change"),
        (table, vec!["--set", "air.steps=64"], 2, "air.steps does not change"),
        (table, vec!["--set", "ground.albedo=2"], 2, "0..=1"),
        (table, vec!["--set", "ground.albedo"], 2, "KEY=VALUE"),
        (table, vec!["--sun-zenith", "3"], 2, "--input"),
        (one, vec!["--altitude", "-1"], 2, "inside the ground"),
        (one, vec!["--wavelength", "1e30"], 2, "360..=830"),
        (one, vec!["--azimuth", "inf"], 2, "azimuth_deg"),
        (one, vec!["--output", "a.csv"], 2, "--input"),
    ] {
        let all: Vec<&str> = ["radiance"].into_iter().chain(args).chain(more).collect();
        let output = himmel(folder.path(), &all);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{all:?}: {error}");
        assert!(error.contains(words), "{all:?}: {error} lacks {words}");
        assert_eq!(listing(folder.path()), ["q.csv"]);
    }
    let output = himmel(folder.path(), &["radiance"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("--sun-zenith"));
    let output = himmel(folder.path(), &["radiance", "--input", "q.csv", "--output", "nowhere/a.csv"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("does not exist"));
}

/// Ctrl-C keeps the rows that are finished, without waiting for one that would take hours.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_finished_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let header = "altitude_m,sun_zenith_deg,view_zenith_deg,azimuth_deg,wavelength_nm,id\n";
    // A line of sight that misses the air has its answer at once; the others have 1e10 paths.
    let text: String = (0..40).map(|i| format!("{},60,45,0,550,{i}\n", if i < 20 { 1e7 } else { 0.0 })).collect();
    write(folder.path(), "q.csv", &format!("{header}{text}"));
    let interrupted_after = |seconds| {
        let child = std::process::Command::new(env!("CARGO_BIN_EXE_himmel"))
            .args(["radiance", "--input", "q.csv", "--output", "a.csv", "--samples", "10000000000"])
            .current_dir(folder.path())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("himmel starts");
        std::thread::sleep(std::time::Duration::from_secs(seconds));
        let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(kill.expect("kill runs").success());
        child.wait_with_output().expect("it ends")
    };
    // A busy machine takes seconds before its first row.
    let waits = [3, 12, 40].into_iter();
    let mut outputs = waits.map(interrupted_after);
    let finished = |output: &std::process::Output| !String::from_utf8_lossy(&output.stderr).contains("before a row");
    let output = outputs.find(finished).expect("a row is finished in 40 s");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("stopped: 20 of 40 rows"), "{error}");
    let answers = rows(&std::fs::read_to_string(folder.path().join("a.csv")).expect("answers"));
    assert_eq!(answers.len(), 20);
    assert!(answers.iter().enumerate().all(|(i, row)| row["id"] == i.to_string()));
    assert_eq!(listing(folder.path()), ["a.csv", "q.csv"]);
}

/// `himmel light`: one measurement as JSON, a table over time, and what is refused.
#[test]
fn light_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let common = ["light", "--place", "52.4,13.06,35", "--time", "2012-06-21T12:00Z"];
    let ask = |more: &[&str]| -> serde_json::Value {
        serde_json::from_str(&succeed(folder.path(), &[&common[..], more].concat())).expect("JSON")
    };
    let value =
        |answer: &serde_json::Value, name: &str| answer[name].as_f64().unwrap_or_else(|| panic!("{name}: {answer}"));
    let first = ask(&["--solver", "first", "--json"]);
    let all = ask(&["--samples", "1024", "--json"]);
    assert_eq!(all, ask(&["--samples", "1024", "--json"]));
    assert_eq!(first["spectrum"]["wavelength_nm"].as_array().map(Vec::len), Some(4));
    assert_eq!(all["spectrum"]["sky_horizontal_w_m2_nm"].as_array().map(Vec::len), Some(16));
    assert!(first["sky_illuminance_standard_error_lx"].is_null());
    let (sky, error) = (value(&all, "sky_illuminance_lx"), value(&all, "sky_illuminance_standard_error_lx"));
    assert!(sky > value(&first, "sky_illuminance_lx") && error > 0.0 && error < 0.2 * sky, "{sky} {error}");
    let together = value(&all, "sun_horizontal_illuminance_lx") + sky;
    assert!((value(&all, "horizontal_illuminance_lx") / together - 1.0).abs() < 1e-12);
    assert!(succeed(folder.path(), &[&common[..], &["--solver", "first"]].concat()).contains("cd/m²"));

    let span = ["--from", "2012-06-21T18:00Z", "--to", "2012-06-21T20:05Z", "--step", "30m", "--solver", "first"];
    assert_eq!(succeed(folder.path(), &[&common[..], &span, &["-o", "dusk.csv"]].concat()), "");
    let dusk = rows(&std::fs::read_to_string(folder.path().join("dusk.csv")).expect("a table"));
    assert_eq!(dusk.len(), 5);
    assert_eq!(dusk[4]["time_utc"], "2012-06-21T20:00:00Z");
    assert!(
        dusk.windows(2)
            .all(|w| number(&w[0], "horizontal_illuminance_lx") > number(&w[1], "horizontal_illuminance_lx"))
    );
    assert!(dusk[0]["sky_illuminance_standard_error_lx"].is_empty());
    let list = ask(&[&span[..], &["--json"]].concat());
    assert_eq!(list.as_array().map(Vec::len), Some(5));

    for (more, words) in [
        (vec!["--samples", "1023"], "1024"),
        (vec!["--solver", "gpu"], "moments"),
        (vec!["--from", "2012-06-21T18:00Z"], "together"),
        (vec!["--from", "2012-06-21T18:00Z", "--to", "2012-06-21T17:00Z", "--step", "1h"], "lies before"),
        (vec!["--from", "2012-06-21T18:00Z", "--to", "2012-06-21T19:00Z", "--step", "0m"], "10m"),
        (vec!["--from", "2012-06-21T18:00Z", "--to", "2012-06-21T19:00Z", "--step", "-5m"], "10m"),
        (vec!["--from", "2012-06-21T18:00Z", "--to", "2012-06-21T19:00Z", "--step", "1 month"], "10m"),
        (vec!["--from", "2012-01-01T00:00Z", "--to", "2012-12-31T00:00Z", "--step", "1s"], "100000 rows"),
        (vec!["-o", "one.txt"], "--json"),
        (vec!["--set", "air.aerosol=1"], "did you mean"),
    ] {
        let output = himmel(folder.path(), &[&common[..], &more].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {error}");
        assert!(error.contains(words), "{more:?}: {error} lacks {words}");
        assert_eq!(listing(folder.path()), ["dusk.csv"]);
    }
}
