//! `cargo xtask golden …`

use crate::error::GoldenError;
use crate::golden::{GoldenSet, MODE_VARIABLE, workspace_root};
use std::io::Write;
use std::process::Command;

/// What `cargo xtask golden` takes.
pub const USAGE: &str = "cargo xtask golden propose [TEST…] | review | accept NAME… | accept --all";

/// Runs `cargo xtask golden ARGS` on this workspace's goldens and prints what it found.
///
/// `propose [TEST…]` runs the golden tests so that each leaves its new picture in `target/golden/`; with names of
/// tests only those, keeping the other proposals. `review` prints a table and writes a sheet for each proposal.
/// `accept NAME…` moves proposals into `tests/golden/accepted/`; `accept --all` moves all.
pub fn run(args: &[String]) -> Result<(), GoldenError> {
    run_on(&GoldenSet::of_workspace()?, args, &mut std::io::stdout(), &mut golden_tests())
}

/// The command that runs the golden tests; the names of tests come last.
fn golden_tests() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.current_dir(workspace_root()).args(["test", "-p", "himmel-tests", "--test", "golden", "--"]);
    cargo
}

/// [`run`] on any set, with the command that runs the tests.
fn run_on(set: &GoldenSet, args: &[String], out: &mut dyn Write, tests: &mut Command) -> Result<(), GoldenError> {
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let text = match args.as_slice() {
        ["propose", names @ ..] => {
            propose(set, names, tests)?;
            set.review()?.to_string()
        }
        ["review"] => set.review()?.to_string(),
        ["accept", "--all"] => set.accept_all()?.to_string(),
        ["accept"] => return Err(GoldenError::Usage("accept needs names, or --all".into())),
        ["accept", names @ ..] => set.accept(names)?.to_string(),
        [] => return Err(GoldenError::Usage("golden needs a command".into())),
        other => {
            return Err(GoldenError::Usage(format!("cannot make sense of `{}`", other.join(" "))));
        }
    };
    // A closed pipe (`… | head`) is the reader's wish, not a failure.
    let _ = out.write_all(text.as_bytes());
    Ok(())
}

fn propose(set: &GoldenSet, names: &[&str], tests: &mut Command) -> Result<(), GoldenError> {
    if names.is_empty() {
        set.clear_proposals()?;
    }
    let status = tests.args(names).env(MODE_VARIABLE, "propose").status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(GoldenError::Tests(status.to_string())),
        Err(e) => Err(GoldenError::Tests(e.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FlipTolerance, Mode};

    fn run_in(set: &GoldenSet, args: &[&str], tests: &str) -> Result<String, GoldenError> {
        let args: Vec<String> = args.iter().map(|a| (*a).to_owned()).collect();
        let mut out = Vec::new();
        run_on(set, &args, &mut out, &mut Command::new(tests))?;
        Ok(String::from_utf8(out).unwrap())
    }

    #[test]
    fn review_then_accept_then_pass() {
        let folder = tempfile::tempdir().unwrap();
        let set = GoldenSet {
            accepted_dir: folder.path().join("accepted"),
            work_dir: folder.path().join("work"),
            mode: Mode::Check,
        };
        let check = || set.check_png("dusk", 2, 2, &[9; 12], FlipTolerance::default());
        assert!(check().is_err());
        let table = run_in(&set, &["review"], "").unwrap();
        assert!(table.contains("dusk  png   new") && table.contains("dusk.sheet.png"), "{table}");
        assert!(matches!(run_in(&set, &["accept", "dawn"], ""), Err(GoldenError::NoProposal { .. })));
        assert_eq!(run_in(&set, &["accept", "dusk"], "").unwrap(), "dusk: added\n");
        assert!(check().is_ok());
        assert_eq!(run_in(&set, &["accept", "--all"], "").unwrap(), "no proposals to accept\n");
    }

    #[test]
    fn nonsense_is_answered_with_the_usage() {
        let folder = tempfile::tempdir().unwrap();
        let set = GoldenSet { accepted_dir: folder.path().into(), work_dir: folder.path().into(), mode: Mode::Check };
        for args in [&[][..], &["accept"], &["acept", "x"], &["review", "x"]] {
            let said = run_in(&set, args, "").unwrap_err().to_string();
            assert!(said.contains(USAGE), "{said}");
        }
        assert!(matches!(run_in(&set, &["accept", "../x"], ""), Err(GoldenError::Name(_))));
    }

    #[cfg(unix)]
    #[test]
    fn propose_runs_the_tests_and_says_when_they_fail() {
        let folder = tempfile::tempdir().unwrap();
        let set = GoldenSet { accepted_dir: folder.path().into(), work_dir: folder.path().into(), mode: Mode::Check };
        assert!(run_in(&set, &["propose"], "true").unwrap().starts_with("0 proposals"));
        assert!(matches!(run_in(&set, &["propose"], "false"), Err(GoldenError::Tests(_))));
        assert!(matches!(run_in(&set, &["propose"], "/no/such/command"), Err(GoldenError::Tests(_))));
        // The script succeeds only when it sees the variable and the name of the test.
        let script = folder.path().join("tests.sh");
        std::fs::write(&script, "test \"$HIMMEL_GOLDEN\" = propose && test \"$1\" = twilight\n").unwrap();
        let args = ["propose".to_owned(), "twilight".to_owned()];
        run_on(&set, &args, &mut Vec::new(), Command::new("sh").arg(&script)).unwrap();
    }
}
