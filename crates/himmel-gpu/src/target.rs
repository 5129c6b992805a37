//! What the sky is drawn into.

use wgpu::TextureFormat;

use crate::error::GpuError;

/// Which depth value lies at infinity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthDirection {
    /// 0 near, 1 far.
    Standard,
    /// 1 near, 0 far.
    Reversed,
}

/// What is written into the colour attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Scene-linear Rec. 709: luminance in cd m⁻² times the exposure factor, which is 1 unless
    /// someone chooses an [`Exposure`](crate::Exposure).
    /// Needs a float format. Values are clamped to what it holds (65,504 for 16-bit floats; the Sun's disc has 1.9e9 cd m⁻²).
    Radiance,
    /// Finished colour: exposed, tone mapped, display-encoded (by the format itself if it is an sRGB one), dithered.
    Display,
}

/// The host's render pass: formats, depth convention, samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Format of the first colour attachment.
    pub colour: TextureFormat,
    /// Format and direction of the depth attachment, if the pass has one. The sky tests it and does not write it.
    pub depth: Option<(TextureFormat, DepthDirection)>,
    /// Samples per pixel of the pass: 1 without multisampling.
    pub samples: u32,
    /// What is written.
    pub output: Output,
}

impl Target {
    /// A target without depth and multisampling.
    pub fn new(colour: TextureFormat, output: Output) -> Self {
        Self { colour, depth: None, samples: 1, output }
    }

    /// The largest finite value of a channel; `None` if the format cannot be drawn to.
    pub(crate) fn largest(&self) -> Option<f32> {
        use TextureFormat as F;
        Some(match self.colour {
            F::Rgba16Float => 65504.0,
            F::Rg11b10Ufloat => 64512.0,
            F::Rgba32Float => f32::MAX,
            F::Rgba8Unorm | F::Rgba8UnormSrgb | F::Bgra8Unorm | F::Bgra8UnormSrgb | F::Rgb10a2Unorm => 1.0,
            _ => return None,
        })
    }

    /// Steps between 0 and 1, for dithering; 0 for float formats.
    pub(crate) fn levels(&self) -> f32 {
        use TextureFormat as F;
        match self.colour {
            F::Rgba8Unorm | F::Rgba8UnormSrgb | F::Bgra8Unorm | F::Bgra8UnormSrgb => 255.0,
            F::Rgb10a2Unorm => 1023.0,
            _ => 0.0,
        }
    }

    /// Depth at infinity.
    pub(crate) fn far_depth(&self) -> f64 {
        match self.depth {
            Some((_, DepthDirection::Reversed)) => 0.0,
            _ => 1.0,
        }
    }

    /// How what lies at infinity stands behind the host's geometry: depth is tested and not written.
    pub(crate) fn behind(&self) -> Option<wgpu::DepthStencilState> {
        self.depth.map(|(format, direction)| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(false),
            depth_compare: Some(match direction {
                DepthDirection::Standard => wgpu::CompareFunction::LessEqual,
                DepthDirection::Reversed => wgpu::CompareFunction::GreaterEqual,
            }),
            stencil: Default::default(),
            bias: Default::default(),
        })
    }

    pub(crate) fn check(&self, device: &wgpu::Device) -> Result<(), GpuError> {
        let Some(largest) = self.largest() else {
            return Err(GpuError::Target(format!(
                "{:?} is no colour format that the sky draws to; use Rgba16Float, Rgba32Float, Rgb10a2Unorm or an 8-bit RGBA or BGRA one",
                self.colour
            )));
        };
        if self.output == Output::Radiance && largest <= 1.0 {
            return Err(GpuError::Target(format!("Output::Radiance needs a float format, not {:?}", self.colour)));
        }
        if !matches!(self.samples, 1 | 2 | 4 | 8 | 16) {
            return Err(GpuError::Target(format!("samples must be 1, 2, 4, 8 or 16, got {}", self.samples)));
        }
        if let Some((format, _)) = self.depth
            && !format.has_depth_aspect()
        {
            return Err(GpuError::Target(format!("{format:?} is no depth format")));
        }
        // What this device can do; wgpu would panic.
        let features = device.features();
        for format in std::iter::once(self.colour).chain(self.depth.map(|(format, _)| format)) {
            if !features.contains(format.required_features()) {
                return Err(GpuError::Target(format!(
                    "{format:?} needs {:?}, which the device was made without",
                    format.required_features()
                )));
            }
            let can = format.guaranteed_format_features(features);
            if !can.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
                return Err(GpuError::Target(format!("this device cannot draw to {format:?}")));
            }
            if !can.flags.sample_count_supported(self.samples) {
                return Err(GpuError::Target(format!(
                    "this device has no {} samples per pixel for {format:?}",
                    self.samples
                )));
            }
        }
        Ok(())
    }
}
