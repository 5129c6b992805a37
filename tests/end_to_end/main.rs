//! End to end: the command line as people run it.

mod astronomy;
mod bad_input;
mod bench;
mod examples;
mod night;
mod optics;
mod pictures;
mod radiance;
mod reference_picture;

use std::path::Path;
use std::process::{Command, Output};

/// Runs `himmel` in a folder.
fn himmel(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_himmel"))
        .args(args)
        .current_dir(folder)
        .env("NODEVICE_SELECT", "1")
        .output()
        .expect("himmel starts")
}

/// Runs it and insists on success; gives its standard output.
fn succeed(folder: &Path, args: &[&str]) -> String {
    let output = himmel(folder, args);
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "himmel {args:?}\n{out}{err}");
    out.into_owned()
}

/// Names of the files in a folder.
fn listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
