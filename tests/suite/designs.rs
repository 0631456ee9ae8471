//! Whole designs: a dye in a film, and grains in small cells, from the file to the verdict.

use inkwave::design::recipe::load;
use inkwave::design::run::{DesignOutcome, DesignRun};
use inkwave::run::RunSettings;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// A dye of unknown share in a film of 1 µm.
const DYE: &str = r#"
[target]
lab = [LAB]
[[vary]]
field = "pigment[0].volume_fraction"
from = 0.05
to = 0.4
[design]
delta_e = 0.5
[base.layer]
thickness_um = 1.0
binder.index = 1.5
[[base.pigment]]
name = "dye"
diameter_nm = "molecular"
volume_fraction = 0.1
index = { built_in = "yellow" }
[base.paper]
albedo = 0.9
[base.light]
from_nm = 400
to_nm = 700
step_nm = 20
sampling = "listed"
[base.angles]
count = 5
[base.run]
realisations = 2
[base.resolution]
points_per_um = 4
planes_per_um = 8
"#;

fn write(folder: &Path, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("written");
    path
}

fn inkwave(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.args(arguments).current_dir(folder).output().expect("the program")
}

/// Standard error without the frame that the terminal report draws around it.
fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '×', '╰', '─', '▶'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn designed(text: &str) -> DesignOutcome {
    let folder = tempfile::tempdir().expect("a folder");
    let task = load(&write(folder.path(), "design.toml", text)).expect("a design");
    let folder = OutputFolder::open(&folder.path().join("out"), Holds::Design).expect("a folder");
    let run = DesignRun { task: &task, folder: &folder, settings: RunSettings::default(), watch: &() };
    run.design().expect("designed")
}
