//! Numbers as colours: heat maps of errors, radiance as something a screen can show, and sheets of both.

use crate::colour::{luminance, srgb8_from_linear};
use crate::error::GoldenError;
use crate::files::{MAX_PIXELS, RadianceImage, Rgb8Image};

/// Nine stops of Matplotlib's `magma` (CC0), black over red to pale yellow: lightness grows evenly, so it reads in grey too.
const MAGMA: [[f64; 3]; 9] = [
    [0.0, 0.0, 4.0],
    [28.0, 16.0, 68.0],
    [79.0, 18.0, 123.0],
    [129.0, 37.0, 129.0],
    [181.0, 54.0, 122.0],
    [229.0, 80.0, 100.0],
    [251.0, 135.0, 97.0],
    [254.0, 194.0, 135.0],
    [252.0, 253.0, 191.0],
];

/// Pixels that are not finite: no colour of the ramp is green.
const NOT_FINITE: [u8; 3] = [0, 255, 0];

/// The smallest relative error that is not black in [`relative_heat`]: below it lies the rounding of half floats.
const SMALLEST_SHOWN: f64 = 1e-4;

/// Around and instead of pictures on a sheet.
const PAPER: u8 = 64;

/// Pixels between the pictures of a sheet.
const GAP: usize = 8;

/// The colour of `t` in 0..=1, clamped; green where it is not finite.
fn magma(t: f64) -> [u8; 3] {
    if !t.is_finite() {
        return NOT_FINITE;
    }
    let x = t.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f64;
    let low = (x as usize).min(MAGMA.len() - 2);
    let part = x - low as f64;
    [0, 1, 2].map(|c| (MAGMA[low][c] + part * (MAGMA[low + 1][c] - MAGMA[low][c])).round() as u8)
}

/// A map of FLIP errors, 0..=1 from black to pale yellow.
pub fn flip_heat(width: usize, height: usize, map: &[f64]) -> Result<Rgb8Image, GoldenError> {
    Rgb8Image::new(width, height, map.iter().flat_map(|&e| magma(e)).collect())
}

/// A map of relative errors on a logarithmic scale, 1e-4 black to 1 pale yellow; green where not finite.
pub fn relative_heat(width: usize, height: usize, map: &[f64]) -> Result<Rgb8Image, GoldenError> {
    let part = |e: f64| {
        if e == 0.0 { 0.0 } else { 1.0 - e.log10() / SMALLEST_SHOWN.log10() }
    };
    Rgb8Image::new(width, height, map.iter().flat_map(|&e| magma(part(e))).collect())
}

/// The exposure that puts the picture's log-average luminance at middle grey, 0.18; 1 where nothing shines.
///
/// k = 0.18 / exp(mean ln Y)     [reinhard2002tone, eq. 1 and 2], over the pixels with finite Y > 0
pub fn exposure_of(picture: &RadianceImage) -> f64 {
    let (sum, count) = picture
        .pixels()
        .map(|p| luminance(p.map(f64::from)))
        .filter(|y| y.is_finite() && *y > 0.0)
        .fold((0.0, 0u32), |(sum, count), y| (sum + y.ln(), count + 1));
    if count == 0 { 1.0 } else { 0.18 / (sum / f64::from(count)).exp() }
}

/// Linear light for a screen: each channel k v / (1 + k v), then sRGB     [reinhard2002tone, eq. 3]
///
/// Good enough to see what changed; what a finished picture looks like is tested as PNG. Green where not finite.
pub fn tone_mapped(picture: &RadianceImage, exposure: f64) -> Rgb8Image {
    let tone = |v: f32| {
        let x = exposure * f64::from(v).max(0.0);
        srgb8_from_linear(x / (1.0 + x))
    };
    let pixel = |p: [f32; 3]| {
        if p.iter().all(|v| v.is_finite()) { p.map(tone) } else { NOT_FINITE }
    };
    let rgb = picture.pixels().flat_map(pixel).collect();
    Rgb8Image::new(picture.width(), picture.height(), rgb).expect("as many pixels as the picture has")
}

/// Pictures side by side, top-aligned; grey paper of the given size where one is missing.
pub fn sheet(panels: &[Option<Rgb8Image>], missing: (usize, usize)) -> Result<Rgb8Image, GoldenError> {
    let size = |p: &Option<Rgb8Image>| p.as_ref().map_or(missing, Rgb8Image::size);
    let width = panels.iter().map(|p| size(p).0 + GAP).sum::<usize>().saturating_sub(GAP);
    let height = panels.iter().map(|p| size(p).1).max().unwrap_or(0);
    if width.saturating_mul(height) > MAX_PIXELS {
        return Err(GoldenError::Shape { width, height, length: 0 }); // before the memory is asked for
    }
    let mut rgb = vec![PAPER; 3 * width * height];
    let mut left = 0;
    for panel in panels {
        if let Some(picture) = panel {
            for (y, row) in picture.rgb().chunks_exact(3 * picture.width()).enumerate() {
                let start = 3 * (y * width + left);
                rgb[start..start + row.len()].copy_from_slice(row);
            }
        }
        left += size(panel).0 + GAP;
    }
    Rgb8Image::new(width, height, rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_runs_from_black_to_pale_yellow_and_shows_nan_in_green() {
        let map = [0.0, 1.0, 1e-4, f64::INFINITY, 2.0, f64::NAN];
        let heat = relative_heat(6, 1, &map).unwrap();
        let pixels: Vec<_> = heat.pixels().collect();
        assert_eq!(pixels[0], [0, 0, 4]);
        assert_eq!(pixels[1], [252, 253, 191]);
        assert_eq!(pixels[2], [0, 0, 4]);
        assert_eq!(pixels[3], NOT_FINITE);
        assert_eq!(pixels[4], [252, 253, 191]);
        assert_eq!(pixels[5], NOT_FINITE);
    }

    #[test]
    fn a_flat_picture_becomes_middle_grey_whatever_its_unit() {
        for light in [2e-4, 1.0, 6e4] {
            let flat = RadianceImage::new(2, 1, vec![light; 6]).unwrap();
            let shown = tone_mapped(&flat, exposure_of(&flat));
            assert_eq!(shown.rgb(), [srgb8_from_linear(0.18 / 1.18); 6]);
        }
        let black = RadianceImage::new(1, 1, vec![0.0, -1.0, f32::NAN]).unwrap();
        assert_eq!(tone_mapped(&black, exposure_of(&black)).rgb(), NOT_FINITE);
    }

    #[test]
    fn a_sheet_keeps_every_pixel_in_place() {
        let red = Rgb8Image::new(2, 1, [255, 0, 0].repeat(2)).unwrap();
        let blue = Rgb8Image::new(1, 3, [0, 0, 255].repeat(3)).unwrap();
        let all = sheet(&[Some(red), None, Some(blue)], (4, 2)).unwrap();
        assert_eq!(all.size(), (2 + 8 + 4 + 8 + 1, 3));
        let at = |x: usize, y: usize| all.pixels().nth(y * 23 + x).unwrap();
        assert_eq!((at(1, 0), at(1, 1), at(12, 0)), ([255, 0, 0], [PAPER; 3], [PAPER; 3]));
        assert_eq!((at(22, 0), at(22, 2)), ([0, 0, 255], [0, 0, 255]));
    }
}
