use super::Star;
use crate::constants::ARCSECOND_RAD;
use crate::error::{AstroError, Result, shown};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

static STARS: &[u8] = include_bytes!("../../../../assets/astro/stars/stars.bin");
static NAMES: &str = include_str!("../../../../assets/astro/stars/names.tsv");
const ROW_BYTES: usize = 44;
const UNITS_RAD: f64 = 1e-5 * ARCSECOND_RAD;

/// What a star is called.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StarName {
    /// Proper name, for example `Sirius`; may be empty.
    pub proper: String,
    /// Bayer letter, for example `α`; may be empty.
    pub bayer: String,
    /// Flamsteed number; may be empty.
    pub flamsteed: String,
    /// The constellation's three letters.
    pub constellation: String,
}

/// Stars with a way to find them. Brightest first in the built-in one.
#[derive(Debug, Clone, Default)]
pub struct Catalogue {
    pub(super) stars: Vec<Star>,
    by_hip: HashMap<u32, usize>,
    names: HashMap<u32, StarName>,
    /// Proper names in lower case.
    by_name: HashMap<String, u32>,
}

impl Catalogue {
    /// Hipparcos to V = 6.5, with nearer and named ones below (`assets/astro/stars/SOURCE.md`).
    pub fn embedded() -> &'static Self {
        static CATALOGUE: OnceLock<Catalogue> = OnceLock::new();
        CATALOGUE.get_or_init(|| {
            let mut c =
                Self::from_stars(STARS.get(4..).unwrap_or_default().chunks_exact(ROW_BYTES).map(unpack).collect());
            c.name_stars(NAMES);
            c
        })
    }

    /// A catalogue of the caller's stars; of two with one HIP number the later is found.
    pub fn from_stars(stars: Vec<Star>) -> Self {
        let by_hip = stars.iter().enumerate().filter(|(_, s)| s.hip != 0).map(|(i, s)| (s.hip, i)).collect();
        Self { stars, by_hip, ..Self::default() }
    }

    /// All stars.
    pub fn stars(&self) -> &[Star] {
        &self.stars
    }

    /// By Hipparcos number.
    pub fn hip(&self, hip: u32) -> Option<&Star> {
        self.by_hip.get(&hip).and_then(|i| self.stars.get(*i))
    }

    /// What a star is called.
    pub fn name(&self, hip: u32) -> Option<&StarName> {
        self.names.get(&hip)
    }

    /// Finds `HIP 32349`, `HD 48915`, a proper name (`Sirius`), or Bayer or Flamsteed with the constellation (`α CMa`,
    /// `alpha CMa`, `61 Cyg`), in any case.
    pub fn find(&self, text: &str) -> Result<&Star> {
        let wanted = text.trim().to_lowercase();
        let unknown = |suggestion: String| AstroError::Unknown { kind: "star", name: shown(text.trim()), suggestion };
        for (prefix, by_hip) in [("hip", true), ("hd", false)] {
            let Some(Ok(number)) = wanted.strip_prefix(prefix).map(|digits| digits.trim().parse::<u32>()) else {
                continue;
            };
            let star =
                if by_hip { self.hip(number) } else { self.stars.iter().find(|s| s.hd == number && number != 0) };
            return star.ok_or_else(|| unknown("; the catalogue holds stars to V = 6.5 and the nearest ones".into()));
        }
        if let Some(star) = self.by_name.get(&wanted).and_then(|hip| self.hip(*hip)) {
            return Ok(star);
        }
        if let Some((designation, constellation)) = wanted.rsplit_once(' ') {
            let designation = designation.trim();
            let letter = greek_letter(designation).unwrap_or(designation);
            let found = self.names.iter().filter(|(_, n)| {
                n.constellation.to_lowercase() == constellation
                    && (n.bayer.to_lowercase() == letter || (!n.flamsteed.is_empty() && n.flamsteed == designation))
            });
            // Of several with one letter (α¹, α²) the brightest.
            let best =
                found.filter_map(|(hip, _)| self.hip(*hip)).min_by(|a, b| a.v_magnitude.total_cmp(&b.v_magnitude));
            if let Some(star) = best {
                return Ok(star);
            }
        }
        let near = self.by_name.keys().filter(|n| n.starts_with(wanted.get(..3).unwrap_or("\u{0}"))).min();
        Err(unknown(
            near.map_or_else(|| "; give a name, HIP or HD number".into(), |n| format!("; did you mean `{n}`?")),
        ))
    }

    fn name_stars(&mut self, table: &str) {
        for line in table.lines() {
            let mut fields = line.split('\t').map(str::to_owned);
            let (Some(Ok(hip)), Some(proper), Some(bayer), Some(flamsteed), Some(constellation)) =
                (fields.next().map(|h| h.parse()), fields.next(), fields.next(), fields.next(), fields.next())
            else {
                continue;
            };
            if !proper.is_empty() {
                self.by_name.insert(proper.to_lowercase(), hip);
            }
            self.names.insert(hip, StarName { proper, bayer, flamsteed, constellation });
        }
    }
}

