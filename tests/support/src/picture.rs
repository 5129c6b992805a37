//! The two kinds of golden as one: what a check, a review and an acceptance do with either.

use crate::error::GoldenError;
use crate::files::{RadianceImage, Rgb8Image, decode_exr, decode_png, encode_exr, encode_png};
use crate::flip::{DEFAULT_PIXELS_PER_DEGREE, FlipStats, flip};
use crate::heat::{exposure_of, flip_heat, relative_heat, tone_mapped};
use crate::radiance::{RadianceStats, compare_radiance};
use std::fmt;

/// What a golden is a picture of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Radiance in linear light, compared by relative error.
    Exr,
    /// A finished picture, compared by FLIP.
    Png,
}

impl Kind {
    /// Both kinds.
    pub const ALL: [Kind; 2] = [Kind::Exr, Kind::Png];

    /// The file name's ending, which is also how the kind is printed.
    pub fn extension(self) -> &'static str {
        match self {
            Kind::Exr => "exr",
            Kind::Png => "png",
        }
    }
}

/// How large the relative errors of a radiance golden may be, see [`compare_radiance`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The part of the accepted picture's median luminance below which light counts as dark.
    pub floor: f64,
    /// Largest median error.
    pub median: f64,
    /// Largest error that 99 % of the pixels may reach.
    pub p99: f64,
    /// Largest error that 99.9 % of the pixels may reach.
    pub p999: f64,
    /// Largest error of any pixel.
    pub max: f64,
}

impl Default for Tolerance {
    /// For one software rasteriser in two builds: rounding everywhere, a few pixels on the other side of an edge.
    ///
    /// The median of 0.002 is two steps of a half float.
    fn default() -> Self {
        Tolerance { floor: 0.01, median: 0.002, p99: 0.01, p999: 0.05, max: 0.25 }
    }
}

/// How large the FLIP errors of a finished picture may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlipTolerance {
    /// Largest mean error.
    pub mean: f64,
    /// Largest error of any pixel.
    pub max: f64,
}

impl Default for FlipTolerance {
    /// Even one step of all greys (0.03) or one star gone (0.4 where it was) fails; a few pixels of rounding pass.
    fn default() -> Self {
        FlipTolerance { mean: 0.005, max: 0.2 }
    }
}

/// The tolerance of either kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Limits {
    Exr(Tolerance),
    Png(FlipTolerance),
}

impl Limits {
    /// Names and values in the order in which they are written and reported.
    pub(crate) fn fields(&self) -> Vec<(&'static str, f64)> {
        match self {
            Limits::Exr(t) => {
                vec![("floor", t.floor), ("median", t.median), ("99 %", t.p99), ("99.9 %", t.p999), ("max", t.max)]
            }
            Limits::Png(t) => vec![("mean", t.mean), ("max", t.max)],
        }
    }

    /// The limits of the kind from values in the order of [`Limits::fields`].
    pub(crate) fn from_values(kind: Kind, values: &[f64]) -> Option<Self> {
        match (kind, values) {
            (Kind::Exr, &[floor, median, p99, p999, max]) => {
                Some(Limits::Exr(Tolerance { floor, median, p99, p999, max }))
            }
            (Kind::Png, &[mean, max]) => Some(Limits::Png(FlipTolerance { mean, max })),
            _ => None,
        }
    }

    /// Refuses limits that nothing or everything would pass.
    pub(crate) fn validate(&self) -> Result<(), GoldenError> {
        match self.fields().into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            Some((field, value)) => Err(GoldenError::Tolerance { field, value }),
            None => Ok(()),
        }
    }
}

/// The numbers of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers {
    /// Relative errors of radiance.
    Radiance(RadianceStats),
    /// FLIP errors of a finished picture.
    Flip(FlipStats),
}

