//! Where on Earth: what a person types after `--place`, as coordinates and a time zone.
//!
//! ```
//! let home: himmel::place::NamedPlace = "Potsdam".parse()?;
//! assert_eq!(home.name, "Potsdam (DE)");
//! assert_eq!(home.time_zone, "Europe/Berlin");
//!
//! let summit: himmel::place::NamedPlace = "-24.6274, -70.4050, 2669".parse()?;
//! assert_eq!(summit.height_m, 2669.0);
//! # Ok::<(), himmel::place::PlaceError>(())
//! ```
//!
//! Accepted: a name (`Potsdam`, `münchen`, `Muenchen`, `New York`), with a country or a state of the USA where two places share it
//! (`Potsdam, US`, `Potsdam, Germany`, `Paris, TX`); or `latitude, longitude[, height_m]` in degrees, north and east positive
//! (`52.4,13.06`, `52.4N 13.06E`, `-33.9, 18.4, 1086`). Case, accents, umlauts and punctuation do not matter. The biggest of
//! several places wins; a name in another language counts for an eighth, so that `Nis` is Niš and not Nice.
//!
//! The names are those of GeoNames (CC BY 4.0), the zones of bare coordinates those of OpenStreetMap (ODbL):
//! `assets/places/SOURCE.md`. Known to be wrong: GeoNames' file has no heights, so cities lie at 0 m; say `lat,lon,height` where that
//! matters. Heights are above the ellipsoid or the sea, whichever the person means: nothing here depends on it.

mod fold;
mod gazetteer;
mod parse;
mod suggest;

use std::str::FromStr;

/// The lowest height accepted: the shore of the Dead Sea lies at −430 m.
pub const LOWEST_HEIGHT_M: f64 = -500.0;
/// The greatest height accepted, about a quarter of the way to the Moon: an observer may be in space.
pub const GREATEST_HEIGHT_M: f64 = 1e8;
/// Longer texts are not searched for: no place has a name so long.
const LONGEST_TEXT_BYTES: usize = 200;

/// A place on Earth with a name to show.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPlace {
    /// To be shown: `Potsdam (DE)`, `Paris, TX (US)`, or the coordinates.
    pub name: String,
    /// Geodetic latitude in degrees, north positive, −90..=90.
    pub latitude_deg: f64,
    /// Longitude in degrees, east positive, −180..180.
    pub longitude_deg: f64,
    /// Height in metres; 0 where it is not known.
    pub height_m: f64,
    /// The IANA time zone: `Europe/Berlin`, or `Etc/GMT+3` on the high seas.
    pub time_zone: String,
}

/// Why a text is not a place: a sentence that says what to type instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceError {
    /// Nothing but blanks.
    #[error("the place is empty: give a city such as \"Potsdam\", or latitude,longitude such as 52.39,13.06")]
    Empty,
    /// Too long to be a place.
    #[error(
        "the place is {bytes} bytes long: give a city such as \"Potsdam\", or latitude,longitude such as 52.39,13.06"
    )]
    TooLong {
        /// The length of the text.
        bytes: usize,
    },
    /// No place has that name.
    #[error("unknown place \"{text}\"{}", .suggestions)]
    Unknown {
        /// What was typed.
        text: String,
        /// The nearest names.
        suggestions: Suggestions,
    },
    /// The place is known, but not in that country.
    #[error("there is no \"{name}\" in \"{country}\": did you mean {}?", any_of(.elsewhere))]
    NotInThatCountry {
        /// The place that was typed.
        name: String,
        /// The country that was typed.
        country: String,
        /// Where places of that name are.
        elsewhere: Vec<String>,
    },
    /// Numbers, but neither two nor three.
    #[error("coordinates are latitude,longitude[,height in metres], got {got} number{}", match got { 1 => "", 4 => "s (decimals take a point, not a comma)", _ => "s" })]
    Count {
        /// How many numbers there were.
        got: usize,
    },
    /// A number that is none: `nan`, `inf`.
    #[error("{what} must be a finite number, got {text}")]
    NotFinite {
        /// Which of the three.
        what: &'static str,
        /// What was typed.
        text: String,
    },
    /// A latitude beyond the poles.
    #[error("latitude must lie in -90..=90°, got {got}{}", if *.swapped { " (are latitude and longitude swapped?)" } else { "" })]
    Latitude {
        /// What was typed, degrees.
        got: f64,
        /// Whether the two would do in the other order.
        swapped: bool,
    },
    /// A longitude beyond a full turn.
    #[error("longitude must lie in -180..=360°, got {got}")]
    Longitude {
        /// What was typed, degrees.
        got: f64,
    },
    /// A height below the lowest land or too far from Earth.
    #[error("height must lie in {LOWEST_HEIGHT_M}..={GREATEST_HEIGHT_M:e} m, got {got} (metres, not kilometres)")]
    Height {
        /// What was typed, metres.
        got: f64,
    },
}

/// The names nearest to one that is unknown, best first; may be none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Suggestions(pub Vec<String>);

impl std::fmt::Display for Suggestions {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0.as_slice() {
            [] => write!(out, ": try a bigger city nearby, or latitude,longitude such as 52.39,13.06"),
            names => write!(out, ": did you mean {}?", any_of(names)),
        }
    }
}

/// `a`, `a or b`, `a, b or c`.
fn any_of(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} or {last}", most.join(", ")),
    }
}

impl FromStr for NamedPlace {
    type Err = PlaceError;

    /// Reads a name or coordinates; see the [module](self).
    ///
    /// Cost, on one core of a small server: the first name 15 ms (the tables are read), a later one 0.3 ms, a misspelt one 10 ms
    /// more; the first coordinates 4 ms (the zones are opened), later ones microseconds. The tables stay in memory, about 8 MB.
    fn from_str(text: &str) -> Result<Self, PlaceError> {
        let text = text.trim();
        if text.is_empty() {
            return Err(PlaceError::Empty);
        }
        if text.len() > LONGEST_TEXT_BYTES {
            return Err(PlaceError::TooLong { bytes: text.len() });
        }
        match parse::coordinates(text) {
            Some(coordinates) => coordinates.map(parse::Coordinates::into_place),
            None => gazetteer::find(text),
        }
    }
}

#[cfg(test)]
mod tests;
