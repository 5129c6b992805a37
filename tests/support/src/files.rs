//! Pictures in memory and as files: PNG for looks, OpenEXR for radiance.
//!
//! EXR goldens are small on purpose: three half floats a pixel, ZIP-compressed in blocks of 16 rows.
//! A half has 11 significant bits (steps of at most 1/1024), reaches ±65504, and below 6.1e-5 only steps
//! of 6e-8. A photometric sky needs more than that at its ends (the Sun's disc is 1.9e9 cd/m²): values
//! beyond are clamped to ±65504, so a golden is blind there. Scale the picture before the check where that matters.

use crate::error::GoldenError;
use exr::prelude::*;
use half::f16;
use image::{ColorType, ImageDecoder, ImageEncoder};
use std::io::Cursor;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// The largest picture that is taken, 8192×8192 pixels: a broken header must not ask for all memory.
pub const MAX_PIXELS: usize = 1 << 26;

/// An RGB picture, row by row from the top; never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage<T> {
    width: usize,
    height: usize,
    rgb: Vec<T>,
}

/// A finished picture: 8-bit sRGB.
pub type Rgb8Image = RgbImage<u8>;

/// A picture in linear light: Rec. 709 primaries, any unit.
pub type RadianceImage = RgbImage<f32>;

impl<T: Copy> RgbImage<T> {
    /// A picture from its values; the size must be at least 1×1 and fit the values.
    pub fn new(width: usize, height: usize, rgb: Vec<T>) -> std::result::Result<Self, GoldenError> {
        let pixels = width.checked_mul(height).filter(|p| (1..=MAX_PIXELS).contains(p));
        if pixels.map(|p| 3 * p) != Some(rgb.len()) {
            return Err(GoldenError::Shape { width, height, length: rgb.len() });
        }
        Ok(RgbImage { width, height, rgb })
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// All values, three a pixel.
    pub fn rgb(&self) -> &[T] {
        &self.rgb
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> impl Iterator<Item = [T; 3]> + '_ {
        self.rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2]])
    }
}

impl RadianceImage {
    /// The picture as a golden keeps it: every value rounded to half precision and clamped to ±65504.
    ///
    /// NaN stays NaN and infinities become ±65504; checks refuse both before they come here.
    pub fn rounded_to_half(&self) -> RadianceImage {
        RadianceImage { rgb: self.rgb.iter().map(|&v| half_from_f32(v).to_f32()).collect(), ..*self }
    }
}

/// The nearest finite half.
fn half_from_f32(value: f32) -> f16 {
    f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()))
}

/// The bytes of a PNG; the same picture always gives the same bytes.
pub fn encode_png(picture: &Rgb8Image) -> std::result::Result<Vec<u8>, GoldenError> {
    let mut bytes = Vec::new();
    // Both sides are at most MAX_PIXELS, which fits u32.
    let (width, height) = (picture.width as u32, picture.height as u32);
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&picture.rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|e| GoldenError::Encode(e.to_string()))?;
    Ok(bytes)
}

/// A picture from the bytes of an 8-bit grey or RGB PNG; the error is a clause without a path.
pub fn decode_png(bytes: &[u8]) -> std::result::Result<Rgb8Image, String> {
    let not_png = |e: image::ImageError| format!("not a whole PNG picture ({e})");
    let decoder = image::codecs::png::PngDecoder::new(Cursor::new(bytes)).map_err(not_png)?;
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize)?;
    let colour = decoder.color_type();
    if !matches!(colour, ColorType::Rgb8 | ColorType::L8) {
        return Err(format!("the PNG must be 8-bit RGB without transparency, it is {colour:?}"));
    }
    let rgb = image::DynamicImage::from_decoder(decoder).map_err(not_png)?.into_rgb8().into_raw();
    RgbImage::new(width as usize, height as usize, rgb).map_err(|e| e.to_string())
}

/// The bytes of a half-float OpenEXR file, see the module's page; the same picture always gives the same bytes.
pub fn encode_exr(picture: &RadianceImage) -> std::result::Result<Vec<u8>, GoldenError> {
    let pixel = |at: Vec2<usize>| {
        let i = 3 * (at.y() * picture.width + at.x());
        let [r, g, b] = [0, 1, 2].map(|c| half_from_f32(picture.rgb[i + c]));
        (r, g, b)
    };
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = (picture.width, picture.height);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, SpecificChannels::rgb(pixel));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel() // the order of blocks, and so the bytes, must not depend on threads
        .to_buffered(&mut bytes)
        .map_err(|e| GoldenError::Encode(e.to_string()))?;
    Ok(bytes.into_inner())
}

/// A picture from the bytes of an OpenEXR file with channels R, G and B of any type; the error is a clause without a path.
///
/// Uncompressed, RLE and ZIP only. The others lose light or, in `exr` 1.74, overflow on broken files (B44, found by
/// fuzzing with overflow checks).
pub fn decode_exr(bytes: &[u8]) -> std::result::Result<RadianceImage, String> {
    let not_exr = |e: exr::error::Error| format!("not a whole OpenEXR picture ({e})");
    // The header first: the reader below would reserve memory for whatever size a broken one claims.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(not_exr)?;
    for header in &meta.headers {
        check_size(header.layer_size.width(), header.layer_size.height())?;
        let plain = [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16];
        if !plain.contains(&header.compression) {
            let found = header.compression;
            return Err(format!("a golden is uncompressed, RLE or ZIP, this OpenEXR file is {found}"));
        }
    }
    let read = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![0f32; 3 * size.area()]),
            |(width, rgb): &mut (usize, Vec<f32>), at, (r, g, b): (f32, f32, f32)| {
                let i = 3 * (at.y() * *width + at.x());
                rgb[i..i + 3].copy_from_slice(&[r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(not_exr)?;
    let size = read.layer_data.size;
    let (_, rgb) = read.layer_data.channel_data.pixels;
    RgbImage::new(size.width(), size.height(), rgb).map_err(|e| e.to_string())
}

fn check_size(width: usize, height: usize) -> std::result::Result<(), String> {
    match width.checked_mul(height) {
        Some(1..=MAX_PIXELS) => Ok(()),
        _ => Err(format!("the picture claims {width}×{height} pixels, at most {MAX_PIXELS} are read")),
    }
}

/// Writes a file under a temporary name in its folder, made if need be, and renames it: no reader sees half a file.
pub fn write_whole(path: &Path, bytes: &[u8]) -> std::result::Result<(), GoldenError> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(GoldenError::io("make the folder", folder))?;
    let file_name = path.file_name().unwrap_or_default().to_string_lossy();
    let count = COUNTER.fetch_add(1, Ordering::Relaxed);
    let temporary = folder.join(format!(".{file_name}.{}.{count}.tmp", std::process::id()));
    std::fs::write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, path)).map_err(|e| {
        let _ = std::fs::remove_file(&temporary); // the first error is the one to report
        GoldenError::io("write the file", path)(e)
    })
}

/// Removes a file that may not be there.
pub fn remove_if_there(path: &Path) -> std::result::Result<(), GoldenError> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(GoldenError::io("remove the file", path)(e)),
        _ => Ok(()),
    }
}
