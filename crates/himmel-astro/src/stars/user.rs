//! A user's own catalogue.

use super::{Catalogue, Star};
use crate::constants::ARCSECOND_RAD;
use crate::error::{AstroError, Result, in_range, shown};

const COLUMNS: [&str; 11] = [
    "hip",
    "hd",
    "ra_deg",
    "dec_deg",
    "pm_ra_mas_per_year",
    "pm_dec_mas_per_year",
    "parallax_mas",
    "epoch_year",
    "v_magnitude",
    "b_minus_v",
    "spectral_type",
];

impl Catalogue {
    /// Reads a catalogue from text: comma-separated with one header line, columns in any order, lines that begin with `#`
    /// left out. Needed are `ra_deg`, `dec_deg` (ICRS) and `v_magnitude`; known besides are `hip`, `hd`,
    /// `pm_ra_mas_per_year` (times cos δ), `pm_dec_mas_per_year`, `parallax_mas`, `epoch_year` (2000 where absent),
    /// `b_minus_v`, `spectral_type`; an empty field is an absent one; other columns are passed over.
    ///
    /// Good rows make the catalogue; each bad row gives a message with its line number.
    pub fn from_csv(text: &str) -> Result<(Self, Vec<String>)> {
        let mut lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
        let (_, head) = lines.next().ok_or_else(|| malformed("", "it has no header line"))?;
        let head: Vec<&str> = head.split(',').map(str::trim).collect();
        let columns = COLUMNS.map(|name| head.iter().position(|h| *h == name));
        for needed in [2, 3, 8] {
            if columns[needed].is_none() {
                return Err(malformed(&head.join(","), &format!("the column `{}` is missing", COLUMNS[needed])));
            }
        }
        let (mut stars, mut complaints) = (Vec::new(), Vec::new());
        for (index, line) in lines {
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            match star(&fields, &columns) {
                Ok(star) => stars.push(star),
                Err(e) => complaints.push(format!("line {}: {e}", index + 1)),
            }
        }
        Ok((Self::from_stars(stars), complaints))
    }
}

fn malformed(text: &str, reason: &str) -> AstroError {
    AstroError::Malformed { what: "star catalogue", text: shown(text), reason: reason.to_owned() }
}

fn star(fields: &[&str], columns: &[Option<usize>; 11]) -> Result<Star> {
    let field = |c: usize| columns[c].and_then(|i| fields.get(i).copied()).filter(|f| !f.is_empty());
    let number = |c: usize| {
        field(c)
            .map(|f| {
                f.parse::<f64>()
                    .ok()
                    .filter(|v| v.is_finite())
                    .ok_or_else(|| malformed(f, &format!("`{}` must be a number", COLUMNS[c])))
            })
            .transpose()
    };
    let needed = |c: usize| number(c)?.ok_or_else(|| malformed("", &format!("`{}` is empty", COLUMNS[c])));
    let whole = |c: usize| {
        field(c).map_or(Ok(0), |f| {
            f.parse::<u32>().map_err(|_| malformed(f, &format!("`{}` must be a whole number", COLUMNS[c])))
        })
    };
    let milliarcseconds = |v: f64| v * 1e-3 * ARCSECOND_RAD;
    Ok(Star {
        hip: whole(0)?,
        hd: whole(1)?,
        right_ascension_rad: in_range("ra_deg", "0..=360 degrees", needed(2)?, 0.0, 360.0, "")?.to_radians(),
        declination_rad: in_range("dec_deg", "-90..=90 degrees", needed(3)?, -90.0, 90.0, "")?.to_radians(),
        motion_ra_rad_per_year: milliarcseconds(in_range(
            "pm_ra_mas_per_year",
            "±1e5",
            number(4)?.unwrap_or(0.0),
            -1e5,
            1e5,
            "",
        )?),
        motion_dec_rad_per_year: milliarcseconds(in_range(
            "pm_dec_mas_per_year",
            "±1e5",
            number(5)?.unwrap_or(0.0),
            -1e5,
            1e5,
            "",
        )?),
        parallax_rad: milliarcseconds(in_range("parallax_mas", "0..=10000", number(6)?.unwrap_or(0.0), 0.0, 1e4, "")?),
        epoch_year: in_range("epoch_year", "1800..=2200", number(7)?.unwrap_or(2000.0), 1800.0, 2200.0, "")?,
        v_magnitude: in_range("v_magnitude", "-30..=40", needed(8)?, -30.0, 40.0, "")?,
        b_minus_v: number(9)?.filter(|v| v.abs() < 10.0),
        spectral_type: field(10).unwrap_or_default().chars().take(40).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_rows_stay_and_bad_rows_are_named() {
        let text = "# mine\nv_magnitude,ra_deg,dec_deg,hip\n1.5,10,20,7\n\nx,10,20,8\n2,10,95,9\n3,11,-20,\n";
        let (c, complaints) = Catalogue::from_csv(text).unwrap();
        assert_eq!(c.stars().len(), 2);
        assert_eq!(c.hip(7).unwrap().v_magnitude, 1.5);
        assert_eq!(complaints.len(), 2);
        assert!(complaints[0].starts_with("line 5:") && complaints[0].contains("v_magnitude"), "{complaints:?}");
        assert!(complaints[1].contains("-90..=90"), "{complaints:?}");
        assert!(Catalogue::from_csv("").is_err());
        assert!(Catalogue::from_csv("ra_deg,dec_deg\n").unwrap_err().to_string().contains("v_magnitude"));
    }
}
