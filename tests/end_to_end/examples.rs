//! Examples are programs that people copy: they run, and their pictures are pictures.

use std::path::Path;
use std::process::Command;

use image::RgbImage;

/// Runs an example that writes `picture.png`.
fn picture_of(example: &str, args: &[&str]) -> RgbImage {
    let bin = Path::new(env!("CARGO_BIN_EXE_himmel"));
    let example = bin.parent().expect("a folder").join("examples").join(example);
    assert!(example.exists(), "build the examples first: cargo build -p himmel --examples");
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(example)
        .args(args)
        .current_dir(folder.path())
        .env("NODEVICE_SELECT", "1")
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    image::open(folder.path().join("picture.png")).expect("a picture").into_rgb8()
}

/// `examples/own_renderer` draws lit cubes in its own pass and the sky behind it.
#[test]
fn own_renderer_draws_a_picture() {
    let picture = picture_of("own_renderer", &["picture.png"]);
    assert!(picture.width() >= 640);
    // Neither black, nor white, nor one colour.
    let values: Vec<f64> = picture.pixels().map(|p| f64::from(p.0[1])).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    assert!((40.0..200.0).contains(&mean) && deviation > 15.0, "mean {mean}, deviation {deviation}");
}

fn terrain(args: &[&str]) -> RgbImage {
    picture_of("terrain_host", &[&["--size", "240x136", "-o", "picture.png"], args].concat())
}

/// Mean of the middle of a row, 0..=255 for each channel.
fn row_mean(picture: &RgbImage, y: u32) -> [f64; 3] {
    let middle = picture.width() / 2;
    let sum = (middle - 20..middle + 20).fold([0.0; 3], |sum, x| {
        let pixel = picture.get_pixel(x, y).0;
        std::array::from_fn(|channel| sum[channel] + f64::from(pixel[channel]))
    });
    sum.map(|channel| channel / 40.0)
}

/// `examples/terrain_host` draws the same ground and air whichever way its depth runs.
#[test]
fn terrain_looks_the_same_with_either_depth() {
    for args in [&[] as &[&str], &["--orthographic"]] {
        let reversed = terrain(args);
        let standard = terrain(&[args, &["--standard-depth"]].concat());
        let differing = reversed
            .pixels()
            .zip(standard.pixels())
            .filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 2));
        // Ridges, where one ground ends and another begins behind it.
        let share = differing.count() as f64 / f64::from(reversed.width() * reversed.height());
        assert!(share < 2e-3, "{args:?}: {share}");
    }
}

/// From a summit, sky stands above and ground below, and the air before the near ground is less blue than the sky.
#[test]
fn terrain_lies_below_the_sky() {
    let picture = terrain(&[]);
    let blueness = |y: u32| {
        let [red, _, blue] = row_mean(&picture, y);
        blue / red
    };
    let (sky, near) = (blueness(4), blueness(picture.height() - 4));
    assert!(sky > 1.3 && near < 0.95 * sky, "blue over red: sky {sky}, near ground {near}");
}

/// From 200 km the horizon of both planets is where geometry has it, a tenth of the picture above the middle; Space above is
/// black, and where ground meets sky there is neither a dark nor a bright stripe.
#[test]
fn terrain_ends_at_the_horizon_from_space() {
    for planet in ["earth", "mars"] {
        let picture = terrain(&["--planet", planet, "--altitude", "200e3"]);
        let height = f64::from(picture.height());
        let rows: Vec<f64> = (0..picture.height()).map(|y| row_mean(&picture, y)[1]).collect();
        assert!(rows[2] < 10.0, "{planet}: space is black, got {}", rows[2]);
        let horizon = rows.iter().position(|&green| green > 60.0).expect("something bright");
        // The air glows above it and mountains rise: at most 15 % of the picture.
        let above = 0.4 * height - horizon as f64;
        assert!((0.0..0.15 * height).contains(&above), "{planet}: {above} pixels above");
        // A stripe is a row unlike both of its neighbours, on the same side.
        for window in rows[horizon..horizon + 24].windows(3) {
            let (before, after) = (window[1] - window[0], window[1] - window[2]);
            assert!(before * after <= 0.0 || before.abs().min(after.abs()) < 4.0, "{planet}: stripe {window:?}");
        }
    }
}

/// A shaded valley before the low Sun: where the host's shadow map takes the Sun from the air, it glows less.
#[test]
fn shafts_darken_the_air_in_the_shadow_of_mountains() {
    let against_the_sun = ["--place", "46.55,7.9", "--altitude", "300", "--look", "262,3", "--fov", "60"];
    let glowing = terrain(&against_the_sun);
    let shaded = terrain(&[&against_the_sun as &[&str], &["--shafts"]].concat());
    // Below the hill that hides the Sun.
    let (glow, shade) = (row_mean(&glowing, 44)[0], row_mean(&shaded, 44)[0]);
    assert!(shade < 0.8 * glow, "{shade} for {glow}");
}

/// Mistakes on the command line are answered with what would do.
#[test]
fn terrain_host_tells_mistakes() {
    let bin = Path::new(env!("CARGO_BIN_EXE_himmel"));
    let example = bin.parent().expect("a folder").join("examples").join("terrain_host");
    for (args, remedy) in [
        (["--planet", "venus"], "earth or mars"),
        (["--size", "0x0"], "WIDTHxHEIGHT"),
        (["--look", "north"], "AZ,ALT"),
        (["--map", "nowhere.toml"], "nowhere.toml"),
    ] {
        let output = Command::new(&example).args(args).output().expect("it starts");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(remedy), "{args:?}: {message}");
    }
}
