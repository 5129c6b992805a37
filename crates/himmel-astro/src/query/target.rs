use crate::apparent::{Apparent, Observer};
use crate::body::Body;
use crate::error::{AstroError, Result};
use crate::stars::{Catalogue, Star};

/// Something in the sky that has a name: a body of the solar system or a star.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Sun, Moon or planet.
    Body(Body),
    /// A star of the built-in catalogue.
    Star(Box<Star>),
}

impl Target {
    /// Reads `sun`, `jupiter`, `HIP 32349`, `HD 48915`, `Sirius`, `alpha CMa`, in any case.
    pub fn parse(name: &str) -> Result<Self> {
        match Body::parse(name) {
            Ok(Body::Earth) => Err(AstroError::Unsupported {
                ephemeris: "an observer on it",
                body: "earth".into(),
                hint: "ask for another body",
            }),
            Ok(body) => Ok(Self::Body(body)),
            Err(bodies) => Catalogue::embedded().find(name).map(|s| Self::Star(Box::new(s.clone()))).map_err(|stars| {
                match (bodies, stars) {
                    (AstroError::Unknown { name, .. }, AstroError::Unknown { suggestion, .. }) => {
                        let suggestion = if suggestion.contains("did you mean") {
                            suggestion
                        } else {
                            "; known are sun, moon, mercury … neptune, pluto, and stars by name (Sirius), HIP or HD number".into()
                        };
                        AstroError::Unknown { kind: "body or star", name, suggestion }
                    }
                    (other, _) => other,
                }
            }),
        }
    }

    /// Where it is seen.
    pub fn apparent(&self, observer: &Observer<'_>) -> Result<Apparent> {
        match self {
            Self::Body(body) => observer.apparent(*body),
            Self::Star(star) => Ok(observer.apparent_star(star)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_both_kinds() {
        assert_eq!(Target::parse(" Jupiter ").unwrap(), Target::Body(Body::Jupiter));
        assert!(matches!(Target::parse("HIP 32349").unwrap(), Target::Star(s) if s.hip == 32_349));
        assert!(Target::parse("earth").is_err());
        let e = Target::parse("sirus").unwrap_err().to_string();
        assert!(e.contains("did you mean"), "{e}");
        assert!(Target::parse("").is_err());
    }
}
