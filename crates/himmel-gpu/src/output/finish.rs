//! Twin of the end of `sky_fragment` in `sky.wgsl`: from exposed colour to 8-bit sRGB.

use glam::DVec3;

use super::dither::triangular_noise;
use super::params::OutputParams;
use super::tonemap::tonemap;

/// A finished pixel: tone mapped, dithered, rounded.
///
/// `exposed`: linear Rec. 709, luminance times `exposure`.  `pixel`: column and row, which the noise depends on.
/// Laws tested: black stays black but for one step of noise; brighter is not darker; anything that is no number is black.
pub fn display_rgb(output: &OutputParams, exposed: DVec3, exposure: f64, pixel: [u32; 2]) -> [u8; 3] {
    const STEPS: f64 = 255.0;
    // 1e30 keeps the tone mappers finite; what is no number is black.
    let colour = DVec3::from_array(exposed.to_array().map(|c| if c > 0.0 { c.min(1e30) } else { 0.0 }));
    let mut encoded = tonemap(output.tonemap, colour, exposure);
    if output.dither {
        encoded += DVec3::from_array(triangular_noise(pixel)) / STEPS;
    }
    encoded.to_array().map(|c| (c.clamp(0.0, 1.0) * STEPS).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::params::Tonemap;

    #[test]
    fn pixels_rise_and_stay_finite() {
        for dither in [true, false] {
            let output = OutputParams { dither, tonemap: Tonemap::Linear, ..OutputParams::default() };
            let grey = |value: f64| display_rgb(&output, DVec3::splat(value), 1.0, [3, 4])[1];
            assert!(grey(0.0) <= 1 && grey(f64::NAN) <= 1 && grey(-5.0) <= 1);
            assert_eq!(grey(f64::INFINITY), 255);
            assert!((0..100).all(|i| grey(f64::from(i + 1) / 100.0) >= grey(f64::from(i) / 100.0)));
        }
        let output = OutputParams { dither: false, tonemap: Tonemap::Linear, ..OutputParams::default() };
        assert_eq!(display_rgb(&output, DVec3::splat(0.21586), 1.0, [0, 0]), [128; 3]);
    }
}
