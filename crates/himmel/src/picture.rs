//! Pictures as files: PNG, JPEG, OpenEXR, Radiance HDR.

use std::io::{BufWriter, Write};
use std::path::Path;

use himmel_gpu::{Gpu, Output, PassTimes, Picture, Pixels, Still};

use crate::error::{Error, Result};
use crate::model::SkyModel;
use crate::tables_cache::TablesCache;

/// File formats, told by the ending of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// 8-bit sRGB, lossless.
    Png,
    /// 8-bit sRGB, quality 92.
    Jpeg,
    /// 32-bit linear Rec. 709, cd m⁻² times exposure, ZIP.
    Exr,
    /// Shared-exponent linear Rec. 709.
    Hdr,
}

impl FileFormat {
    /// From a file's name.
    pub fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_lowercase();
        match ending.as_str() {
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "exr" => Ok(Self::Exr),
            "hdr" => Ok(Self::Hdr),
            _ => Err(Error::FileFormat { path: path.into() }),
        }
    }

    /// Whether it can hold a picture of that size.
    pub fn check_size(self, width: u32, height: u32) -> Result<()> {
        if self == Self::Jpeg && width.max(height) > 65_535 {
            return Err(Error::Camera(format!(
                "JPEG holds at most 65535 pixels on a side, got {width}x{height}; use .png"
            )));
        }
        Ok(())
    }

    /// What the renderer has to give.
    pub fn output(self) -> Output {
        match self {
            Self::Png | Self::Jpeg => Output::Display,
            Self::Exr | Self::Hdr => Output::Radiance,
        }
    }
}

