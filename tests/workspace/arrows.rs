//! The crates' arrows of design.md: core ← {astro, air} ← cloud ← gpu ← himmel ← {cli, editor, web, bevy}.

use std::process::Command;

/// Rank of each crate; a crate may use only those of a lower rank.
const RANKS: [(&str, u32); 6] =
    [("himmel-core", 0), ("himmel-astro", 1), ("himmel-air", 1), ("himmel-gpu", 3), ("himmel", 4), ("himmel-cli", 5)];

/// What the crates below the GPU must not know.
const GPU_CRATES: [&str; 3] = ["wgpu", "naga", "pollster"];

fn metadata() -> serde_json::Value {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo metadata runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Crate and the crates that it uses outside its tests.
fn arrows(metadata: &serde_json::Value) -> Vec<(String, Vec<String>)> {
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_string();
    let packages = metadata["packages"].as_array().expect("packages");
    packages
        .iter()
        .map(|package| {
            let all = package["dependencies"].as_array().expect("dependencies");
            let used = all.iter().filter(|d| d["kind"] != "dev").map(|d| text(&d["name"])).collect();
            (text(&package["name"]), used)
        })
        .collect()
}

fn violations(arrows: &[(String, Vec<String>)]) -> Vec<String> {
    let rank = |name: &str| RANKS.iter().find(|(known, _)| *known == name).map(|(_, rank)| *rank);
    let mut found = Vec::new();
    for (name, uses) in arrows {
        let Some(own) = rank(name) else { continue };
        for used in uses {
            if rank(used).is_some_and(|theirs| theirs >= own) {
                found.push(format!("{name} must not use {used}"));
            }
            if own < 3 && GPU_CRATES.contains(&used.as_str()) {
                found.push(format!("{name} must build without {used}"));
            }
        }
    }
    found
}

#[test]
fn arrows_point_one_way() {
    let arrows = arrows(&metadata());
    for (name, _) in RANKS {
        assert!(arrows.iter().any(|(known, _)| known == name), "{name} is gone; update RANKS");
    }
    assert_eq!(violations(&arrows), Vec::<String>::new());
    for (name, _) in &arrows {
        let known = RANKS.iter().any(|(known, _)| known == name)
            || ["xtask", "himmel-tests", "himmel-golden"].contains(&name.as_str());
        assert!(known, "{name} has no rank");
    }
}

#[test]
fn a_wrong_arrow_is_noticed() {
    let backwards = vec![("himmel-core".to_string(), vec!["himmel-air".to_string(), "wgpu".to_string()])];
    let sideways = vec![("himmel-air".to_string(), vec!["himmel-astro".to_string()])];
    assert_eq!(violations(&backwards).len(), 2);
    assert_eq!(violations(&sideways).len(), 1);
}
