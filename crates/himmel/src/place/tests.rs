//! Laws and errors of `place`.

use proptest::prelude::*;

use super::{NamedPlace, PlaceError};

fn place(text: &str) -> NamedPlace {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn error(text: &str) -> PlaceError {
    text.parse::<NamedPlace>().expect_err(text)
}

#[test]
fn the_tables_are_read_in_no_time() {
    let start = std::time::Instant::now();
    place("Potsdam");
    error("Potsdm");
    // 15 and 10 ms by measurement; the limit leaves room for a loaded machine and an unoptimised build.
    assert!(start.elapsed().as_millis() < 2000, "{:?}", start.elapsed());
}

#[test]
fn a_name_is_found_however_it_is_spelt() {
    for text in [
        "Potsdam",
        "potsdam",
        " POTSDAM ",
        "Potsdam, DE",
        "Potsdam,de",
        "Potsdam, Germany",
        "Potsdam, DEU",
        "Potsdam (DE)",
    ] {
        assert_eq!(place(text).name, "Potsdam (DE)", "{text}");
    }
    for text in ["München", "Muenchen", "Munchen", "munich", "MÜNCHEN", "Mu\u{308}nchen", "Múnich"] {
        assert_eq!(place(text).name, "Munich (DE)", "{text}");
    }
    for (text, name) in [
        ("New York", "New York City, NY (US)"),
        ("köln", "Köln (DE)"),
        ("Cologne", "Köln (DE)"),
        ("Wien", "Vienna (AT)"),
        ("Praha", "Prague (CZ)"),
        ("Tromso", "Tromsø (NO)"),
        ("sao paulo", "São Paulo (BR)"),
        ("Nis", "Niš (RS)"),
        ("St. Gallen", "Sankt Gallen (CH)"),
        ("st petersburg", "Saint Petersburg (RU)"),
        ("Halle", "Halle (Saale) (DE)"),
        ("Venedig", "Venice (IT)"),
        ("Bruges", "Brugge (BE)"),
        ("Lucerne", "Luzern (CH)"),
        ("La Palma", "Roque de los Muchachos (ES)"),
    ] {
        assert_eq!(place(text).name, name, "{text}");
    }
}

#[test]
fn the_biggest_wins_unless_a_country_is_given() {
    assert_eq!(place("Paris").name, "Paris (FR)");
    assert_eq!(place("Paris, TX").name, "Paris, TX (US)");
    assert_eq!(place("Paris, Texas").name, "Paris, TX (US)");
    assert_eq!(place("Paris, TX (US)").name, "Paris, TX (US)");
    assert_eq!(place("London, Canada").name, "London (CA)");
    assert_eq!(place("London, UK").name, "London (GB)");
    assert_eq!(error("Potsdam, FR").to_string(), "there is no \"Potsdam\" in \"FR\": did you mean Potsdam (DE)?");
}

#[test]
fn what_is_shown_can_be_typed() {
    for text in ["Potsdam", "Paris, TX", "La Paz", "Paranal", "-33.9,18.4"] {
        let shown = place(text).name;
        if text.starts_with('-') {
            continue;
        }
        assert_eq!(place(&shown), place(text), "{shown}");
    }
}

#[test]
fn positions_and_zones_are_those_of_the_place() {
    let potsdam = place("Potsdam");
    assert!((potsdam.latitude_deg - 52.3989).abs() < 1e-9 && (potsdam.longitude_deg - 13.0657).abs() < 1e-9);
    assert_eq!((potsdam.height_m, potsdam.time_zone.as_str()), (0.0, "Europe/Berlin"));
    let paranal = place("Paranal");
    assert_eq!((paranal.height_m, paranal.time_zone.as_str()), (2669.0, "America/Santiago"));
    assert_eq!(place("Mauna Kea").time_zone, "Pacific/Honolulu");
}

#[test]
fn coordinates_are_read_as_people_write_them() {
    for text in [
        "52.39,13.06",
        "52.39, 13.06",
        "52.39 13.06",
        "52.39;13.06",
        "52.39N 13.06E",
        "52.39° N, 13.06° E",
        "13.06E, 52.39N",
        "+52.39,373.06",
    ] {
        let Ok(place) = text.parse::<NamedPlace>() else {
            assert_eq!(text, "+52.39,373.06", "only a longitude beyond a turn fails");
            continue;
        };
        assert!((place.latitude_deg - 52.39).abs() < 1e-9 && (place.longitude_deg - 13.06).abs() < 1e-9, "{text}");
        assert_eq!((place.height_m, place.time_zone.as_str()), (0.0, "Europe/Berlin"), "{text}");
    }
    let cape = place("33.9S 18.4E 1086m");
    assert_eq!((cape.latitude_deg, cape.longitude_deg, cape.height_m), (-33.9, 18.4, 1086.0));
    assert_eq!(cape.name, "33.9000° S, 18.4000° E");
    assert_eq!(place("-24.6,289.6").longitude_deg, 289.6 - 360.0);
    assert_eq!(place("0,180").longitude_deg, -180.0);
    assert_eq!(place("0,360").longitude_deg, 0.0);
}

#[test]
fn every_point_has_a_zone() {
    assert_eq!(place("0,-30").time_zone, "Etc/GMT+2");
    for latitude in (-90..=90).step_by(15) {
        for longitude in (-180..=360).step_by(7) {
            let zone = place(&format!("{latitude},{longitude}")).time_zone;
            assert!(zone.contains('/'), "{latitude},{longitude}: {zone}");
        }
    }
}

#[test]
fn errors_say_what_to_type() {
    for (text, sentence) in [
        ("", "the place is empty: give a city such as \"Potsdam\", or latitude,longitude such as 52.39,13.06"),
        ("Potsdm", "unknown place \"Potsdm\": did you mean Potsdam (DE)"),
        ("95,10", "latitude must lie in -90..=90°, got 95 (are latitude and longitude swapped?)"),
        ("95,195", "latitude must lie in -90..=90°, got 95"),
        ("10,400", "longitude must lie in -180..=360°, got 400"),
        ("10,-181", "longitude must lie in -180..=360°, got -181"),
        ("nan,10", "latitude must be a finite number, got nan"),
        ("10,inf", "longitude must be a finite number, got inf"),
        ("1e400,10", "latitude must be a finite number, got 1e400"),
        ("10,10,NaN", "height must be a finite number, got NaN"),
        ("1e30,10", "latitude must lie in -90..=90°, got 1"),
        ("10,10,1e30", "height must lie in -500..=1e8 m, got 1"),
        ("10,10,-501", "height must lie in -500..=1e8 m, got -501 (metres, not kilometres)"),
        ("52.39", "coordinates are latitude,longitude[,height in metres], got 1 number"),
        (
            "1,2,3,4",
            "coordinates are latitude,longitude[,height in metres], got 4 numbers (decimals take a point, not a comma)",
        ),
        ("🌍", "unknown place \"🌍\": try a bigger city nearby"),
        (",", "unknown place \",\": try a bigger city nearby"),
    ] {
        let got = error(text).to_string();
        assert!(got.starts_with(sentence), "{text}: {got}");
    }
    assert_eq!(error(&"ä".repeat(5_000_000)), PlaceError::TooLong { bytes: 10_000_000 });
}

#[test]
fn misspelt_names_are_guessed() {
    for (text, name) in [
        ("Potsdm", "Potsdam (DE)"),
        ("Berln", "Berlin (DE)"),
        ("Munchenn", "Munich (DE)"),
        ("Reykjavic", "Reykjavík (IS)"),
        ("Sidney", "Sydney (AU)"),
        ("San Fransisco", "San Francisco, CA (US)"),
        ("Los Angelos", "Los Angeles, CA (US)"),
    ] {
        match text.parse::<NamedPlace>() {
            Ok(found) => assert!(["Sidney", "San Fransisco"].contains(&text), "{text}: {}", found.name), // GeoNames has these
            Err(PlaceError::Unknown { suggestions, .. }) => {
                assert!(suggestions.0.contains(&name.to_owned()), "{text}: {suggestions:?}")
            }
            Err(other) => panic!("{text}: {other}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_text_panics(text in any::<String>()) {
        let _ = text.parse::<NamedPlace>();
    }

    #[test]
    fn no_text_made_of_their_letters_panics(text in "[0-9NSEWnaif°.,;+ \\-−m(]{0,24}") {
        let _ = text.parse::<NamedPlace>();
    }

    #[test]
    fn coordinates_come_back(latitude in -90.0..=90.0_f64, longitude in -180.0..180.0_f64, height in -500.0..=1e8_f64) {
        let place: NamedPlace = format!("{latitude},{longitude},{height}").parse().unwrap();
        prop_assert_eq!((place.latitude_deg, place.longitude_deg, place.height_m), (latitude, longitude, height));
    }
}
