//! What can go wrong with a golden, in sentences that say what to do.

use std::path::PathBuf;

/// Width and height in pixels.
pub type Size = (usize, usize);

/// Why a golden check, a review or an acceptance did not go through. Paths come last.
///
/// `Debug` prints the sentence too: it is what a test that returns this error, or unwraps it, shows.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum GoldenError {
    /// The name cannot be a file name on every system.
    #[error("a golden's name is made of a–z, A–Z, 0–9, - and _, at most 64 of them, got {0:?}")]
    Name(String),
    /// The environment variable has a value that means nothing.
    #[error("HIMMEL_GOLDEN must be `check`, `propose` or unset, got {0:?}")]
    Mode(String),
    /// FLIP was asked for a viewing distance without meaning.
    #[error("pixels per degree must lie in 1..=1000, got {0} (67 is a desk, 20 a wall)")]
    PixelsPerDegree(f64),
    /// A limit is negative or not a number.
    #[error("the tolerance `{field}` must be finite and not negative, got {value}")]
    Tolerance {
        /// The field of `Tolerance` or `FlipTolerance`.
        field: &'static str,
        /// What it held.
        value: f64,
    },
    /// The buffer does not fit the size.
    #[error("a picture of {width}×{height} RGB pixels needs 1..={max_pixels} pixels and three values for each, got {length} values", max_pixels = crate::files::MAX_PIXELS)]
    Shape {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// Number of values in the buffer.
        length: usize,
    },
    /// Two pictures of different size were compared.
    #[error("the accepted picture is {}×{}, the new one {}×{}", accepted.0, accepted.1, new.0, new.1)]
    SizesDiffer {
        /// Size of the accepted picture.
        accepted: Size,
        /// Size of the new picture.
        new: Size,
    },
    /// The new picture holds NaN or infinities; it is not proposed.
    #[error("golden `{name}`: {pixels} pixels of the new picture are NaN or infinite, the first at x {x}, y {y}: it cannot be accepted; they are green in {}", difference.display())]
    NonFinite {
        /// The golden.
        name: String,
        /// How many pixels.
        pixels: usize,
        /// Column of the first from the left.
        x: usize,
        /// Row of the first from the top.
        y: usize,
        /// The map that shows where.
        difference: PathBuf,
    },
    /// The check failed: missing, unreadable, another size, or too different.
    #[error("golden `{name}`: {reason}; look at it with `cargo xtask golden review`, and if the new picture is right, run `cargo xtask golden accept {name}`: {}", proposal.display())]
    Failed {
        /// The golden.
        name: String,
        /// What differs, with the numbers and what was allowed.
        reason: String,
        /// The new picture.
        proposal: PathBuf,
    },
    /// A golden of the other kind has this name.
    #[error("golden `{name}` is already accepted as another kind of picture; names are shared between EXR and PNG, so choose another or delete {}", path.display())]
    OtherKind {
        /// The golden.
        name: String,
        /// The accepted file.
        path: PathBuf,
    },
    /// A file could not be read as a picture.
    #[error("{reason}: {}", path.display())]
    Unreadable {
        /// What is wrong with it.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// A file or folder could not be written, moved, removed or listed.
    #[error("cannot {action}: {source}: {}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// The system's answer.
        source: std::io::Error,
        /// The file or folder.
        path: PathBuf,
    },
    /// A picture could not be encoded.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
    /// `accept` was given a name that has no proposal.
    #[error("golden `{name}` has no proposal; {available}; `cargo xtask golden propose` makes them")]
    NoProposal {
        /// The name asked for.
        name: String,
        /// A clause that lists the proposals there are.
        available: String,
    },
    /// The command line was not understood.
    #[error("{0}; usage: {usage}", usage = crate::cli::USAGE)]
    Usage(String),
    /// `cargo test` did not run through.
    #[error("the golden tests did not run through ({0}); the proposals made so far can still be reviewed")]
    Tests(String),
}

impl std::fmt::Debug for GoldenError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

impl GoldenError {
    /// For `map_err`: an I/O error with what was tried and where.
    pub(crate) fn io(action: &'static str, path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| GoldenError::Io { action, source, path }
    }
}
