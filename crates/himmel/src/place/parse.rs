//! Coordinates as people write them.

use std::sync::OnceLock;

use super::{GREATEST_HEIGHT_M, LOWEST_HEIGHT_M, NamedPlace, PlaceError};

/// A latitude and longitude in their ranges, with a height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coordinates {
    latitude_deg: f64,
    longitude_deg: f64,
    height_m: f64,
}

/// Reads `lat,lon[,height]`; `None` where the text is a name instead, which it is unless every part is a number.
pub(super) fn coordinates(text: &str) -> Option<Result<Coordinates, PlaceError>> {
    // Commas, semicolons or blanks part the numbers, not each alone: "52.4 13.06", "52.4, 13.06".
    let parts: Vec<&str> =
        text.split(|c: char| c == ',' || c == ';' || c.is_whitespace()).filter(|part| !part.is_empty()).collect();
    // "52.4 N 13.06 E" is "52.4N 13.06E".
    let mut numbers: Vec<Number> = Vec::new();
    for part in parts {
        let letter = part.chars().next().filter(|_| part.len() == 1).and_then(hemisphere);
        match (letter, numbers.last_mut()) {
            (Some(side), Some(last)) if last.side.is_none() => last.side = Some(side),
            _ => numbers.push(number(part)?),
        }
    }
    match numbers.as_slice() {
        [] => None,
        // There is a city called Nan.
        [one] if one.value.is_nan() => None,
        _ => Some(check(&numbers)),
    }
}

/// A number as typed, with the letter after it.
struct Number<'a> {
    text: &'a str,
    value: f64,
    side: Option<Side>,
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    North,
    South,
    East,
    West,
}

fn hemisphere(letter: char) -> Option<Side> {
    match letter.to_ascii_uppercase() {
        'N' => Some(Side::North),
        'S' => Some(Side::South),
        'E' => Some(Side::East), // not O, which is east in German and west in Spanish
        'W' => Some(Side::West),
        _ => None,
    }
}

/// `52.4`, `52.4°`, `52.4N`, `52.4°N`, `-33.9`, `2669m`, `nan`. `None` for anything else, `1e400` and `inf` included as infinite.
fn number(text: &str) -> Option<Number<'_>> {
    let starts_like_one = text.starts_with(|c: char| c.is_ascii_digit() || "+-−.".contains(c));
    let lower = text.to_ascii_lowercase();
    let is_word = matches!(lower.as_str(), "nan" | "inf" | "infinity");
    if !starts_like_one && !is_word {
        return None;
    }
    let side = if is_word { None } else { text.chars().last().and_then(hemisphere) };
    let digits = if side.is_some() { &text[..text.len() - 1] } else { text };
    let digits = digits.strip_suffix('°').or_else(|| digits.strip_suffix('m')).unwrap_or(digits);
    let value = digits.replace('−', "-").parse::<f64>().ok()?;
    Some(Number { text, value, side })
}

fn check(numbers: &[Number<'_>]) -> Result<Coordinates, PlaceError> {
    let (latitude, longitude, height) = match numbers {
        [a, b] => (a, b, None),
        [a, b, c] => (a, b, Some(c)),
        _ => return Err(PlaceError::Count { got: numbers.len() }),
    };
    // With letters the order is free: "13.06E 52.4N".
    let east_west = |n: &Number<'_>| matches!(n.side, Some(Side::East | Side::West));
    let north_south = |n: &Number<'_>| matches!(n.side, Some(Side::North | Side::South));
    let (latitude, longitude) =
        if east_west(latitude) && !east_west(longitude) || north_south(longitude) && !north_south(latitude) {
            (longitude, latitude)
        } else {
            (latitude, longitude)
        };
    for (what, number) in [("latitude", Some(latitude)), ("longitude", Some(longitude)), ("height", height)] {
        if let Some(number) = number.filter(|n| !n.value.is_finite()) {
            return Err(PlaceError::NotFinite { what, text: number.text.to_owned() });
        }
    }
    let signed = |n: &Number<'_>| {
        if matches!(n.side, Some(Side::South | Side::West)) { -n.value } else { n.value }
    };
    let (latitude_deg, longitude_deg) = (signed(latitude), signed(longitude));
    if !(-90.0..=90.0).contains(&latitude_deg) {
        let swapped = (-90.0..=90.0).contains(&longitude_deg) && (-180.0..=360.0).contains(&latitude_deg);
        return Err(PlaceError::Latitude { got: latitude_deg, swapped });
    }
    if !(-180.0..=360.0).contains(&longitude_deg) {
        return Err(PlaceError::Longitude { got: longitude_deg });
    }
    let height_m = height.map_or(0.0, |n| n.value);
    if !(LOWEST_HEIGHT_M..=GREATEST_HEIGHT_M).contains(&height_m) {
        return Err(PlaceError::Height { got: height_m });
    }
    let longitude_deg = if longitude_deg >= 180.0 { longitude_deg - 360.0 } else { longitude_deg };
    Ok(Coordinates { latitude_deg, longitude_deg, height_m })
}

impl Coordinates {
    pub(super) fn into_place(self) -> NamedPlace {
        let Self { latitude_deg, longitude_deg, height_m } = self;
        let (north, east) = (if latitude_deg < 0.0 { 'S' } else { 'N' }, if longitude_deg < 0.0 { 'W' } else { 'E' });
        NamedPlace {
            name: format!("{:.4}° {north}, {:.4}° {east}", latitude_deg.abs(), longitude_deg.abs()),
            latitude_deg,
            longitude_deg,
            height_m,
            time_zone: time_zone(latitude_deg, longitude_deg),
        }
    }
}

/// The IANA zone of a point, of the coarser borders (within 111 m) that tzf-rs carries. It opens the 4 MB table in place.
pub(super) fn time_zone(latitude_deg: f64, longitude_deg: f64) -> String {
    static FINDER: OnceLock<tzf_rs::EmbeddedFinder> = OnceLock::new();
    let name = FINDER.get_or_init(tzf_rs::EmbeddedFinder::new).get_tz_name(longitude_deg, latitude_deg);
    // A gap between two simplified borders, or a pole, has no zone: the nautical one does.
    if name.is_empty() { nautical_zone(longitude_deg) } else { name.to_owned() }
}

/// The zone of the high seas: 15° wide, and by POSIX tradition with the sign the wrong way round.
fn nautical_zone(longitude_deg: f64) -> String {
    let hours = (longitude_deg / 15.0).round() as i32;
    match hours {
        0 => "Etc/GMT".to_owned(),
        east if east > 0 => format!("Etc/GMT-{east}"),
        west => format!("Etc/GMT+{}", -west),
    }
}