impl Numbers {
    /// What lies beyond the limits, as a clause; `None` where all is within. NaN is never within.
    pub(crate) fn beyond(&self, limits: &Limits) -> Option<String> {
        let measured: Vec<f64> = match self {
            Numbers::Radiance(s) => vec![0.0, s.median, s.p99, s.p999, s.max], // the floor is no measurement
            Numbers::Flip(s) => vec![s.mean, s.max],
        };
        let beyond: Vec<String> = limits
            .fields()
            .into_iter()
            .zip(measured)
            .filter(|((_, allowed), found)| found.partial_cmp(allowed).is_none_or(|o| o.is_gt()))
            .map(|((name, allowed), found)| format!("{name} {found:.4} where {allowed} is allowed"))
            .collect();
        let place = match self {
            Numbers::Radiance(s) => format!(" (worst at x {}, y {})", s.worst.0, s.worst.1),
            Numbers::Flip(_) => String::new(),
        };
        let kind = if matches!(self, Numbers::Radiance(_)) { "relative error" } else { "FLIP" };
        (!beyond.is_empty()).then(|| format!("it differs: {kind} {}{place}", beyond.join(", ")))
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Numbers::Radiance(s) => {
                write!(f, "median {:.5}  99 % {:.5}  99.9 % {:.5}  max {:.5}", s.median, s.p99, s.p999, s.max)?;
                if s.non_finite > 0 { write!(f, "  not finite {}", s.non_finite) } else { Ok(()) }
            }
            Numbers::Flip(s) => {
                write!(f, "mean {:.5}  weighted median {:.5}  max {:.5}", s.mean, s.weighted_median, s.max)
            }
        }
    }
}

/// A picture of either kind.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Picture {
    Exr(RadianceImage),
    Png(Rgb8Image),
}

impl Picture {
    pub(crate) fn decode(kind: Kind, bytes: &[u8]) -> Result<Self, String> {
        match kind {
            Kind::Exr => decode_exr(bytes).map(Picture::Exr),
            Kind::Png => decode_png(bytes).map(Picture::Png),
        }
    }

    pub(crate) fn encode(&self) -> Result<Vec<u8>, GoldenError> {
        match self {
            Picture::Exr(picture) => encode_exr(picture),
            Picture::Png(picture) => encode_png(picture),
        }
    }

    pub(crate) fn size(&self) -> (usize, usize) {
        match self {
            Picture::Exr(picture) => picture.size(),
            Picture::Png(picture) => picture.size(),
        }
    }

    /// The indices of the pixels that are NaN or infinite.
    pub(crate) fn non_finite(&self) -> Vec<usize> {
        match self {
            Picture::Exr(picture) => {
                picture.pixels().enumerate().filter(|(_, p)| !p.iter().all(|v| v.is_finite())).map(|(i, _)| i).collect()
            }
            Picture::Png(_) => Vec::new(),
        }
    }

    /// The exposure at which to show this picture and others beside it.
    pub(crate) fn exposure(&self) -> f64 {
        match self {
            Picture::Exr(picture) => exposure_of(picture),
            Picture::Png(_) => 1.0,
        }
    }

    /// The picture for a screen; a PNG as it is.
    pub(crate) fn shown(&self, exposure: f64) -> Rgb8Image {
        match self {
            Picture::Exr(picture) => tone_mapped(picture, exposure),
            Picture::Png(picture) => picture.clone(),
        }
    }
}

/// Numbers and heat map of two pictures of the same kind and size.
pub(crate) fn compare(accepted: &Picture, new: &Picture, limits: &Limits) -> Result<(Numbers, Rgb8Image), GoldenError> {
    match (accepted, new) {
        (Picture::Exr(a), Picture::Exr(b)) => {
            let floor = if let Limits::Exr(t) = limits { t.floor } else { 0.0 };
            let found = compare_radiance(a, b, floor)?;
            Ok((Numbers::Radiance(found.stats), relative_heat(found.width, found.height, &found.map)?))
        }
        (Picture::Png(a), Picture::Png(b)) => {
            let found = flip(a, b, DEFAULT_PIXELS_PER_DEGREE)?;
            Ok((Numbers::Flip(found.stats), flip_heat(found.width, found.height, &found.map)?))
        }
        // Kinds come from file endings, so this needs a caller's mistake; sizes are the nearest sentence.
        _ => Err(GoldenError::SizesDiffer { accepted: accepted.size(), new: new.size() }),
    }
}
