//! Names of places: GeoNames' cities and a list of observing sites, both embedded.

use std::collections::HashMap;
use std::sync::OnceLock;

use super::fold::{fold, fold_german_into, fold_into};
use super::parse::time_zone;
use super::suggest::MOST_SUGGESTIONS;
use super::{NamedPlace, PlaceError};

const CITIES: &str = include_str!("../../../../assets/places/cities.tsv");
const SITES: &str = include_str!("../../../../assets/places/sites.tsv");
const COUNTRIES: &str = include_str!("../../../../assets/places/countries.tsv");

/// A name in another language counts as if the place had so much fewer people: `Nis` is Niš (260,000), not Nice (340,000).
const OTHER_NAME_DIVISOR: f64 = 8.0;
/// An observing site counts as a place of so many people: `Greenwich` is the observatory, `Sutherland` the telescopes.
const SITE_PEOPLE: f64 = 50_000.0;
/// One row of either table, as text until someone asks for it.
pub(super) struct Entry {
    name: &'static str,
    country: &'static str,
    region: &'static str,
    latitude_deg: &'static str,
    longitude_deg: &'static str,
    /// Empty where it is not known.
    height_m: &'static str,
    /// Empty where the position says it.
    time_zone: &'static str,
    people: f64,
}

/// A folded name, where it stands in [`Gazetteer::keys`], whose it is, and what that is worth.
#[derive(Clone, Copy)]
pub(super) struct Called {
    start: u32,
    end: u32,
    pub(super) entry: u32,
    pub(super) weight: f32,
}

pub(super) struct Gazetteer {
    entries: Vec<Entry>,
    /// All folded names, one after the other: a hundred thousand small strings would take longer to allocate than to search.
    keys: String,
    pub(super) called: Vec<Called>,
    /// From folded codes and names to (country, region): `de`, `deu`, `germany`, `tx`, `texas`.
    countries: HashMap<String, Vec<(&'static str, &'static str)>>,
}

/// The tables, read once: some 15 ms.
fn gazetteer() -> &'static Gazetteer {
    static TABLES: OnceLock<Gazetteer> = OnceLock::new();
    TABLES.get_or_init(Gazetteer::read)
}

/// A name's place, or what else it may have meant. Text after the first comma is a country or a state of the USA.
pub(super) fn find(text: &str) -> Result<NamedPlace, PlaceError> {
    let tables = gazetteer();
    let (name, country) = match text.split_once(',') {
        Some((name, country)) if !country.trim().is_empty() => (name.trim(), Some(country.trim())),
        Some((name, _)) => (name.trim(), None),
        None => (text, None),
    };
    // "Potsdam (DE)" is how we show it, so it can be typed back; but "Halle (Saale)" is a name.
    let (name, country) = match (name.strip_suffix(')').and_then(|n| n.rsplit_once('(')), country) {
        (Some((name, inside)), None) if tables.named(&fold(text)).is_empty() => (name.trim(), Some(inside.trim())),
        _ => (name, country),
    };
    let found = tables.named(&fold(name));
    let Some(biggest) = found.first() else {
        return Err(PlaceError::Unknown { text: text.to_owned(), suggestions: tables.suggestions(name, country) });
    };
    let chosen = match country {
        None => biggest,
        Some(country) => {
            found.iter().find(|called| tables.lies_in(called, country)).ok_or_else(|| PlaceError::NotInThatCountry {
                name: name.to_owned(),
                country: country.to_owned(),
                elsewhere: found.iter().take(MOST_SUGGESTIONS).map(|called| tables.entry(called).shown()).collect(),
            })?
        }
    };
    Ok(tables.entry(chosen).place())
}

impl Gazetteer {
    fn read() -> Self {
        let mut tables =
            Self { entries: Vec::new(), keys: String::new(), called: Vec::new(), countries: HashMap::new() };
        for line in rows(CITIES) {
            let [name, other, country, region, latitude_deg, longitude_deg, people, time_zone] = columns(line);
            let people = people.parse().unwrap_or(0.0);
            let entry = Entry { name, country, region, latitude_deg, longitude_deg, height_m: "", time_zone, people };
            tables.add(entry, other, OTHER_NAME_DIVISOR);
        }
        for line in rows(SITES) {
            let [name, other, country, latitude_deg, longitude_deg, height_m, time_zone, _source] = columns(line);
            let (region, people) = ("", SITE_PEOPLE);
            let entry = Entry { name, country, region, latitude_deg, longitude_deg, height_m, time_zone, people };
            // A site's other names are as good as its first.
            tables.add(entry, other, 1.0);
        }
        for line in rows(COUNTRIES) {
            let [code, iso3, name] = columns(line);
            let (country, region) = code.split_once('-').unwrap_or((code, ""));
            for called in [if region.is_empty() { country } else { region }, iso3, name] {
                tables.countries.entry(fold(called)).or_default().push((country, region));
            }
        }
        for (called, code) in
            [("usa", "US"), ("uk", "GB"), ("england", "GB"), ("scotland", "GB"), ("deutschland", "DE")]
        {
            tables.countries.entry(called.to_owned()).or_default().push((code, ""));
        }
        tables
    }

