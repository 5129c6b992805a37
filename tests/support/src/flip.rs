//! LDR-FLIP: how different two pictures look when one flips between them   [andersson2020flip]
//!
//! Both pictures are blurred by the eye's contrast sensitivity, compared as colours, and the colour
//! difference is raised where an edge or a point is in one picture and not in the other.
//! Our own implementation from the paper's equations, in f64. Every two-dimensional kernel of the paper
//! is a sum of products of one-dimensional ones, so that all filters run along rows and then columns.
//! Pictures continue beyond their border with the border's pixel.
//!
//! Checked against NVIDIA's own C++ implementation to 3e-5: see `tests/flip_truth.rs`. 1280×720 takes about 0.7 s.

use crate::colour::{hunt_lab_from_linear, linear_from_srgb8, linear_from_ycxcz, ycxcz_from_linear};
use crate::error::GoldenError;
use crate::files::Rgb8Image;
use std::f64::consts::PI;

/// The paper's viewing condition: a 0.7 m wide display of 3840 pixels seen from 0.7 m.
///
/// p = d · (pixels / width) · π / 180 = 0.7 · 3840 / 0.7 · π / 180 = 67.02, rounded     [andersson2020flip, viewing conditions]
pub const DEFAULT_PIXELS_PER_DEGREE: f64 = 67.0;

/// The pixels per degree that are taken: below 1 the filters vanish, above 1000 they outgrow the pictures.
const PIXELS_PER_DEGREE_RANGE: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// Exponent of the colour difference, which spreads small ones apart.     [andersson2020flip, colour pipeline]
const COLOUR_EXPONENT: f64 = 0.7;
/// The part of the largest colour difference below which the map is steep …
const STEEP_PART: f64 = 0.4;
/// … and the error that it reaches there.     [andersson2020flip, colour pipeline]
const STEEP_ERROR: f64 = 0.95;
/// Exponent of the feature difference.     [andersson2020flip, feature pipeline]
const FEATURE_EXPONENT: f64 = 0.5;
/// Width of the eye's edge detector in degrees.     [andersson2020flip, feature pipeline]
const FEATURE_WIDTH_DEGREES: f64 = 0.082;

/// What FLIP found.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The error of each pixel in 0..=1, row by row from the top.
    pub map: Vec<f64>,
    /// The map in three numbers.
    pub stats: FlipStats,
}

/// A FLIP map in three numbers, each in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlipStats {
    /// The mean error.
    pub mean: f64,
    /// The error that halves the sum of all errors: pixels above it carry as much as those below.
    pub weighted_median: f64,
    /// The largest error.
    pub max: f64,
}

/// Compares two pictures with LDR-FLIP at `pixels_per_degree` of the viewer's field (default 67).
///
/// ΔE = ΔE_c^(1 − ΔE_f)     [andersson2020flip, final difference]: colour difference ΔE_c, feature difference ΔE_f, all in 0..=1.
///
/// Laws tested: identical pictures give 0; symmetric; within 0..=1; black against white gives 0.96738
/// (grey differs less than the widest pair of the gamut, green against blue, which gives 1).
pub fn flip(reference: &Rgb8Image, test: &Rgb8Image, pixels_per_degree: f64) -> Result<Flip, GoldenError> {
    if !PIXELS_PER_DEGREE_RANGE.contains(&pixels_per_degree) {
        return Err(GoldenError::PixelsPerDegree(pixels_per_degree));
    }
    if (reference.width(), reference.height()) != (test.width(), test.height()) {
        return Err(GoldenError::SizesDiffer {
            accepted: (reference.width(), reference.height()),
            new: (test.width(), test.height()),
        });
    }
    let (a, b) = (Planes::new(reference), Planes::new(test));
    let (colour_a, colour_b) = (a.seen_colours(pixels_per_degree), b.seen_colours(pixels_per_degree));
    let (features_a, features_b) = (a.features(pixels_per_degree), b.features(pixels_per_degree));
    let largest = largest_colour_difference();
    let map: Vec<f64> = (0..a.y.len())
        .map(|i| {
            let colour = colour_error(colour_difference(colour_a[i], colour_b[i]), largest);
            let feature = feature_error(features_a[i], features_b[i]);
            colour.powf(1.0 - feature)
        })
        .collect();
    Ok(Flip { width: reference.width(), height: reference.height(), stats: stats(&map), map })
}

