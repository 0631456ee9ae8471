//! Every field of a study counts: a folder that holds another study's solves gives what a fresh folder gives.
//!
//! A key that forgets an input would hand out an old solve for a new question. So each field is changed in turn, run
//! once over the first study's folder and once afresh, and all published files are compared.

mod run_support;

use run_support::{study, succeed};
use std::path::Path;

const BASE: &str = r#"
title = "Tiny mixture"
[layer]
cell = "varied"
period_um = 0.9
thickness_um = 0.5
binder.index = 1.558
index_below = 1.0
[[pigment]]
name = "yellow"
diameter_nm = 200
volume_fraction = 0.10
index = { n = 1.40, k = 0.1 }
[[pigment]]
name = "clear"
diameter_nm = 180
volume_fraction = 0.05
index = 1.45
[paper]
albedo = 0.9
[light]
from_nm = 400
to_nm = 700
step_nm = 150
[angles]
count = 4
azimuth_deg = 0
[run]
realisations = 2
seed = 7
[packing]
method = "sequential_addition"
[resolution]
points_per_um = 14
planes_per_um = 20
[solver]
strategy = "krylov"
tolerance = 1e-4
[output]
picture_pixels = 61
"#;

/// What stands in the base study, what stands there instead, and whether the published numbers must differ from the base's.
const CHANGES: [(&str, &str, bool); 24] = [
    ("cell = \"varied\"", "cell = \"fixed\"", true),
    ("period_um = 0.9", "period_um = 0.95", true),
    ("thickness_um = 0.5", "thickness_um = 0.51", true),
    ("thickness_um = 0.5", "thickness_um = { mean = 0.5, std = 0.05 }", true),
    ("binder.index = 1.558", "binder.index = 1.559", true),
    ("binder.index = 1.558", "binder.index = { n = 1.558, k = 0.001 }", true),
    ("diameter_nm = 200", "diameter_nm = 201", true),
    ("diameter_nm = 200", "diameter_nm = \"molecular\"", true),
    ("volume_fraction = 0.10", "volume_fraction = 0.11", true),
    ("k = 0.1 }", "k = 0.2 }", true),
    ("n = 1.40,", "n = 1.41,", true),
    ("index = 1.45", "index = 1.46", true),
    ("diameter_nm = 180", "diameter_nm = 180\nshape = \"rice_grain\"", true),
    ("diameter_nm = 180", "diameter_nm = 180\nshare = \"scale_sizes\"", true),
    ("albedo = 0.9", "albedo = 0.8", true),
    ("to_nm = 700", "to_nm = 690\n", true),
    ("count = 4", "count = 5", true),
    ("azimuth_deg = 0", "azimuth_deg = 10", true),
    ("realisations = 2", "realisations = 3", true),
    ("seed = 7", "seed = 8", true),
    ("method = \"sequential_addition\"", "method = \"relaxation\"", true),
    ("points_per_um = 14", "points_per_um = 16", true),
    ("planes_per_um = 20", "planes_per_um = 26", true),
    ("strategy = \"krylov\"", "strategy = \"bicgstab\"", false),
];

/// The published files, without what a repetition may change: times.
fn published(out: &Path) -> Vec<String> {
    let mut results: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("results.json")).unwrap()).unwrap();
    let object = results.as_object_mut().unwrap();
    object.retain(|key, _| !key.contains("seconds") && key != "study_hash" && key != "study");
    let read = |name: &str| std::fs::read(out.join(name)).unwrap_or_default();
    let table = |name: &str| String::from_utf8_lossy(&read(name)).into_owned();
    vec![
        serde_json::to_string_pretty(&results).unwrap(),
        table("spectra.csv"),
        table("bdf.csv"),
        format!("{:?}", pixels(&read("picture.png"))),
    ]
}

/// The picture's pixels; its text chunks name the study.
fn pixels(png: &[u8]) -> Vec<u8> {
    let Ok(mut reader) = png::Decoder::new(std::io::Cursor::new(png)).read_info() else { return Vec::new() };
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels
}

#[test]
fn a_changed_field_is_never_answered_with_an_old_solve() {
    let folder = tempfile::tempdir().unwrap();
    let shared = folder.path().join("shared");
    succeed(&study(folder.path(), BASE), &shared, &[]);
    let base = published(&shared);
    for (k, (stands, instead, differs)) in CHANGES.into_iter().enumerate() {
        assert!(BASE.contains(stands), "{stands}");
        let file = study(folder.path(), &BASE.replacen(stands, instead, 1));
        succeed(&file, &shared, &[]);
        let fresh = folder.path().join(format!("fresh-{k}"));
        succeed(&file, &fresh, &[]);
        let [mixed, alone] = [&shared, &fresh].map(|out| published(out));
        assert!(mixed == alone, "{instead}: another study's solves were taken for this one's");
        assert!(!differs || alone[1] != base[1], "{instead}: spectra.csv does not depend on it");
    }
}