/// Checks that a file can be created where it is wanted, before any work is done.
pub fn check_writable(path: &Path) -> Result<()> {
    let error = |reason: String| Error::Write { path: path.into(), reason };
    let folder = folder_of(path);
    if path.is_dir() {
        return Err(error("it is a folder; give the name of a file".into()));
    }
    match std::fs::metadata(folder) {
        Ok(metadata) if metadata.is_dir() => match tempfile::tempfile_in(folder) {
            Ok(_) => Ok(()),
            Err(source) => Err(error(format!("the folder {} takes no files: {source}", folder.display()))),
        },
        Ok(_) => Err(error(format!("{} is not a folder", folder.display()))),
        Err(source) if source.kind() == std::io::ErrorKind::NotFound => {
            Err(error(format!("the folder {} does not exist", folder.display())))
        }
        Err(source) => Err(error(source.to_string())),
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Renders a model's picture. `progress` is told the share done and answers whether to go on.
pub fn render(gpu: &Gpu, model: &SkyModel, output: Output, progress: &mut dyn FnMut(f64) -> bool) -> Result<Picture> {
    render_with(gpu, model, output, None, progress)
}

/// As [`render`], with the air's tables from a cache where they are there, and written to it where they are not.
pub fn render_with(
    gpu: &Gpu,
    model: &SkyModel,
    output: Output,
    cache: Option<&TablesCache>,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Picture> {
    let (view, mut frame) = (model.view()?, model.frame()?);
    let size = &model.scene().output;
    let post = size.has_post();
    if post {
        // Linear, exposed as the finished picture.
        frame.output.exposure = Some(frame.output.exposure_for(output));
    }
    let mut still = Still::new(gpu, if post { Output::Radiance } else { output }, model.atmosphere())?;
    still.renderer().set_far_airs(&model.far_airs())?;
    let cached = cache.is_some_and(|cache| cache.load(still.renderer()));
    let picture = still.render(&frame, &view, size.width_px, size.height_px, progress)?;
    if let (Some(cache), false) = (cache, cached)
        && let Err(error) = cache.store(still.renderer())
    {
        tracing::warn!(%error, "the air's tables are not saved");
    }
    if post { Ok(himmel_gpu::output::bloom::finish(gpu, &picture, size, &view, output)?) } else { Ok(picture) }
}

/// Times of a picture's passes: the medians over several frames.
pub fn pass_medians(gpu: &Gpu, model: &SkyModel, output: Output, frames: usize) -> Result<PassTimes> {
    let view = model.view()?;
    let mut still = Still::new(gpu, output, model.atmosphere())?;
    still.renderer().set_far_airs(&model.far_airs())?;
    let size = &model.scene().output;
    let mut all: Vec<(&'static str, Vec<f64>)> = Vec::new();
    // The first frame compiles and warms up.
    for index in 0..=frames.max(1) {
        let picture = still.render(&model.frame()?, &view, size.width_px, size.height_px, &mut |_| true)?;
        for (label, ms) in picture.times.passes {
            match all.iter_mut().find(|(known, _)| *known == label) {
                _ if index == 0 => {}
                Some((_, times)) => times.push(ms),
                None => all.push((label, vec![ms])),
            }
        }
    }
    let median = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    Ok(PassTimes { passes: all.into_iter().map(|(label, times)| (label, median(times))).collect() })
}

/// Writes a picture under a temporary name in the same folder and renames it: a file is there whole or not at all.
pub fn save(picture: &Picture, path: &Path) -> Result<()> {
    save_with_errors(picture, None, path)
}

/// As [`save`]; an OpenEXR file also gets a channel `Y.error` with the standard error of each pixel's luminance, in the
/// picture's unit (cd m⁻² times exposure). Other formats have no place for it.
pub fn save_with_errors(picture: &Picture, errors: Option<&[f32]>, path: &Path) -> Result<()> {
    let format = FileFormat::of(path)?;
    format.check_size(picture.width, picture.height)?;
    write_whole(path, |writer| encode(picture, errors, format, writer))
}

/// Writes bytes in the same way.
pub fn save_bytes(bytes: &[u8], path: &Path) -> Result<()> {
    write_whole(path, |writer| writer.write_all(bytes).map_err(|e| e.to_string()))
}

fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<tempfile::NamedTempFile>) -> std::result::Result<(), String>,
) -> Result<()> {
    let error = |reason: String| Error::Write { path: path.into(), reason };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".himmel-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As a program that opens the file itself would: the umask takes its share.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder_of(path)).map_err(|e| error(e.kind().to_string()))?;
    let mut writer = BufWriter::new(file);
    write(&mut writer).map_err(&error)?;
    writer.flush().map_err(|e| error(e.to_string()))?;
    let file = writer.into_inner().map_err(|e| error(e.to_string()))?;
    file.as_file().sync_all().map_err(|e| error(e.to_string()))?;
    file.persist(path).map_err(|e| error(e.error.to_string()))?;
    Ok(())
}

fn encode(
    picture: &Picture,
    errors: Option<&[f32]>,
    format: FileFormat,
    writer: &mut (impl Write + std::io::Seek),
) -> std::result::Result<(), String> {
    use image::ImageEncoder;
    let (width, height) = (picture.width, picture.height);
    let count = match &picture.pixels {
        Pixels::Display(rgb) => rgb.len(),
        Pixels::Radiance(rgb) => rgb.len(),
    };
    // Encoders panic on less.
    if count as u64 != 3 * u64::from(width) * u64::from(height) || count == 0 {
        return Err(format!("a picture of {width}x{height} needs three values for each pixel, got {count} in all"));
    }
    if errors.is_some_and(|errors| 3 * errors.len() != count) {
        return Err("there must be one error for each pixel".into());
    }
    match (format, &picture.pixels) {
        (FileFormat::Png, Pixels::Display(rgb)) => image::codecs::png::PngEncoder::new(writer)
            .write_image(rgb, width, height, image::ExtendedColorType::Rgb8)
            .map_err(|e| e.to_string()),
        (FileFormat::Jpeg, Pixels::Display(rgb)) => image::codecs::jpeg::JpegEncoder::new_with_quality(writer, 92)
            .write_image(rgb, width, height, image::ExtendedColorType::Rgb8)
            .map_err(|e| e.to_string()),
        (FileFormat::Hdr, Pixels::Radiance(rgb)) => {
            let pixels: Vec<image::Rgb<f32>> =
                rgb.chunks_exact(3).map(|p| image::Rgb([p[0].max(0.0), p[1].max(0.0), p[2].max(0.0)])).collect();
            image::codecs::hdr::HdrEncoder::new(writer)
                .encode(&pixels, width as usize, height as usize)
                .map_err(|e| e.to_string())
        }
        (FileFormat::Exr, Pixels::Radiance(rgb)) => encode_exr(picture, rgb, errors, writer),
        _ => Err("the picture was rendered for another kind of file".into()),
    }
}

fn encode_exr(
    picture: &Picture,
    rgb: &[f32],
    errors: Option<&[f32]>,
    writer: &mut (impl Write + std::io::Seek),
) -> std::result::Result<(), String> {
    use exr::prelude::*;
    let channel = |name: &str, samples: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(samples));
    let colour = |name, offset| channel(name, rgb.iter().skip(offset).step_by(3).copied().collect());
    let mut channels = AnyChannels::sort([colour("R", 0), colour("G", 1), colour("B", 2)].into_iter().collect());
    if let Some(errors) = errors {
        // After R in the order of names that the format wants.
        channels.list.push(channel("Y.error", errors.to_vec()));
    }
    let mut attributes = LayerAttributes::named("");
    attributes.software_name = Some(Text::from("himmel"));
    // Luminance of a pixel (1, 1, 1) in cd/m².
    attributes.white_luminance = Some((1.0 / picture.exposure) as f32);
    // Blocks in order, however many threads compress them: the same picture is the same file.
    let encoding =
        Encoding { compression: Compression::ZIP16, line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };
    let size = (picture.width as usize, picture.height as usize);
    let mut layer = Layer::new(size, attributes, encoding, channels);
    layer.attributes.layer_name = None;
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(exr::meta::attribute::Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    image.write().to_buffered(writer).map_err(|e| e.to_string())
}