/// Mean, weighted median and maximum of a map.
fn stats(map: &[f64]) -> FlipStats {
    let mut sorted = map.to_vec();
    sorted.sort_by(f64::total_cmp);
    let sum: f64 = sorted.iter().sum();
    let mut carried = 0.0;
    let halves = sorted.iter().find(|&&e| {
        carried += e;
        carried >= 0.5 * sum
    });
    FlipStats {
        mean: sum / map.len().max(1) as f64,
        weighted_median: halves.copied().unwrap_or(0.0),
        max: sorted.last().copied().unwrap_or(0.0),
    }
}

/// HyAB distance of two Hunt-adjusted colours, raised to 0.7.
///
/// ΔE = (|ΔL| + √(Δa² + Δb²))^0.7     [andersson2020flip, colour pipeline]
fn colour_difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])).powf(COLOUR_EXPONENT)
}

/// The colour difference of pure green and pure blue, the widest pair of the sRGB gamut.
fn largest_colour_difference() -> f64 {
    colour_difference(hunt_lab_from_linear([0.0, 1.0, 0.0]), hunt_lab_from_linear([0.0, 0.0, 1.0]))
}

/// Squeezes a colour difference into 0..=1: linear up to 0.95 at 0.4 of the largest, linear again from there to 1.
fn colour_error(difference: f64, largest: f64) -> f64 {
    let knee = STEEP_PART * largest;
    let error = if difference < knee {
        STEEP_ERROR / knee * difference
    } else {
        STEEP_ERROR + (difference - knee) / (largest - knee) * (1.0 - STEEP_ERROR)
    };
    error.min(1.0) // rounding alone can take it past 1
}

/// The feature difference in 0..=1 from the (edge, point) strengths of both pictures.
///
/// ΔE_f = (max(|Δedge|, |Δpoint|) / √2)^0.5     [andersson2020flip, feature pipeline]
fn feature_error(a: [f64; 2], b: [f64; 2]) -> f64 {
    let difference = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    (difference / 2f64.sqrt()).powf(FEATURE_EXPONENT).min(1.0)
}

/// A picture as three planes of YCxCz.
struct Planes {
    width: usize,
    height: usize,
    y: Vec<f64>,
    cx: Vec<f64>,
    cz: Vec<f64>,
}

impl Planes {
    fn new(image: &Rgb8Image) -> Self {
        let linear: Vec<f64> = (0..=255).map(linear_from_srgb8).collect();
        let count = image.width() * image.height();
        let mut planes = Planes {
            width: image.width(),
            height: image.height(),
            y: Vec::with_capacity(count),
            cx: Vec::with_capacity(count),
            cz: Vec::with_capacity(count),
        };
        for pixel in image.rgb().chunks_exact(3) {
            let [y, cx, cz] = ycxcz_from_linear([pixel[0], pixel[1], pixel[2]].map(|c| linear[usize::from(c)]));
            planes.y.push(y);
            planes.cx.push(cx);
            planes.cz.push(cz);
        }
        planes
    }

    /// The colours that the eye resolves: each channel blurred by its contrast sensitivity, clamped to the gamut.
    ///
    /// s(x) = Σ a √(π/b) exp(−π² x² / b), x in degrees, normalised to 1     [andersson2020flip, spatial filtering]
    ///
    /// (a, b): achromatic (1, 0.0047); red–green (1, 0.0053); blue–yellow (34.1, 0.04) + (13.5, 0.025).
    fn seen_colours(&self, pixels_per_degree: f64) -> Vec<[f64; 3]> {
        let blur = |plane: &[f64], gaussians: &[(f64, f64)]| {
            let sum: f64 = gaussians.iter().map(|&g| csf_kernel(g, pixels_per_degree).1).sum();
            let mut blurred = vec![0.0; plane.len()];
            for &gaussian in gaussians {
                let (kernel, weight) = csf_kernel(gaussian, pixels_per_degree);
                let part = self.filter(plane, &kernel, &kernel);
                blurred.iter_mut().zip(part).for_each(|(all, p)| *all += p * weight / sum);
            }
            blurred
        };
        let y = blur(&self.y, &[(1.0, 0.0047)]);
        let cx = blur(&self.cx, &[(1.0, 0.0053)]);
        let cz = blur(&self.cz, &[(34.1, WIDEST_CSF_B), (13.5, 0.025)]);
        (0..y.len())
            .map(|i| hunt_lab_from_linear(linear_from_ycxcz([y[i], cx[i], cz[i]]).map(|c| c.clamp(0.0, 1.0))))
            .collect()
    }

