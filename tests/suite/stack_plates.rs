//! Stacks that are lists of plates, as a user runs them.

use super::run_support::{study, succeed};
use serde_json::Value;
use std::path::Path;

/// A clear varnish, an ink that is solved as a whole, and a white in slabs, which has several thicknesses.
const STACK: &str = r#"
title = "Varnish, ink, white"
[stack]
period_um = 0.8
composed = { slab_um = 0.5 }
[[layer]]
name = "varnish"
thickness_um = 3.0
binder.index = 1.45
[[layer]]
name = "ink"
thickness_um = 0.5
binder.index = 1.5
[[layer.pigment]]
name = "red"
diameter_nm = 200
volume_fraction = 0.2
index = { n = 1.6, k = 0.05 }
[[layer]]
name = "white"
thickness_um = [1, 3]
binder.index = 1.5
[[layer.pigment]]
name = "white"
diameter_nm = 200
volume_fraction = 0.15
index = 2.0
[paper]
albedo = 1.0
[light]
wavelengths_nm = [550, 650]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 24
"#;

fn results(output: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(output.join("results.json")).expect("results")).expect("JSON")
}

fn value(row: &Value, name: &str) -> f64 {
    row[name]["value"].as_f64().expect("a number")
}

/// What the light at 0° loses is what the layers absorb, the varnish and the white nothing; a thicker white passes less;
/// other thicknesses need no further solve; and the file says what became of every layer.
#[test]
fn a_stack_of_plates_runs_and_accounts_for_its_light() {
    let scratch = tempfile::tempdir().unwrap();
    let file = study(scratch.path(), STACK);
    let output = scratch.path().join("out");
    let said = succeed(&file, &output, &[]);
    for words in ["varnish: clear", "ink: solved whole", "white: slabs of 0.50 µm"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let first = results(&output);
    let rows = first["spectra"].as_array().expect("rows");
    let absorbed = first["absorbed"].as_array().expect("absorptances");
    assert_eq!((rows.len(), absorbed.len(), first["status"].as_str()), (4, 12, Some("complete")));
    for (row, layers) in rows.iter().zip(absorbed.chunks(3)) {
        let lost = 1.0 - value(row, "reflectance_normal") - value(row, "transmittance_normal");
        let varnish = value(&layers[0], "absorptance_normal");
        let ink = value(&layers[1], "absorptance_normal");
        let white = value(&layers[2], "absorptance_normal");
        // rounding, and clear grains' solves to their residual
        assert!((varnish + ink + white - lost).abs() < 1e-9, "{layers:?} {lost}");
        assert!(varnish.abs() < 1e-9 && white.abs() < 1e-3 && ink > 0.05, "{layers:?}");
    }
    let through = |k: usize| value(&rows[k], "transmittance_diffuse");
    assert!(through(2) < through(0) && through(3) < through(1));
    let depth = first["depth"].as_array().expect("joints");
    assert_eq!(depth[depth.len() - 1]["depth_um"].as_f64(), Some(4.5));
    assert!(output.join("absorbed.csv").exists() && output.join("report.html").exists());
    let other = study(scratch.path(), &STACK.replace("[1, 3]", "[1, 2.3]"));
    let said = succeed(&other, &output, &[]);
    assert!(said.contains("already stored"), "{said}");
    assert_eq!(results(&output)["spectra"][0], first["spectra"][0]);
}

/// What plates cannot hold is refused with its field.
#[test]
fn what_plates_cannot_hold_is_refused() {
    let cases = [
        ("name = \"ink\"\n", "name = \"ink\"\njoint = \"open\"\n", "layer[1].joint"),
        ("thickness_um = 0.5\n", "thickness_um = 0.5\nslab_um = -1\n", "layer[1].slab_um"),
        ("thickness_um = [1, 3]\n", "thickness_um = [1, 3]\nslab_um = 0.8\n", "layer[2].slab_um"),
        ("thickness_um = [1, 3]\n", "thickness_um = [3, 1]\n", "layer[2].thickness_um"),
        ("thickness_um = 3.0\n", "thickness_um = [3, 4]\n", "layer[2].thickness_um"),
        ("realisations = 2\n", "realisations = 1\n", "run.realisations"),
        ("composed = { slab_um = 0.5 }\n", "", "layer[2].thickness_um"),
        ("[paper]", "[angles]\ncount = 3\n[paper]", "angles"),
    ];
    for (stands, planted, field) in cases {
        assert!(STACK.contains(stands), "{stands}");
        let scratch = tempfile::tempdir().unwrap();
        let file = study(scratch.path(), &STACK.replacen(stands, planted, 1));
        let done = super::run_support::run(&file, &scratch.path().join("out"), &[]);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && said.contains(field), "{field}: {said}");
    }
}
