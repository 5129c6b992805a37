//! What can go wrong on a GPU.

/// Why the renderer cannot do what it was asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// No adapter answers, or none whose name contains what was asked for.
    #[error(
        "no usable GPU adapter {wanted}; {found}. On Debian, `apt-get install mesa-vulkan-drivers libvulkan1` brings a software one"
    )]
    NoAdapter {
        /// What was looked for.
        wanted: String,
        /// What was found.
        found: String,
    },
    /// The adapter refused a device, or the device was lost.
    #[error("the GPU device failed: {0}")]
    Device(String),
    /// The render target cannot hold a sky.
    #[error("the target does not fit: {0}")]
    Target(String),
    /// A file of letters cannot be used.
    #[error("the font does not fit: {0}")]
    Font(String),
    /// A view has no inverse, is not finite, or there are too many.
    #[error("the view does not fit: {0}")]
    View(String),
    /// The air has more to it than the renderer takes.
    #[error("the air {0}")]
    Air(String),
    /// Saved tables do not fit, or cannot be saved.
    #[error("the air's tables: {0}")]
    Tables(String),
    /// The picture's size is out of bounds.
    #[error(
        "the picture must be 1 to {max} pixels wide and high and hold at most {max_pixels} pixels, got {width}x{height}"
    )]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Largest side.
        max: u32,
        /// Most pixels.
        max_pixels: u64,
    },
    /// Shader files could not be joined.
    #[error("the shaders do not fit together: {0}")]
    Shader(#[from] crate::shader::IncludeError),
    /// The approximation that we compare with cannot show this.
    #[error("the comparison does not fit: {0}")]
    Comparison(String),
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}
