//! The one error of the library.

use std::path::PathBuf;

/// What went wrong, in a sentence that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A place that cannot be found or read.
    #[error(transparent)]
    Place(#[from] crate::place::PlaceError),
    /// A time that cannot be read.
    #[error(
        "time \"{text}\" cannot be read: {reason}; write 2012-09-06T18:00Z, 2012-09-06T20:00+02:00, or 2012-09-06T20:00 for the place's own clock"
    )]
    Time {
        /// What was given.
        text: String,
        /// Why not.
        reason: String,
    },
    /// A direction to look that is not understood.
    #[error(
        "cannot look at \"{0}\"; give AZIMUTH,ALTITUDE in degrees, sun, sunward, zenith, nadir, a planet's or star's name, or a compass point such as NW or NW,20"
    )]
    Look(String),
    /// A camera setting that does not fit the projection.
    #[error("{0}")]
    Camera(String),
    /// A parameter's name or value.
    #[error(transparent)]
    Param(#[from] himmel_core::params::ParamError),
    /// A scene file.
    #[error("{file}: {message}")]
    Scene {
        /// Its path.
        file: String,
        /// What is wrong and where.
        message: String,
    },
    /// Another planet or moon of a scene.
    #[error("{body}: {message}")]
    Body {
        /// Its name or number.
        body: String,
        /// What is wrong with it.
        message: String,
    },
    /// Astronomy refuses a date or a place.
    #[error(transparent)]
    Astro(#[from] himmel_astro::AstroError),
    /// An atmosphere's file.
    #[error(transparent)]
    Air(#[from] himmel_air::AirError),
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] himmel_gpu::GpuError),
    /// A file could not be read.
    #[error("cannot read {}: {source}", .path.display())]
    Read {
        /// Its path.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The samples of an unfinished reference picture do not go on here.
    #[error("the samples so far cannot be used: {0}")]
    Samples(String),
    /// A picture's name has no ending that is known.
    #[error("the picture's name must end in .png, .jpg, .exr or .hdr, got {}", .path.display())]
    FileFormat {
        /// Its path.
        path: PathBuf,
    },
    /// A file could not be written; nothing is left behind.
    #[error("cannot write {}: {reason}", .path.display())]
    Write {
        /// Its path.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
}

/// The library's result.
pub type Result<T> = std::result::Result<T, Error>;
