//! Every `[key]` in a comment has an entry in `references.bib`, and nothing that was measured goes without a source.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn files(folder: &Path, endings: &[&str], found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            if !path.ends_with("target") && !path.ends_with(".git") {
                files(&path, endings, found);
            }
        } else if path.extension().and_then(|e| e.to_str()).is_some_and(|e| endings.contains(&e)) {
            found.push(path);
        }
    }
}

/// Keys cited in a line of comment: `[hapke1966, eq. 5]`, `[a1999; b2000]`. A key has letters and then a year or a standard's number.
fn cited(line: &str) -> Vec<String> {
    let Some(comment) = line.find("//").map(|at| &line[at..]) else { return Vec::new() };
    let mut keys = Vec::new();
    for bracket in comment.split('[').skip(1) {
        let Some((inside, _)) = bracket.split_once(']') else { continue };
        for part in inside.split(';') {
            let key = part.split(',').next().unwrap_or("").trim();
            let letters = key.chars().take_while(char::is_ascii_lowercase).count();
            let digits = key.chars().skip(letters).take_while(char::is_ascii_digit).count();
            let rest = key.chars().skip(letters + digits).all(|c| c.is_ascii_alphanumeric() || c == '-');
            if letters >= 3 && digits >= 2 && rest && key.len() < 40 {
                keys.push(key.to_string());
            }
        }
    }
    keys
}

fn known() -> BTreeSet<String> {
    let text = std::fs::read_to_string(root().join("references.bib")).expect("references.bib");
    text.lines()
        .filter_map(|line| line.trim().strip_prefix('@')?.split_once('{'))
        .map(|(_, key)| key.trim_end_matches(',').trim().to_string())
        .collect()
}

#[test]
fn every_citation_has_an_entry() {
    let known = known();
    let mut sources = Vec::new();
    for folder in ["crates", "apps", "xtask", "tests/support"] {
        files(&root().join(folder), &["rs", "wgsl"], &mut sources);
    }
    let mut missing = BTreeSet::new();
    let mut count = 0;
    for path in &sources {
        for line in std::fs::read_to_string(path).unwrap_or_default().lines() {
            for key in cited(line) {
                count += 1;
                if !known.contains(&key) {
                    missing.insert(format!("{key} in {}", path.display()));
                }
            }
        }
    }
    assert!(count > 20, "only {count} citations found: the reader is broken");
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn the_reader_of_citations_reads() {
    assert_eq!(cited("/// B [hapke1966, eq. 5] and [a2017b; bruneton2017, \"T\"]"), ["hapke1966", "bruneton2017"]);
    assert!(cited("let x = [abc1999];").is_empty());
}

#[test]
fn every_folder_of_assets_names_its_source() {
    let mut tables = Vec::new();
    files(&root().join("assets"), &["csv", "tsv", "bin", "pack"], &mut tables);
    assert!(tables.len() >= 6);
    for table in tables {
        let folder = table.parent().expect("a folder");
        assert!(folder.join("SOURCE.md").exists(), "{} has no SOURCE.md", folder.display());
    }
}
