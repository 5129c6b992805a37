//! What is wrong gets one sentence that helps, exit code 1 or 2, and no file.

use crate::{himmel, listing};

/// Arguments after `render`, and words that the sentence must hold.
const CASES: &[(&[&str], &[&str])] = &[
    (&["--time", "2012-13-45T99:00Z"], &["2012-13-45T99:00Z", "2012-09-06T18:00Z"]),
    (&["--place", "95,10"], &["latitude", "-90..=90", "95"]),
    (&["--place", "Potsdm"], &["unknown place", "did you mean Potsdam"]),
    (&["--place", ""], &["place is empty"]),
    (&["--place", "nan,inf"], &["finite"]),
    (&["--size", "0x0"], &["at least one pixel"]),
    (&["--size", "1000000x1000000"], &["65536"]),
    (&["--size", "big"], &["1280x720"]),
    (&["--size", "-5x5"], &["1280x720"]),
    (&["--set", "air.nonsense=1"], &["unknown parameter", "air.nonsense"]),
    (&["--set", "ground.albedo=NaN"], &["ground.albedo", "0..=1", "NaN"]),
    (&["--set", "ground.albedo=1e30"], &["ground.albedo", "0..=1"]),
    (&["--set", "ground.albedo"], &["KEY=VALUE"]),
    (&["--set", "air.steps=2.5"], &["air.steps"]),
    (&["--preset", "erth"], &["did you mean earth?"]),
    (&["--preset", "missing.toml"], &["cannot read missing.toml"]),
    (&["--scene", "missing.toml"], &["cannot read missing.toml"]),
    (&["--scene", "half.toml"], &["half.toml", "line"]),
    (&["--scene", "binary.toml"], &["binary.toml", "not a text file"]),
    (&["--look", "the moon"], &["cannot look at", "sunward"]),
    (&["--fov", "0"], &["camera.fov_deg", "0.001..=360"]),
    (&["--fov", "200"], &["179.5", "fisheye"]),
    (&["--exposure", "1e30"], &["auto"]),
    (&["--tonemap", "filmic"], &["neutral", "filmic"]),
    (&["--adapter", "no such gpu"], &["no usable GPU adapter", "mesa-vulkan-drivers"]),
    (&["--time", "9999-12-31T23:59:59Z", "--altitude", "-5"], &["observer.altitude_m"]),
];

#[test]
fn every_mistake_gets_a_sentence_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "version = 1\npreset = \"earth\"\n[observer]\nplace = \"Potsdam\"\n";
    std::fs::write(folder.path().join("half.toml"), &scene[..scene.len() / 2 + 3]).expect("written");
    std::fs::write(folder.path().join("binary.toml"), [0xff, 0xfe, 0x00, 0x80]).expect("written");
    let before = listing(folder.path());
    for (args, words) in CASES {
        let mut all = vec!["render", "-o", "x.png"];
        all.extend(*args);
        check(folder.path(), &all, words);
        assert_eq!(listing(folder.path()), before, "{args:?} left something behind");
    }
    for (output, words) in [
        ("/nonexistent/x.png", ["/nonexistent", "does not exist"]),
        ("x.bmp", [".png", ".exr"]),
        ("x", [".png", ".hdr"]),
        ("half.toml/x.png", ["half.toml", "not a folder"]),
    ] {
        check(folder.path(), &["render", "-o", output], &words);
        assert_eq!(listing(folder.path()), before);
    }
}

fn check(folder: &std::path::Path, args: &[&str], words: &[&str]) {
    let output = himmel(folder, args);
    let err = String::from_utf8_lossy(&output.stderr);
    let code = output.status.code();
    assert!(matches!(code, Some(1 | 2)), "{args:?} ended with {code:?}: {err}");
    assert!(output.stdout.is_empty(), "{args:?}");
    assert_eq!(err.trim().lines().count(), 1, "{args:?}: {err}");
    for word in words {
        assert!(err.contains(word), "{args:?}: \"{}\" lacks \"{word}\"", err.trim());
    }
}

#[test]
fn help_has_examples() {
    let folder = tempfile::tempdir().expect("a folder");
    for command in
        ["render", "params", "info", "bench", "ephemeris", "almanac", "eclipses", "optics", "radiance", "light"]
    {
        let help = crate::succeed(folder.path(), &[command, "--help"]);
        assert!(help.contains("Examples:"), "{command}");
    }
}
