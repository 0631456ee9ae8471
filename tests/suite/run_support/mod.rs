//! A study small enough to be run many times, and the program to run it with.

use serde_json::Value;
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

/// A layer in three thicknesses, composed of slabs: solves of milliseconds.
#[allow(dead_code, reason = "not every test file needs it")]
pub const COMPOSED: &str = r#"
title = "Composed"
[layer]
period_um = 0.8
thickness_um = [1, 2, 50]
binder.index = 1.5
composed = { slab_um = 0.5 }
[[pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.15
index = 2.0
[paper]
albedo = 1.0
[light]
wavelengths_nm = [450, 550, 650]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 36
"#;

/// A text with a part of it replaced, which must be there.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn with(text: &str, part: &str, instead: &str) -> String {
    assert!(text.contains(part), "{part:?} is not in the text: {text}");
    text.replace(part, instead)
}

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

/// What was said on stderr, without the frame and the line breaks of the terminal.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn plain(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '×', '╰', '─', '▶'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `results.json` of a folder.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn results(output: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(output.join("results.json")).expect("results")).expect("JSON")
}

/// The results of a study, run in `out` of a folder.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn results_of(folder: &Path, text: &str) -> Value {
    let out = folder.join("out");
    succeed(&study(folder, text), &out, &[]);
    results(&out)
}

/// The value of a number in a row of results.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn value(row: &Value, name: &str) -> f64 {
    row[name]["value"].as_f64().expect("a number")
}

/// Every column of every table in a folder is described in the `datapackage.json` beside it, in order, and has a unit
/// where its name says one. Gives the number of tables.
#[allow(dead_code, reason = "not every test file needs it")]
pub fn described_tables(folder: &Path) -> usize {
    let mut count = 0;
    let entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    for path in entries {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "records" && name != "inputs" {
            count += described_tables(&path);
        }
        if !name.ends_with(".csv") {
            continue;
        }
        count += 1;
        let package = std::fs::read(folder.join("datapackage.json"))
            .unwrap_or_else(|_| panic!("no datapackage.json beside {}", path.display()));
        let package: serde_json::Value = serde_json::from_slice(&package).unwrap();
        let mut resources = package["resources"].as_array().unwrap().iter();
        let own = resources.find(|resource| resource["path"] == name.as_str());
        let own = own.unwrap_or_else(|| panic!("{name} is not described: {package:#}"));
        assert!(own["description"].is_string(), "{own:#}");
        let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(&path).unwrap();
        let header: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
        let fields = own["schema"]["fields"].as_array().unwrap();
        let names: Vec<&str> = fields.iter().map(|field| field["name"].as_str().unwrap()).collect();
        assert_eq!(names, header, "{name}");
        for field in fields {
            assert!(field["description"].as_str().is_some_and(|about| !about.is_empty()), "{name}: {field}");
            let column = field["name"].as_str().unwrap().trim_end_matches("_standard_error");
            for (ending, unit) in
                [("_nm", "nm"), ("_per_um", "1/µm"), ("_um", "µm"), ("_deg", "°"), ("_per_sr", "1/sr")]
            {
                if column.ends_with(ending) {
                    assert_eq!(field["unit"], unit, "{name}: {field}");
                    break;
                }
            }
        }
    }
    count
}
