//! A study small enough to be run many times, and the program to run it with.

use std::path::Path;
use std::process::{Command, Output};

#[allow(dead_code, reason = "not every test file needs it")]
/// 2 realisations × 4 wavelengths × 3 angles: 24 solves of milliseconds.
pub const TINY: &str = r#"
title = "Tiny yellow"
[layer]
period_um = 0.8
thickness_um = 0.5
binder.index = 1.558
[[pigment]]
name = "yellow"
diameter_nm = 200
volume_fraction = 0.15
index = { built_in = "yellow" }
[light]
from_nm = 400
to_nm = 700
step_nm = 100
sampling = "listed"
[angles]
count = 3
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 20
planes_per_um = 40
[output]
picture_pixels = 61
"#;

/// Writes a study file and gives its path.
pub fn study(folder: &Path, text: &str) -> std::path::PathBuf {
    let path = folder.join("study.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// `inkwave run STUDY --output OUTPUT` with further arguments.
pub fn command(study: &Path, output: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.arg("run").arg(study).arg("--output").arg(output).args(more);
    command
}

pub fn run(study: &Path, output: &Path, more: &[&str]) -> Output {
    command(study, output, more).output().unwrap()
}

/// Runs and expects success; gives what was said on stderr.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn succeed(study: &Path, output: &Path, more: &[&str]) -> String {
    let done = run(study, output, more);
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.success(), "{said}");
    said
}
