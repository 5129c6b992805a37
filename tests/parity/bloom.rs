//! Bloom and acuity: what the passes do with light.

use himmel::parts::core::vision::glare_per_sr;
use himmel::parts::gpu::output::bloom::finish;
use himmel::parts::gpu::output::display_rgb;
use himmel::{Bloom, Exposure, Output, OutputParams, PassTimes, Picture, Pixels, Tonemap, View, glam::DVec3};
use himmel_tests::gpu;

fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Picture {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| pixel(x, y)).collect();
    Picture { width, height, pixels: Pixels::Radiance(pixels), exposure: 1.0, ev100: 0.0, times: PassTimes::default() }
}

fn linear(picture: &Picture, output: &OutputParams, view: &View) -> Vec<f32> {
    match finish(gpu(), picture, output, view, Output::Radiance).unwrap().pixels {
        Pixels::Radiance(rgb) => rgb,
        Pixels::Display(_) => unreachable!(),
    }
}

fn sum(rgb: &[f32]) -> f64 {
    rgb.iter().map(|value| f64::from(*value)).sum()
}

/// A point in the middle keeps its light within half a per cent (what leaves the picture at its edge is the rest), an even
/// picture stays even, and around the point the light falls as the glare function does.
#[test]
fn light_is_spread_and_kept() {
    let view = View::looking(0.0, 0.0, 40f64.to_radians(), 1.0);
    let output = OutputParams { bloom: Bloom::Eye, ..OutputParams::default() };
    const SIDE: u32 = 512;
    let (at, peak) = (SIDE / 2, 1e6);
    let point = picture(SIDE, SIDE, |x, y| if (x, y) == (at, at) { [peak; 3] } else { [0.0; 3] });
    let spread = linear(&point, &output, &view);
    let kept = sum(&spread) / (3.0 * f64::from(peak));
    println!("a point keeps {kept:.5} of its light");
    assert!((kept - 1.0).abs() < 5e-3, "{kept}");
    let even = linear(&picture(333, 177, |_, _| [2.5; 3]), &output, &view);
    assert!(even.iter().all(|value| (value - 2.5).abs() < 1e-4));
    let degrees = view.degrees_per_pixel(SIDE);
    let solid_angle = degrees.to_radians().powi(2);
    for wanted in [0.5, 1.0, 2.0, 5.0, 10.0] {
        let (mut light, mut count) = (0.0, 0.0);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let r = f64::from(x.abs_diff(at)).hypot(f64::from(y.abs_diff(at))) * degrees;
                if (r / wanted).ln().abs() < 0.1 {
                    light += f64::from(spread[(y * SIDE + x) as usize * 3]);
                    count += 1.0;
                }
            }
        }
        // Luminance of the veil over the illuminance of the point.
        let ours = light / count / (f64::from(peak) * solid_angle);
        let ratio = ours / glare_per_sr(wanted, 25.0, 0.5);
        println!("{wanted}°: {ours:.3} sr⁻¹, {ratio:.2} of the glare function");
        // A sum of blurs, each four times as wide as the last: steps, not a curve.
        assert!((0.5..2.0).contains(&ratio), "{wanted}°: {ratio}");
    }
}

#[test]
fn odd_sizes_and_bad_numbers_stay_finite() {
    let view = View::looking(0.0, 0.0, 1.0, 1.0);
    let output = OutputParams { bloom: Bloom::OldEye, acuity: true, ..OutputParams::default() };
    for (width, height) in [(1, 1), (3, 1), (1, 7), (17, 33), (64, 64)] {
        let broken = picture(width, height, |x, y| match (x + 3 * y) % 7 {
            0 => [f32::NAN, 1.0, f32::INFINITY],
            1 => [-f32::INFINITY, -5.0, 1e38],
            _ => [1.0; 3],
        });
        let rgb = linear(&broken, &output, &view);
        assert_eq!(rgb.len(), 3 * (width * height) as usize);
        assert!(rgb.iter().all(|value| value.is_finite() && *value >= 0.0), "{width}x{height}");
        finish(gpu(), &broken, &output, &view, Output::Display).unwrap();
    }
    let none = picture(0, 0, |_, _| [0.0; 3]);
    assert!(finish(gpu(), &none, &output, &view, Output::Display).is_err());
}

/// Fine stripes are seen by day and not under the stars; what they are blurred to has their mean.
#[test]
fn dim_light_is_blurred() {
    // Two pixels a stripe at 0.05° each: 5 cycles per degree.
    let view = View::looking(0.0, 0.0, 12.8f64.to_radians(), 1.0);
    let contrast = |luminance: f32| {
        let stripes = picture(256, 256, |x, _| [luminance * if x / 2 % 2 == 0 { 1.5 } else { 0.5 }; 3]);
        let rgb = linear(&stripes, &OutputParams { acuity: true, ..OutputParams::default() }, &view);
        let row: Vec<f64> = (96..160).map(|x| f64::from(rgb[(128 * 256 + x) * 3] / luminance)).collect();
        let mean = row.iter().sum::<f64>() / row.len() as f64;
        assert!((mean - 1.0).abs() < 0.01, "{mean}");
        row.iter().fold(0.0, |most: f64, value| most.max((value - mean).abs()))
    };
    let (day, dusk, stars) = (contrast(1000.0), contrast(0.03), contrast(3e-4));
    println!("contrast of 5 cycles per degree: {day:.3} by day, {dusk:.3} at dusk, {stars:.4} under the stars");
    assert!(day > 0.49 && dusk < day && stars < 0.1);
}

/// Without bloom the pass is exposure's end alone: its twin, within a step.
#[test]
fn the_end_of_the_picture_is_the_same() {
    let view = View::looking(0.0, 0.0, 1.0, 1.0);
    for &tonemap in Tonemap::ALL {
        let output = OutputParams { tonemap, exposure: Some(Exposure::Ev100(3.0)), ..OutputParams::default() };
        let mut made = picture(40, 30, |x, y| [x as f32 * 0.05, y as f32 * 0.04, (x * y) as f32 * 1e-3]);
        made.exposure = 0.1;
        let Pixels::Display(ours) = finish(gpu(), &made, &output, &view, Output::Display).unwrap().pixels else {
            unreachable!()
        };
        let Pixels::Radiance(rgb) = &made.pixels else { unreachable!() };
        for (i, (a, b)) in ours.chunks_exact(3).zip(rgb.chunks_exact(3)).enumerate() {
            let colour = DVec3::new(f64::from(b[0]), f64::from(b[1]), f64::from(b[2]));
            let twin = display_rgb(&output, colour, 0.1, [i as u32 % 40, i as u32 / 40]);
            assert!((0..3).all(|k| a[k].abs_diff(twin[k]) <= 1), "{tonemap:?} {i}: {a:?} {twin:?}");
        }
    }
}
