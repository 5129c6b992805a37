//! Figures, names and boundaries of the constellations: an optional asset, drawn by those who want it.
//!
//! The text itself is built in with the feature `constellations`; without it, read
//! `assets/astro/stars/constellations.txt` and hand it to [`parse`].

use crate::error::{AstroError, Result, shown};

/// One constellation, angles in radians, ICRS.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Constellation {
    /// Three letters, for example `Ori`.
    pub id: String,
    /// Latin name.
    pub name: String,
    /// Right ascension and declination of the place for the name.
    pub label: (f64, f64),
    /// The figure: open lines of (right ascension, declination).
    pub lines: Vec<Vec<(f64, f64)>>,
    /// The boundary: closed rings (Serpens has two).
    pub boundaries: Vec<Vec<(f64, f64)>>,
}

/// The built-in text.
#[cfg(feature = "constellations")]
pub static EMBEDDED: &str = include_str!("../../../../assets/astro/stars/constellations.txt");

/// Reads the format described in `assets/astro/stars/SOURCE.md`.
pub fn parse(text: &str) -> Result<Vec<Constellation>> {
    let mut all: Vec<Constellation> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let malformed = |reason: &str| AstroError::Malformed {
            what: "constellation",
            text: shown(line),
            reason: format!("line {}: {reason}", index + 1),
        };
        let mut words = line.split_whitespace();
        let (Some(kind), Some(id)) = (words.next(), words.next()) else {
            continue;
        };
        let slot = all.iter().position(|c| c.id == id).unwrap_or_else(|| {
            all.push(Constellation { id: id.to_owned(), ..Constellation::default() });
            all.len() - 1
        });
        let angle = |word: &str| {
            word.parse::<f64>()
                .ok()
                .filter(|v| v.abs() <= 360.0)
                .map(f64::to_radians)
                .ok_or_else(|| malformed("expected degrees"))
        };
        if kind == "name" {
            let (Some(ra), Some(dec)) = (words.next(), words.next()) else {
                return Err(malformed("expected right ascension, declination, name"));
            };
            all[slot].label = (angle(ra)?, angle(dec)?);
            all[slot].name = words.collect::<Vec<_>>().join(" ");
            continue;
        }
        let numbers = words.map(angle).collect::<Result<Vec<f64>>>()?;
        if numbers.len() % 2 != 0 {
            return Err(malformed("expected pairs of right ascension and declination"));
        }
        let points = numbers.chunks_exact(2).map(|p| (p[0], p[1])).collect();
        match kind {
            "line" => all[slot].lines.push(points),
            "boundary" => all[slot].boundaries.push(points),
            _ => return Err(malformed("expected `name`, `line` or `boundary`")),
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_88_are_there() {
        let all = parse(include_str!("../../../../assets/astro/stars/constellations.txt")).unwrap();
        let ids: std::collections::BTreeSet<_> = all.iter().map(|c| c.id.as_str()).collect();
        assert_eq!(ids.len(), all.len());
        assert!(all.iter().filter(|c| !c.boundaries.is_empty()).count() >= 88);
        let orion = all.iter().find(|c| c.id == "Ori").unwrap();
        assert!(!orion.lines.is_empty() && orion.name == "Orion");
        assert!(parse("line Ori 1").is_err() && parse("line Ori x y").is_err() && parse("circle Ori 1 2").is_err());
    }
}
