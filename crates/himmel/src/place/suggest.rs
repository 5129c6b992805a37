//! Did you mean …?

use super::Suggestions;
use super::fold::fold;
use super::gazetteer::{Called, Gazetteer};

/// Below this likeness (Jaro–Winkler, 1 is equal) a name is no suggestion.
const LEAST_LIKENESS: f64 = 0.8;
pub(super) const MOST_SUGGESTIONS: usize = 3;
/// In powers of ten of people: guesses that much less likely than the best are not shown.
const FAR_BEHIND: f64 = 2.5;

impl Gazetteer {
    /// The names most like one, the bigger place first among equals; those of the country where one was named.
    pub(super) fn suggestions(&self, name: &str, country: Option<&str>) -> Suggestions {
        let wanted = fold(name);
        let length = wanted.chars().count();
        if length == 0 {
            return Suggestions::default();
        }
        let mut best: Vec<(f64, &Called)> = Vec::new();
        for called in &self.called {
            let key = self.key(called);
            // The threshold is out of reach when the lengths are far apart; bytes are near enough to letters here.
            if key.len().abs_diff(wanted.len()) > 1 + length / 4 || strsim::jaro_winkler(key, &wanted) < LEAST_LIKENESS
            {
                continue;
            }
            let edits = strsim::osa_distance(key, &wanted);
            if edits > (length / 4).max(1) {
                continue;
            }
            // One typing error less is worth a hundred times the people, the right country more than either.
            let abroad = country.is_some_and(|country| !self.lies_in(called, country));
            let score = f64::from(called.weight).max(1.0).log10() - 2.0 * edits as f64 - if abroad { 8.0 } else { 0.0 };
            best.push((score, called));
        }
        best.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.entry.cmp(&b.1.entry)));
        // Far behind the best guess nobody is meant.
        let least = best.first().map_or(0.0, |(score, _)| score - FAR_BEHIND);
        best.retain(|(score, _)| *score >= least);
        let mut names: Vec<String> = Vec::new();
        for (_, called) in best {
            let shown = self.entry(called).shown();
            if !names.contains(&shown) {
                names.push(shown);
            }
            if names.len() == MOST_SUGGESTIONS {
                break;
            }
        }
        Suggestions(names)
    }
}
