//! Preset files that are broken in every way: each gives a preset or an error on one line, and nothing panics.
//!
//! 3,000 cases by default; `HIMMEL_FUZZ_CASES=1000000 cargo test -p himmel-air --test fuzz_presets` for the full run.

use himmel_air::Preset;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

macro_rules! texts {
    ($($name:literal),+ $(,)?) => { &[$(include_str!(concat!("../../../assets/presets/", $name, ".toml"))),+] };
}

/// Presets to break. `venus` and `earth-volcanic` compute spheres and cost 100 ms each, so they are broken rarely.
const QUICK: &[&str] = texts![
    "earth",
    "bruneton2017",
    "earth-haze",
    "mars-reference",
    "titan-reference",
    "earth-klupiec",
    "earth-mueller-clean",
    "mars",
    "mars-collienne",
    "titan",
    "moonlet",
    "giant",
    "m-dwarf-ocean",
];
const SLOW: &[&str] = texts!["venus", "earth-volcanic"];

/// What numbers become.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-308",
    "1e40",
    "1e30",
    "1e-30",
    "9223372036854775807",
    "0.5",
    "1",
    "2.5",
    "380",
    "1e5",
    "true",
    "\"x\"",
    "[]",
    "{}",
    "[1, 2]",
    "{ reference_nm = 1e-300, value = 1e300, exponent = -4 }",
];

/// A way to break a text; the numbers choose where.
fn break_text(text: &str, other: &str, edits: &[(u8, u16, u16)]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    for &(kind, place, with) in edits {
        if lines.is_empty() {
            break;
        }
        let (at, with) = (place as usize % lines.len(), with as usize);
        match kind % 8 {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[with % lines.len()].clone()),
            2 => {
                let len = lines.len();
                lines.swap(at, with % len);
            }
            3 => lines.insert(at, other.lines().nth(with % other.lines().count().max(1)).unwrap_or("").to_string()),
            4 => lines.truncate(at),
            5 => {
                // A letter in the middle of something.
                let mut letters: Vec<char> = lines[at].chars().collect();
                if !letters.is_empty() {
                    let index = with % letters.len();
                    letters[index] = ['=', '[', '}', '"', 'é', '\u{0}', '.', '-', '9'][with % 9];
                    lines[at] = letters.into_iter().collect();
                }
            }
            _ => {
                // Another value behind the last "=" or within a list.
                let line = &lines[at];
                let cut =
                    line.char_indices().filter(|(_, c)| matches!(c, '=' | ',' | '[')).map(|(i, _)| i).nth(with % 3);
                if let Some(cut) = cut {
                    let rest = &line[cut + 1..];
                    let end = rest.find([',', ']', '}', '#']).unwrap_or(rest.len());
                    lines[at] = format!("{} {}{}", &line[..=cut], NUMBERS[with % NUMBERS.len()], &rest[end..]);
                }
            }
        }
    }
    lines.join("\n")
}

#[test]
fn broken_presets_are_errors_and_never_panics() {
    let cases = std::env::var("HIMMEL_FUZZ_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(3000);
    let mut runner = TestRunner::new(Config { cases, failure_persistence: None, ..Config::default() });
    let edits = proptest::collection::vec(any::<(u8, u16, u16)>(), 1..5);
    let accepted = std::cell::Cell::new(0u64);
    runner
        .run(&(any::<u16>(), any::<u16>(), edits), |(which, other, edits)| {
            let slow = which % 1000 == 7;
            let text =
                if slow { SLOW[which as usize / 1000 % SLOW.len()] } else { QUICK[which as usize % QUICK.len()] };
            let broken = break_text(text, QUICK[other as usize % QUICK.len()], &edits);
            match Preset::from_toml(&broken, "fuzz.toml") {
                Ok(preset) => {
                    accepted.set(accepted.get() + 1);
                    let air = preset.medium.sampled(&[380.0, 550.0, 780.0]);
                    for altitude_m in [0.0, 1e4, 1e6] {
                        for extinction in air.extinction_per_m(altitude_m) {
                            prop_assert!(extinction.is_finite() && extinction >= 0.0, "{extinction}\n{broken}");
                        }
                    }
                    prop_assert!(preset.medium.top_altitude_m > 0.0);
                }
                Err(error) => {
                    let text = error.to_string();
                    prop_assert!(text.starts_with("fuzz.toml: ") && !text.contains('\n'), "{text}");
                }
            }
            Ok(())
        })
        .unwrap();
    println!("{cases} broken presets, {} of them still good", accepted.get());
}
