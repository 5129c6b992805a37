//! `himmel optics` as people and scripts run it.

use std::path::Path;

use super::{himmel, succeed};

fn json(args: &[&str]) -> serde_json::Value {
    serde_json::from_str(&succeed(Path::new("."), args)).expect("JSON")
}

fn near(value: &serde_json::Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().expect("a number");
    assert!((value / expected - 1.0).abs() < tolerance, "{value} {expected}");
}

/// Bohren and Huffman's example sphere; k is positive where it absorbs.
#[test]
fn a_sphere() {
    let answer =
        json(&["optics", "mie", "--radius-um", "0.525", "--index", "1.55,0", "--wavelength-nm", "632.8", "--json"]);
    near(&answer["q_ext"], 3.10543, 2e-6);
    near(&answer["q_sca"], 3.10543, 2e-6);
    near(&answer["g"], 0.63314, 1e-5);
    let absorbing =
        json(&["optics", "mie", "--radius-um", "0.525", "--index", "1.55,0.1", "--wavelength-nm", "632.8", "--json"]);
    assert!(absorbing["q_sca"].as_f64() < absorbing["q_ext"].as_f64());
}

#[test]
fn modes() {
    let args = [
        "--mode",
        "0.069,2.03,1.3e4",
        "--mode",
        "0.97,2.15,4.2",
        "--index",
        "1.57,0.02",
        "--wavelength-nm",
        "550",
        "--json",
    ];
    let exact = json(&[&["optics", "lognormal"][..], &args[..]].concat());
    let harmonic = json(&[&["optics", "lognormal", "--method", "harmonic-mean"][..], &args[..]].concat());
    for key in ["extinction_m2", "scattering_m2", "single_scattering_albedo", "g"] {
        assert!(exact[key].as_f64().is_some_and(|value| value > 0.0), "{key}");
    }
    near(&harmonic["single_scattering_albedo"], 0.87, 1e-12);
}

/// The depths that cli.md states for `bruneton2017` at 550 nm, to their last printed digit.
#[test]
fn depths_of_the_comparison_atmosphere() {
    let answer = json(&["optics", "depth", "--preset", "bruneton2017", "--wavelength-nm", "550", "--json"]);
    let species = answer["depths"][0]["species"].as_array().expect("a list");
    for (name, stated) in [("aerosol", 5.328e-3), ("ozone", 2.82135e-2), ("air", 0.108402)] {
        let found = species.iter().find(|row| row["name"] == name).expect(name);
        near(&found["vertical_optical_depth"], stated, 2e-6);
    }
}

#[test]
fn a_component_and_plots() {
    let clouds = json(&["optics", "component", "--preset", "venus", "--name", "clouds", "--json"]);
    near(&clouds["vertical_optical_depth"], 30.0, 1e-9);
    near(&clouds["legendre_moments"][0], 1.0, 1e-6);
    let folder = tempfile::tempdir().expect("a folder");
    for file in ["a.svg", "a.png"] {
        succeed(folder.path(), &["optics", "plot", "--preset", "mars", "--what", "phase", "-o", file]);
        assert!(std::fs::metadata(folder.path().join(file)).expect("a file").len() > 2000);
    }
}

#[test]
fn mistakes_are_sentences() {
    for (args, part) in [
        (vec!["optics", "mie", "--radius-um", "1", "--index", "1.5,-1", "--wavelength-nm", "550"], "got -1"),
        (vec!["optics", "mie", "--radius-um", "-1", "--index", "1.5,0", "--wavelength-nm", "550"], "size parameter"),
        (vec!["optics", "mie", "--radius-um", "1", "--index", "1.5", "--wavelength-nm", "550"], "N,K"),
        (
            vec!["optics", "lognormal", "--mode", "0.1,0.5,1", "--index", "1.5,0", "--wavelength-nm", "550"],
            "geometric standard deviation",
        ),
        (vec!["optics", "depth", "--preset", "erth"], "did you mean earth?"),
        (vec!["optics", "component", "--name", "ozon"], "it has air, aerosol"),
        (vec!["optics", "plot", "-o", "x.gif"], ".png or .svg"),
    ] {
        let output = himmel(Path::new("."), &args);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
        assert!(error.contains(part), "{args:?}: {error}");
    }
}