/// One row of `stars.bin`; `chunks_exact` gives all its bytes.
fn unpack(row: &[u8]) -> Star {
    let u = |at: usize| row.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
    let i = |at: usize| u(at) as i32;
    let h = |at: usize| row.get(at..at + 2).and_then(|b| b.try_into().ok()).map_or(0, i16::from_le_bytes);
    let spectrum = row.get(32..44).unwrap_or_default();
    let end = spectrum.iter().position(|b| *b == 0).unwrap_or(spectrum.len());
    Star {
        hip: u(0),
        hd: u(4),
        right_ascension_rad: f64::from(u(8)) / 4_294_967_296.0 * TAU,
        declination_rad: f64::from(i(12)) / 4_294_967_296.0 * PI,
        parallax_rad: f64::from(u(16)) * UNITS_RAD,
        motion_ra_rad_per_year: f64::from(i(20)) * UNITS_RAD,
        motion_dec_rad_per_year: f64::from(i(24)) * UNITS_RAD,
        epoch_year: 1991.25,
        v_magnitude: f64::from(h(28)) / 1e3,
        b_minus_v: Some(h(30)).filter(|v| *v != i16::MIN).map(|v| f64::from(v) / 1e3),
        spectral_type: String::from_utf8_lossy(spectrum.get(..end).unwrap_or_default()).into_owned(),
    }
}

fn greek_letter(name: &str) -> Option<&'static str> {
    const GREEK: [(&str, &str); 24] = [
        ("alpha", "α"),
        ("beta", "β"),
        ("gamma", "γ"),
        ("delta", "δ"),
        ("epsilon", "ε"),
        ("zeta", "ζ"),
        ("eta", "η"),
        ("theta", "θ"),
        ("iota", "ι"),
        ("kappa", "κ"),
        ("lambda", "λ"),
        ("mu", "μ"),
        ("nu", "ν"),
        ("xi", "ξ"),
        ("omicron", "ο"),
        ("pi", "π"),
        ("rho", "ρ"),
        ("sigma", "σ"),
        ("tau", "τ"),
        ("upsilon", "υ"),
        ("phi", "φ"),
        ("chi", "χ"),
        ("psi", "ψ"),
        ("omega", "ω"),
    ];
    GREEK.iter().find(|(word, _)| *word == name).map(|(_, letter)| *letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_naked_eye_sky_is_there() {
        let c = Catalogue::embedded();
        let naked_eye = c.stars().iter().filter(|s| s.v_magnitude <= 6.5).count();
        assert!((8_500..9_500).contains(&naked_eye), "{naked_eye}");
        let sirius = &c.stars()[0];
        assert_eq!((sirius.hip, sirius.hd, sirius.v_magnitude), (32_349, 48_915, -1.44));
        assert!(sirius.spectral_type.starts_with("A0"));
        assert!((sirius.parallax_rad / ARCSECOND_RAD - 0.379).abs() < 0.001);
    }

    #[test]
    fn stars_are_found_by_any_of_their_names() {
        let c = Catalogue::embedded();
        for name in ["HIP 32349", "hip32349", "HD 48915", "sirius", "Sirius", "α CMa", "alpha CMa", "9 CMa"] {
            assert_eq!(c.find(name).unwrap().hip, 32_349, "{name}");
        }
        assert_eq!(c.find("61 Cyg").unwrap().hip, 104_214);
        assert!(c.find("siriuss").unwrap_err().to_string().contains("sirius"));
        for nonsense in ["", "HIP", "HIP 999999999999", "HIP 0", "HD 0", "é", "αβγ δεζ"] {
            assert!(c.find(nonsense).is_err(), "{nonsense}");
        }
    }
}