    fn add(&mut self, entry: Entry, other_names: &'static str, other_name_divisor: f64) {
        let index = self.entries.len() as u32;
        let others = other_names.split(';').filter(|name| !name.is_empty()).map(|name| (name, other_name_divisor));
        // «Halle (Saale)» is called Halle as well.
        let short = entry.name.split_once(" (").map(|(name, _)| (name, 1.0));
        for (name, divisor) in std::iter::once((entry.name, 1.0)).chain(short).chain(others) {
            let weight = (entry.people / divisor) as f32;
            for spell in [fold_into, fold_german_into] {
                let start = self.keys.len() as u32;
                spell(name, &mut self.keys);
                let end = self.keys.len() as u32;
                if start < end {
                    self.called.push(Called { start, end, entry: index, weight });
                }
            }
        }
        self.entries.push(entry);
    }

    pub(super) fn key(&self, called: &Called) -> &str {
        &self.keys[called.start as usize..called.end as usize]
    }

    /// Who is called so, the heaviest first, each once.
    fn named(&self, key: &str) -> Vec<Called> {
        let mut found: Vec<Called> = self.called.iter().filter(|called| self.key(called) == key).copied().collect();
        found.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let mut seen = Vec::new();
        found.retain(|called| {
            !seen.contains(&called.entry) && {
                seen.push(called.entry);
                true
            }
        });
        found
    }

    pub(super) fn entry(&self, called: &Called) -> &Entry {
        &self.entries[called.entry as usize]
    }

    /// Whether an entry lies in what was typed as its country: `US`, `USA`, `Texas`, `TX, US`.
    pub(super) fn lies_in(&self, called: &Called, country: &str) -> bool {
        let entry = self.entry(called);
        let mut parts = country.split([',', '(', ')']).map(fold).filter(|part| !part.is_empty());
        parts.all(|part| {
            self.countries.get(&part).is_some_and(|meant| {
                meant.iter().any(|&(c, r)| c == entry.country && (r.is_empty() || r == entry.region))
            })
        })
    }
}

impl Entry {
    /// `Potsdam (DE)`, `Paris, TX (US)`, `South Pole` where there is no country.
    pub(super) fn shown(&self) -> String {
        match (self.country, self.region) {
            ("", _) => self.name.to_owned(),
            (country, "") => format!("{} ({country})", self.name),
            (country, region) => format!("{}, {region} ({country})", self.name),
        }
    }

    fn place(&self) -> NamedPlace {
        // Only an unknown height falls back: a test reads every row of both tables.
        let number = |text: &str| text.parse().unwrap_or(0.0);
        let (latitude_deg, longitude_deg) = (number(self.latitude_deg), number(self.longitude_deg));
        let zone =
            if self.time_zone.is_empty() { time_zone(latitude_deg, longitude_deg) } else { self.time_zone.to_owned() };
        NamedPlace { name: self.shown(), latitude_deg, longitude_deg, height_m: number(self.height_m), time_zone: zone }
    }
}

/// The rows below the header.
fn rows(table: &'static str) -> impl Iterator<Item = &'static str> {
    table.lines().skip(1).filter(|line| !line.is_empty())
}

/// The columns of a row; absent ones are empty.
fn columns<const N: usize>(line: &'static str) -> [&'static str; N] {
    let mut parts = line.split('\t');
    std::array::from_fn(|_| parts.next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_both_tables_is_a_place() {
        let tables = gazetteer();
        assert!(tables.entries.len() > 34_000);
        for entry in &tables.entries {
            let place = entry.place();
            assert!((-90.0..=90.0).contains(&entry.latitude_deg.parse::<f64>().unwrap()), "{}", place.name);
            assert!((-180.0..=180.0).contains(&entry.longitude_deg.parse::<f64>().unwrap()), "{}", place.name);
            assert!(entry.height_m.is_empty() || (-500.0..=9000.0).contains(&entry.height_m.parse::<f64>().unwrap()));
            assert!(place.time_zone.contains('/'), "{}", place.name);
            assert!(!fold(entry.name).is_empty(), "{}", place.name);
        }
    }

    #[test]
    fn what_is_shown_finds_the_place_again() {
        // Every 67th row: all of them passed, in 17 s. A town that is also an old name of a city nearby (Erebuni, Yerevan)
        // loses to it, by the rule; so do a few of several towns with one name in one state.
        let (mut asked, mut others) = (0, Vec::new());
        for entry in gazetteer().entries.iter().step_by(67) {
            asked += 1;
            match find(&entry.shown()) {
                Ok(found) if found.name == entry.shown() => {}
                Ok(found) => others.push(found.name),
                Err(error) => panic!("{}: {error}", entry.shown()),
            }
        }
        assert!(others.len() * 50 < asked, "{} of {asked}: {others:?}", others.len());
    }
}
