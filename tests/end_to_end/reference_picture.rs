//! `himmel render --solver reference`: converging pictures without a GPU.

use std::path::Path;

use crate::{himmel, listing, succeed};

/// A picture that takes a fraction of a second; asks for an adapter that does not exist, to show that none is opened.
fn arguments<'a>(file: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut all = vec!["render", "--solver", "reference", "--preset", "mars-reference", "--time", "2012-09-06T12:00Z"];
    all.extend(["--set", "light.sun.altitude_deg=30", "--size", "16x9", "--adapter", "no such adapter", "-o", file]);
    all.extend(more);
    all
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).expect("written")
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    for ending in ["png", "jpg", "exr", "hdr"] {
        let names = ["a", "b", "c"].map(|name| format!("{name}.{ending}"));
        for (name, seed) in names.iter().zip(["5", "5", "6"]) {
            succeed(folder.path(), &arguments(name, &["--samples", "64", "--seed", seed, "--quiet"]));
        }
        let [a, b, c] = names.map(|name| bytes(folder.path(), &name));
        assert!(a == b, "{ending}: the same seed");
        assert!(a != c, "{ending}: another seed");
    }
    assert_eq!(listing(folder.path()).len(), 12, "no samples are left behind");
}

#[test]
fn a_picture_that_goes_on_is_the_picture_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(folder.path(), &arguments("whole.exr", &["--samples", "96"]));
    succeed(folder.path(), &arguments("parts.exr", &["--samples", "32", "--resume"]));
    assert!(bytes(folder.path(), "parts.exr") != bytes(folder.path(), "whole.exr"));
    succeed(folder.path(), &arguments("parts.exr", &["--samples", "96", "--resume", "--tonemap", "linear"]));
    assert!(bytes(folder.path(), "parts.exr") == bytes(folder.path(), "whole.exr"));
    assert_eq!(listing(folder.path()), ["parts.exr", "parts.exr.partial", "whole.exr"]);
}

/// Refused: samples of another scene or seed, cut off, damaged, or none at all. The picture that is there stays.
#[test]
fn foreign_and_broken_samples_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    succeed(folder.path(), &arguments("a.exr", &["--samples", "32", "--resume"]));
    let (picture, samples) = (bytes(folder.path(), "a.exr"), bytes(folder.path(), "a.exr.partial"));
    let refused = |more: &[&str], part: &str| {
        let mut all = vec!["--samples", "64", "--resume"];
        all.extend(more);
        let output = himmel(folder.path(), &arguments("a.exr", &all));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(part) && message.contains("a.exr.partial"), "{message}");
        assert!(bytes(folder.path(), "a.exr") == picture);
    };
    for more in [
        ["--set", "ground.albedo=0.5"],
        ["--set", "light.sun.altitude_deg=31"],
        ["--set", "light.sun.brightness=2"],
        ["--seed", "2"],
        ["--fov", "59"],
        ["--projection", "fisheye"],
        ["--altitude", "100"],
    ] {
        refused(&more, "another scene");
    }
    let mut flipped = samples.clone();
    flipped[samples.len() / 2] ^= 1;
    for (broken, part) in [
        (samples[..samples.len() / 2].to_vec(), "cut off or damaged"),
        (samples[..samples.len() - 32].to_vec(), "cut off or damaged"),
        (flipped, "cut off or damaged"),
        (picture.clone(), "no samples"),
        (Vec::new(), "no samples"),
    ] {
        std::fs::write(folder.path().join("a.exr.partial"), broken).expect("a file");
        refused(&[], part);
    }
}

#[test]
fn the_report_says_what_the_samples_are_worth() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = succeed(folder.path(), &arguments("a.exr", &["--samples", "65", "--json"]));
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(report["solver"], "reference, 16 wavelengths, all orders");
    assert_eq!(report["paths_per_pixel"], 96, "whole passes");
    assert_eq!(report["seed"], 1);
    assert!(report.get("adapter").is_none());
    let (median, most) = (&report["median_relative_error"], &report["percentile_95_relative_error"]);
    let (median, most) = (median.as_f64().expect("a number"), most.as_f64().expect("a number"));
    assert!(0.0 < median && median <= most && median < 0.2, "{median} {most}");
    let text = succeed(folder.path(), &arguments("b.exr", &["--target-error", "0.03"]));
    assert!(text.contains("standard error of luminance"), "{text}");

    use exr::prelude::*;
    let image = read_first_flat_layer_from_file(folder.path().join("a.exr")).expect("an EXR file");
    let names: Vec<String> =
        image.layer_data.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "Y.error"]);
    let errors: Vec<f32> = image.layer_data.channel_data.list[3].sample_data.values_as_f32().collect();
    assert!(errors.iter().all(|error| error.is_finite() && *error >= 0.0) && errors.iter().any(|error| *error > 0.0));
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, part) in [
        (&["render", "-o", "a.png", "--samples", "64"][..], "--solver reference"),
        (&["render", "-o", "a.png", "--solver", "gpu", "--resume"], "--solver reference"),
        (&["render", "-o", "a.png", "--solver", "reference", "--samples", "0"], "--samples"),
        (&["render", "-o", "a.png", "--solver", "reference", "--target-error", "2"], "--target-error"),
        (&["render", "-o", "a.png", "--solver", "reference", "--target-error", "nan"], "--target-error"),
        (&["render", "-o", "a.png", "--solver", "refrence"], "reference"),
    ] {
        let output = himmel(folder.path(), args);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
        assert!(message.contains(part), "{args:?}: {message}");
    }
    assert!(listing(folder.path()).is_empty());
}

/// Ctrl-C: exit code 1, the picture so far, and samples that go on.
#[test]
#[cfg(unix)]
fn an_interrupted_picture_is_kept_and_goes_on() {
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().expect("a folder");
    let child = Command::new(env!("CARGO_BIN_EXE_himmel"))
        .args(arguments("a.exr", &["--samples", "1000000000"]))
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("himmel starts");
    // Pressed once and early: the first pass is finished, then it stops. The handler is there after some milliseconds.
    std::thread::sleep(std::time::Duration::from_secs(3));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill starts").success());
    let output = child.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("interrupted after") && message.contains("--resume"), "{message}");
    assert_eq!(listing(folder.path()), ["a.exr", "a.exr.partial"]);
    let text = succeed(folder.path(), &arguments("a.exr", &["--samples", "32", "--resume", "--json"]));
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let paths = report["paths_per_pixel"].as_u64().expect("a number");
    assert!(paths >= 32 && message.contains(&format!("after {paths} of")), "{paths}: {message}");
}
