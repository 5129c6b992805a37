//! How far apart two pictures in linear light are: relative error, pixel by pixel.

use crate::colour::luminance;
use crate::error::GoldenError;
use crate::files::RadianceImage;

/// What the comparison found.
#[derive(Clone, Debug, PartialEq)]
pub struct Radiance {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The error of each pixel, the largest of its channels, row by row from the top; infinite where not finite.
    pub map: Vec<f64>,
    /// The map in a few numbers.
    pub stats: RadianceStats,
}

/// A map of relative errors in a few numbers. A quantile is the smallest error that so many pixels do not exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceStats {
    /// Half of the pixels are no worse.
    pub median: f64,
    /// 99 % of the pixels are no worse.
    pub p99: f64,
    /// 99.9 % of the pixels are no worse.
    pub p999: f64,
    /// The worst pixel's error.
    pub max: f64,
    /// Column (from the left) and row (from the top) of the worst pixel, the first of several.
    pub worst: (usize, usize),
    /// Pixels that are NaN or infinite in either picture.
    pub non_finite: usize,
}

/// Compares two pictures by relative error.
///
/// e = |a − b| / max(|a|, |b|, f · median Y(reference))   per channel, 0 where a = b; a pixel has its worst channel's.
///
/// `floor_fraction`: f, the part of the reference's median luminance below which light counts as dark: there the
/// error is relative to the floor, so that the noise of a black channel does not drown the picture. f = 0 means none.
/// The median runs over the finite pixels of the reference and is taken as 0 where it is negative.
///
/// Laws tested: identical → 0; symmetric but for the floor; a gain of 1 + g gives g / (1 + g) in every pixel;
/// same when both are scaled; light against darkness 1, opposite signs at most 2; not finite → infinite.
pub fn compare_radiance(
    reference: &RadianceImage,
    test: &RadianceImage,
    floor_fraction: f64,
) -> Result<Radiance, GoldenError> {
    if reference.size() != test.size() {
        return Err(GoldenError::SizesDiffer { accepted: reference.size(), new: test.size() });
    }
    if !(floor_fraction.is_finite() && floor_fraction >= 0.0) {
        return Err(GoldenError::Tolerance { field: "floor", value: floor_fraction });
    }
    let floor = floor_fraction * median_luminance(reference).max(0.0);
    let map: Vec<f64> = reference
        .rgb()
        .chunks_exact(3)
        .zip(test.rgb().chunks_exact(3))
        .map(|(a, b)| (0..3).map(|c| relative_error(a[c].into(), b[c].into(), floor)).fold(0.0, f64::max))
        .collect();
    let stats = stats(&map, reference.width());
    Ok(Radiance { width: reference.width(), height: reference.height(), map, stats })
}

fn relative_error(a: f64, b: f64, floor: f64) -> f64 {
    if !(a.is_finite() && b.is_finite()) {
        f64::INFINITY
    } else if a == b {
        0.0 // also where all three of a, b and the floor are 0
    } else {
        (a - b).abs() / a.abs().max(b.abs()).max(floor)
    }
}

/// The median luminance of the finite pixels; 0 when there are none.
fn median_luminance(picture: &RadianceImage) -> f64 {
    let mut y: Vec<f64> = picture.pixels().map(|p| luminance(p.map(f64::from))).filter(|y| y.is_finite()).collect();
    y.sort_by(f64::total_cmp);
    quantile(&y, 0.5)
}

fn stats(map: &[f64], width: usize) -> RadianceStats {
    let mut sorted = map.to_vec();
    sorted.sort_by(f64::total_cmp);
    let max = quantile(&sorted, 1.0);
    let worst = map.iter().position(|&e| e == max).unwrap_or(0);
    RadianceStats {
        median: quantile(&sorted, 0.5),
        p99: quantile(&sorted, 0.99),
        p999: quantile(&sorted, 0.999),
        max,
        worst: (worst % width.max(1), worst / width.max(1)),
        non_finite: map.iter().filter(|e| e.is_infinite()).count(),
    }
}

