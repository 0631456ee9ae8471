//! A sweep small enough to be run many times, and the program to run it with.
#![allow(dead_code, reason = "not every test file needs all of it")]

use inkwave::store::{PointRecord, Record, Store};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// 2 shares × 2 papers × 2 sizes (one molecular): 4 wavelengths, 3 angles, 2 realisations; milliseconds a solve.
pub const TINY: &str = r#"
title = "Tiny sweep"
[base.layer]
period_um = 0.8
thickness_um = 0.5
binder.index = 1.558
[[base.pigment]]
name = "yellow"
diameter_nm = 200
volume_fraction = 0.15
index = { built_in = "yellow" }
[base.light]
from_nm = 400
to_nm = 700
step_nm = 100
sampling = "listed"
[base.angles]
count = 3
[base.run]
realisations = 2
seed = 7
[base.resolution]
points_per_um = 20
planes_per_um = 40
[base.output]
picture_pixels = 61
[[axis]]
name = "share"
field = "pigment.yellow.volume_fraction"
values = [0.10, 0.15]
labels = ["10 %", "15 %"]
[[axis]]
name = "size"
field = "pigment[0].diameter_nm"
values = ["molecular", 200]
[[axis]]
name = "paper"
field = "paper.albedo"
values = [0.9, 0.5]
[[conclusion]]
id = "dark paper"
statement = "White paper is lighter"
quantity = "lightness"
plus = [{ share = "10 %", size = 200, paper = 0.9 }]
minus = [{ share = "10 %", size = 200, paper = 0.5 }]
at_least = 5
[[conclusion]]
id = "size"
statement = "Grains transmit more than the molecular mixture"
quantity = "transmittance"
wavelength_nm = 400
plus = [{ share = "15 %", size = 200, paper = 0.9 }]
minus = [{ share = "15 %", size = "molecular", paper = 0.9 }]
at_least = 0.0
"#;

pub fn inkwave(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.args(arguments).env_remove("SLURM_ARRAY_TASK_ID");
    command
}

pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

pub fn succeed(arguments: &[&str]) -> String {
    let output = inkwave(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", said(&output));
    said(&output)
}

pub struct Place(pub tempfile::TempDir);

impl Place {
    pub fn new(text: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        std::fs::write(place.0.path().join("tiny.toml"), text).unwrap();
        place
    }

    /// [`TINY`] with its finished sweep in `output`: a copy of the one that tests share.
    pub fn swept(output: &str) -> Self {
        static SHARED: LazyLock<Place> = LazyLock::new(|| {
            let place = Place::new(TINY);
            place.sweep("out", &[]);
            place
        });
        let place = Self::new(TINY);
        copy_folder(Path::new(&SHARED.path("out")), Path::new(&place.path(output)));
        place
    }

    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    pub fn sweep(&self, output: &str, more: &[&str]) -> String {
        let file = self.path("tiny.toml");
        let output = self.path(output);
        succeed(&[&["sweep", &file, "--output", &output], more].concat())
    }
}

fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let from = entry.unwrap().path();
        let to = to.join(from.file_name().unwrap());
        match from.is_dir() {
            true => copy_folder(&from, &to),
            false => _ = std::fs::copy(&from, &to).unwrap(),
        }
    }
}

pub fn store(folder: &str) -> Store<PointRecord> {
    Store::open(folder).unwrap()
}

pub fn points(folder: &str) -> usize {
    store(folder).database().keys(PointRecord::KIND).len()
}

/// All result files that hold no times.
pub fn results(folder: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let root = Path::new(folder);
    let mut files: Vec<PathBuf> =
        ["sweep.csv", "conclusions.csv", "report.html"].iter().map(|n| root.join(n)).collect();
    let entries = std::fs::read_dir(root).unwrap().map(|f| f.unwrap().path());
    files.extend(entries.filter(|p| p.extension().is_some_and(|e| e == "png")));
    for variant in std::fs::read_dir(root.join("variants")).unwrap() {
        let variant = variant.unwrap().path();
        files.extend(["spectra.csv", "bdf.csv", "picture.png", "study.toml"].map(|name| variant.join(name)));
    }
    files.sort();
    files
        .into_iter()
        .map(|f| (f.strip_prefix(root).unwrap().to_owned(), std::fs::read(&f).unwrap()))
        .collect()
}