    /// How strongly each pixel is an edge and a point: lengths of the gradients of the lightness in 0..=1.
    fn features(&self, pixels_per_degree: f64) -> Vec<[f64; 2]> {
        let lightness: Vec<f64> = self.y.iter().map(|y| (y + 16.0) / 116.0).collect();
        let kernels = FeatureKernels::new(pixels_per_degree);
        let length_of = |kernel: &[f64]| -> Vec<f64> {
            let along_x = self.filter(&lightness, kernel, &kernels.across);
            let along_y = self.filter(&lightness, &kernels.across, kernel);
            along_x.iter().zip(along_y).map(|(x, y)| x.hypot(y)).collect()
        };
        let (edges, points) = (length_of(&kernels.edge), length_of(&kernels.point));
        edges.into_iter().zip(points).map(|(e, p)| [e, p]).collect()
    }

    /// Filters a plane along rows with `kernel_x`, then along columns with `kernel_y`; borders repeat.
    fn filter(&self, plane: &[f64], kernel_x: &[f64], kernel_y: &[f64]) -> Vec<f64> {
        let (w, h) = (self.width, self.height);
        let mut rows = vec![0.0; plane.len()];
        let mut padded = Vec::new();
        let radius = kernel_x.len() / 2;
        for (source, target) in plane.chunks_exact(w).zip(rows.chunks_exact_mut(w)) {
            padded.clear();
            padded.extend(std::iter::repeat_n(source[0], radius));
            padded.extend_from_slice(source);
            padded.extend(std::iter::repeat_n(source[w - 1], radius));
            for (x, out) in target.iter_mut().enumerate() {
                *out = padded[x..].iter().zip(kernel_x).map(|(v, k)| v * k).sum();
            }
        }
        let mut columns = vec![0.0; plane.len()];
        let radius = kernel_y.len() / 2;
        for (y, target) in columns.chunks_exact_mut(w).enumerate() {
            for (k, weight) in kernel_y.iter().enumerate() {
                let from = (y + k).saturating_sub(radius).min(h - 1);
                let source = &rows[from * w..(from + 1) * w];
                target.iter_mut().zip(source).for_each(|(out, v)| *out += v * weight);
            }
        }
        columns
    }
}

/// The b of the widest contrast sensitivity, blue–yellow: it sets the radius of all kernels.
const WIDEST_CSF_B: f64 = 0.04;

/// A one-dimensional Gaussian exp(−π² x² / b) summing to 1, and the weight its square had as a · √(π/b) · Σ.
///
/// The radius is three standard deviations of the widest, r = ⌈3 √(b / (2π²)) p⌉     [andersson2020flip, colour pipeline]
fn csf_kernel((a, b): (f64, f64), pixels_per_degree: f64) -> (Vec<f64>, f64) {
    let radius = (3.0 * (WIDEST_CSF_B / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
    let mut kernel: Vec<f64> =
        (-radius..=radius).map(|i| (-(PI * i as f64 / pixels_per_degree).powi(2) / b).exp()).collect();
    let sum: f64 = kernel.iter().sum();
    kernel.iter_mut().for_each(|k| *k /= sum);
    (kernel, a * (PI / b).sqrt() * sum * sum)
}

/// The eye's detectors of edges and points: first and second derivative of a Gaussian, blurred across.
///
/// g = exp(−x²/2σ²);  edge −x g;  point (x²/σ² − 1) g;  σ = w p / 2; positive weights sum to 1, negative ones to −1
/// [andersson2020flip, feature pipeline]
struct FeatureKernels {
    edge: Vec<f64>,
    point: Vec<f64>,
    across: Vec<f64>,
}

impl FeatureKernels {
    fn new(pixels_per_degree: f64) -> Self {
        let sigma = 0.5 * FEATURE_WIDTH_DEGREES * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i64;
        let kernel = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let raw: Vec<f64> =
                (-radius..=radius).map(|i| f(i as f64) * (-(i as f64).powi(2) / (2.0 * sigma * sigma)).exp()).collect();
            let positive: f64 = raw.iter().filter(|k| **k > 0.0).sum();
            let negative: f64 = -raw.iter().filter(|k| **k < 0.0).sum::<f64>();
            raw.iter()
                .map(|k| {
                    if *k > 0.0 {
                        k / positive
                    } else if *k < 0.0 {
                        k / negative
                    } else {
                        0.0
                    }
                })
                .collect()
        };
        FeatureKernels {
            edge: kernel(&|x| -x),
            point: kernel(&|x| x * x / (sigma * sigma) - 1.0),
            across: kernel(&|_| 1.0),
        }
    }
}
