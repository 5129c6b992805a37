/// What can be wrong with a question to this crate. Each message says what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AstroError {
    /// A number is NaN, infinite, or outside the range in which it has a meaning.
    #[error("{quantity} must lie in {range}, got {value}{hint}")]
    OutOfRange {
        /// What the number is.
        quantity: &'static str,
        /// The allowed range with its unit.
        range: &'static str,
        /// What was given.
        value: f64,
        /// A guess at the mistake, or empty.
        hint: &'static str,
    },
    /// The date lies outside the span in which the theory means anything.
    #[error("Julian date {jd} lies outside {span}, the span of {theory}; choose a date inside it")]
    DateOutOfSpan {
        /// The date asked for.
        jd: f64,
        /// The allowed span in words.
        span: &'static str,
        /// Which theory ends there.
        theory: &'static str,
    },
    /// No body, star or city of that name.
    #[error("unknown {kind} `{name}`{suggestion}")]
    Unknown {
        /// What was looked for: a body, a star.
        kind: &'static str,
        /// The name as given.
        name: String,
        /// `; did you mean …?` or a list of what exists.
        suggestion: String,
    },
    /// This ephemeris cannot answer for this body.
    #[error("{ephemeris} does not know where {body} is; {hint}")]
    Unsupported {
        /// The level asked.
        ephemeris: &'static str,
        /// The body asked for.
        body: String,
        /// What to use instead.
        hint: &'static str,
    },
    /// A text (time, place, orbital elements, catalogue line) that cannot be read.
    #[error("{what} `{text}` cannot be read: {reason}")]
    Malformed {
        /// What the text should be.
        what: &'static str,
        /// The text, shortened.
        text: String,
        /// Why, and what is expected.
        reason: String,
    },
    /// A computation that should settle did not, for example a satellite that has decayed.
    #[error("{what}: {reason}")]
    NoSolution {
        /// What was computed.
        what: &'static str,
        /// Why there is no answer.
        reason: String,
    },
}

/// What the functions of this crate return.
pub type Result<T> = std::result::Result<T, AstroError>;

/// Checks that a number is finite and within `low..=high`.
pub(crate) fn in_range(
    quantity: &'static str,
    range: &'static str,
    value: f64,
    low: f64,
    high: f64,
    hint: &'static str,
) -> Result<f64> {
    if value >= low && value <= high { Ok(value) } else { Err(AstroError::OutOfRange { quantity, range, value, hint }) }
}

/// A text as an error message may show it: at most 60 characters, control characters replaced.
pub(crate) fn shown(text: &str) -> String {
    let mut s: String = text.chars().take(60).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(60).is_some() {
        s.push('…');
    }
    s
}
