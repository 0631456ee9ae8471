//! Longer waves have coarser grids; the accuracy asked for is kept at all of them, and a folder keeps the grids it was begun with.

use crate::run_support::{study, succeed};
use inkwave::store::{PointRecord, Record, Store};
use serde_json::Value;
use std::path::Path;

/// Grains of an index that does not depend on the wavelength: every wave allows the grid λ/λ₀ times coarser.
const STUDY: &str = r#"
title = "Grids"
[layer]
cell = "fixed"
period_um = 0.8
thickness_um = 0.5
binder.index = 1.5
[[pigment]]
name = "p"
diameter_nm = 250
volume_fraction = 0.2
index = { n = 1.9, k = 0.02 }
[light]
wavelengths_nm = [400, 500, 600, 700]
[angles]
polar_deg = [0, 40]
[run]
realisations = 2
seed = 3
[resolution]
accuracy = 1e-3
[solver]
tolerance = 1e-8
"#;

/// Results and solves of a study with another `[resolution]`.
fn ran(folder: &Path, name: &str, text: &str, resolution: &str) -> (Value, Vec<PointRecord>) {
    let home = folder.join(name);
    std::fs::create_dir_all(&home).unwrap();
    let text = text.replace("accuracy = 1e-3", resolution);
    succeed(&study(&home, &text), &home.join("out"), &[]);
    let results = std::fs::read(home.join("out/results.json")).unwrap();
    let store: Store<PointRecord> = Store::open(home.join("out")).unwrap();
    let points = store.database().keys(PointRecord::KIND).iter().filter_map(|key| store.get(key)).collect();
    (serde_json::from_slice(&results).unwrap(), points)
}

/// R and T of the same wave in the same packing.
fn totals(points: &[PointRecord], of: &PointRecord) -> [f64; 2] {
    let same = |p: &&PointRecord| p.realisation == of.realisation && p.incidence == of.incidence;
    let far = points.iter().find(same).expect("the same solve").far_field();
    [far.reflectance, far.transmittance]
}

#[test]
fn longer_waves_have_coarser_grids_that_keep_the_accuracy() {
    let folder = tempfile::tempdir().unwrap();
    let (own, points) = ran(folder.path(), "own", STUDY, "accuracy = 1e-3");
    let (_, exact) = ran(folder.path(), "exact", STUDY, "accuracy = 1e-4\nper_wavelength = false");
    let count = |r: &Value| ["nx", "ny", "cells"].map(|key| r[key].as_u64().unwrap()).iter().product::<u64>();
    let finest = count(&own["resolution"]);
    let longest = count(&own["resolution_longest"]);
    assert!(2 * longest < finest, "{finest} points at 400 nm, {longest} at 700 nm");
    // one grid for all waves is that of the shortest
    let ends = STUDY.replace("[400, 500, 600, 700]", "[400, 700]");
    let (one, _) = ran(folder.path(), "one", &ends, "accuracy = 1e-3\nper_wavelength = false");
    assert_eq!(own["resolution"], one["resolution"], "the shortest waves keep their grid");
    assert!(one.get("resolution_longest").is_none());
    // R and T are sums of squares of amplitudes, which are 1 at most together: twice an amplitude's error bounds theirs.
    for point in &points {
        let [r, t] = totals(&points, point);
        let [exact_r, exact_t] = totals(&exact, point);
        let worst = (r - exact_r).abs().max((t - exact_t).abs());
        assert!(worst < 2e-3, "{worst} at {} µm", point.incidence.wavelength_um);
    }
}
