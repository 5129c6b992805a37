//! What can go wrong with a description of air.

/// Why an atmosphere cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AirError {
    /// No preset has this name.
    #[error("unknown preset \"{name}\"{}; presets are {}, or give the path of a .toml file", suggest(.suggestion), crate::preset::names().collect::<Vec<_>>().join(", "))]
    UnknownPreset {
        /// What was asked for.
        name: String,
        /// The nearest name.
        suggestion: Option<String>,
    },
    /// The file is not TOML, or a key is missing, unknown or of the wrong type.
    #[error("{file}: {message}")]
    Syntax {
        /// File or preset.
        file: String,
        /// What is wrong and where, on one line.
        message: String,
    },
    /// A value breaks a law.
    #[error("{file}: line {line}: {what} must {law}, got {got}")]
    Value {
        /// File or preset.
        file: String,
        /// Where the key stands.
        line: usize,
        /// The key.
        what: String,
        /// What it must be.
        law: &'static str,
        /// What it is.
        got: f64,
    },
    /// Quantities that cannot stand together, or one that is missing.
    #[error("{file}: line {line}: {what} must {law}")]
    Contradiction {
        /// File or preset.
        file: String,
        /// Where the table or key stands.
        line: usize,
        /// The key.
        what: String,
        /// What must be.
        law: &'static str,
    },
    /// A quantity outside the domain of a formula.
    #[error("{what} must {law}, got {got}")]
    Optics {
        /// The quantity.
        what: String,
        /// What it must be.
        law: &'static str,
        /// What it is.
        got: f64,
    },
}

fn suggest(name: &Option<String>) -> String {
    name.as_ref().map_or_else(String::new, |name| format!(": did you mean {name}?"))
}
