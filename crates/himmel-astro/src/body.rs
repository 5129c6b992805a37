use crate::constants::{MOON_RADIUS_M, SUN_RADIUS_M};
use crate::error::{AstroError, Result, shown};

/// A body of the solar system that the ephemerides know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Body {
    Sun,
    Moon,
    Earth,
    Mercury,
    Venus,
    Mars,
    Jupiter,
    Saturn,
    Uranus,
    Neptune,
    Pluto,
}

impl Body {
    /// All bodies, nearest the Sun first after Sun, Moon and Earth.
    pub const ALL: [Self; 11] = [
        Self::Sun,
        Self::Moon,
        Self::Earth,
        Self::Mercury,
        Self::Venus,
        Self::Mars,
        Self::Jupiter,
        Self::Saturn,
        Self::Uranus,
        Self::Neptune,
        Self::Pluto,
    ];

    /// The seven planets besides the Earth.
    pub const PLANETS: [Self; 7] =
        [Self::Mercury, Self::Venus, Self::Mars, Self::Jupiter, Self::Saturn, Self::Uranus, Self::Neptune];

    /// Its English name in lower case, as the command line takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sun => "sun",
            Self::Moon => "moon",
            Self::Earth => "earth",
            Self::Mercury => "mercury",
            Self::Venus => "venus",
            Self::Mars => "mars",
            Self::Jupiter => "jupiter",
            Self::Saturn => "saturn",
            Self::Uranus => "uranus",
            Self::Neptune => "neptune",
            Self::Pluto => "pluto",
        }
    }

    /// Finds a body by name in any case.
    pub fn parse(name: &str) -> Result<Self> {
        let wanted = name.trim();
        Self::ALL.into_iter().find(|b| b.name().eq_ignore_ascii_case(wanted)).ok_or_else(|| AstroError::Unknown {
            kind: "body",
            name: shown(wanted),
            suggestion: "; known are sun, moon, mercury, venus, mars, jupiter, saturn, uranus, neptune, pluto".into(),
        })
    }

    /// Equatorial radius in m: Sun [iau2015-b3], the others [archinal2018]; the Moon's is its mean radius.
    pub fn radius_m(self) -> f64 {
        match self {
            Self::Sun => SUN_RADIUS_M,
            Self::Moon => MOON_RADIUS_M,
            Self::Earth => 6_378_136.6,
            Self::Mercury => 2_440_530.0,
            Self::Venus => 6_051_800.0,
            Self::Mars => 3_396_190.0,
            Self::Jupiter => 71_492_000.0,
            Self::Saturn => 60_268_000.0,
            Self::Uranus => 25_559_000.0,
            Self::Neptune => 24_764_000.0,
            Self::Pluto => 1_188_300.0,
        }
    }
}

impl std::fmt::Display for Body {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
