//! Examples are programs that people copy: they run, and their pictures are pictures.

use std::path::Path;
use std::process::Command;

/// `examples/own_renderer` draws lit cubes in its own pass and the sky behind it.
#[test]
fn own_renderer_draws_a_picture() {
    let bin = Path::new(env!("CARGO_BIN_EXE_himmel"));
    let example = bin.parent().expect("a folder").join("examples").join("own_renderer");
    assert!(example.exists(), "build the examples first: cargo build -p himmel --examples");
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(example)
        .arg("own.png")
        .current_dir(folder.path())
        .env("NODEVICE_SELECT", "1")
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let picture = image::open(folder.path().join("own.png")).expect("a picture").into_rgb8();
    assert!(picture.width() >= 640);
    // Neither black, nor white, nor one colour.
    let values: Vec<f64> = picture.pixels().map(|p| f64::from(p.0[1])).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    assert!((40.0..200.0).contains(&mean) && deviation > 15.0, "mean {mean}, deviation {deviation}");
}