/// The smallest of the sorted values that at least `part` of them do not exceed; 0 of nothing.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let rank = (part * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(gain: f32) -> RadianceImage {
        RadianceImage::new(40, 25, (1..=3000).map(|i| i as f32 * gain).collect()).unwrap()
    }

    fn with(index: usize, value: f32) -> RadianceImage {
        let mut rgb = ramp(1.0).rgb().to_vec();
        rgb[index] = value;
        RadianceImage::new(40, 25, rgb).unwrap()
    }

    #[test]
    fn identical_pictures_have_no_error() {
        let found = compare_radiance(&ramp(1.0), &ramp(1.0), 0.01).unwrap().stats;
        assert_eq!((found.max, found.non_finite), (0.0, 0));
    }

    #[test]
    fn a_gain_is_seen_in_every_pixel() {
        let found = compare_radiance(&ramp(1.0), &ramp(1.25), 0.0).unwrap().stats;
        assert!((found.median - 0.2).abs() < 1e-6 && (found.max - 0.2).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn quantiles_count_pixels() {
        let mut rgb = ramp(1.0).rgb().to_vec();
        // 5 of 1000 pixels lose half their light: more than 0.1 %, less than 1 %.
        rgb[1500..1515].iter_mut().for_each(|v| *v *= 0.5);
        let changed = RadianceImage::new(40, 25, rgb).unwrap();
        let found = compare_radiance(&ramp(1.0), &changed, 0.01).unwrap().stats;
        assert_eq!((found.median, found.p99, found.p999, found.max), (0.0, 0.0, 0.5, 0.5));
        assert_eq!(found.worst, (500 % 40, 500 / 40));
    }

    #[test]
    fn scale_does_not_matter_and_the_floor_follows_the_reference() {
        let (a, b) = (ramp(1.0), with(0, 1.5));
        let plain = compare_radiance(&a, &b, 0.01).unwrap().stats;
        // The darkest channel is 1, the median luminance about 1500: the floor is 15 and the error 0.5 / 15.
        assert!((plain.max - 0.5 / 15.0).abs() < 1e-3, "{plain:?}");
        let scale =
            |p: &RadianceImage| RadianceImage::new(40, 25, p.rgb().iter().map(|v| v * 4096.0).collect()).unwrap();
        assert_eq!(compare_radiance(&scale(&a), &scale(&b), 0.01).unwrap().stats, plain);
        let without = compare_radiance(&a, &b, 0.0).unwrap();
        assert_eq!(without, compare_radiance(&b, &a, 0.0).unwrap(), "symmetric without a floor");
        assert!((without.stats.max - 0.5 / 1.5).abs() < 1e-6);
    }

    #[test]
    fn darkness_against_light_is_1_and_opposite_signs_at_most_2() {
        let flat = |v: f32| RadianceImage::new(2, 2, vec![v; 12]).unwrap();
        let max = |a, b| compare_radiance(&flat(a), &flat(b), 0.01).unwrap().stats.max;
        assert_eq!(max(0.0, 1e-30), 1.0);
        assert_eq!(max(3.0, -3.0), 2.0);
        assert_eq!(max(f32::MAX, f32::MIN), 2.0);
        assert_eq!(max(0.0, -0.0), 0.0);
    }

    #[test]
    fn one_bad_pixel_is_counted_wherever_it_is() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let pictures = (ramp(1.0), with(301, bad));
            for (a, b) in [(&pictures.0, &pictures.1), (&pictures.1, &pictures.0), (&pictures.1, &pictures.1)] {
                let found = compare_radiance(a, b, 0.01).unwrap().stats;
                assert_eq!((found.non_finite, found.max, found.worst), (1, f64::INFINITY, (20, 2)));
            }
        }
    }

    #[test]
    fn wrong_sizes_and_floors_are_errors() {
        let small = RadianceImage::new(1, 1, vec![0.0; 3]).unwrap();
        assert!(matches!(compare_radiance(&ramp(1.0), &small, 0.0), Err(GoldenError::SizesDiffer { .. })));
        for floor in [-1.0, f64::NAN, f64::INFINITY] {
            let outcome = compare_radiance(&small, &small, floor);
            assert!(matches!(outcome, Err(GoldenError::Tolerance { .. })));
        }
    }
}
