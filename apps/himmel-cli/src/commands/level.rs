//! `--level`: which ephemeris answers.

use himmel::parts::astro::{Ephemeris, Fast, Precise};

use crate::Failure;

/// Levels of accuracy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Level {
    /// Series: Sun 5″, Moon 10″, planets 20″.
    Fast,
    /// JPL DE440: hundredths of a second of arc.
    Precise,
}

impl Level {
    /// The ephemeris.
    pub fn open(self) -> Result<Box<dyn Ephemeris>, Failure> {
        match self {
            Self::Fast => Ok(Box::new(Fast)),
            Self::Precise => Precise::embedded()
                .map(|p| Box::new(p) as Box<dyn Ephemeris>)
                .map_err(|e| Failure::failed(e.to_string())),
        }
    }
}
