//! Stacks that are solved as a whole, without each of their layers and each of them alone.

mod films;
mod inks;
mod parts;
mod stopped;

use super::run_support::{results, run, study, succeed, value};
use inkwave::input::load::load;
use serde_json::Value;
use std::path::{Path, PathBuf};

const PAPER: f64 = 0.9;

fn error(row: &Value, name: &str) -> f64 {
    row[name]["standard_error"].as_f64().unwrap_or_else(|| panic!("{name}: {row}"))
}

/// Runs a study in a folder of its own.
fn ran(scratch: &Path, name: &str, text: &str) -> PathBuf {
    let folder = scratch.join(name);
    std::fs::create_dir(&folder).unwrap();
    let output = folder.join("out");
    succeed(&study(&folder, text), &output, &[]);
    output
}

/// The rows of a print at 0°.
fn printed(results: &Value) -> Vec<Value> {
    let rows = results["spectra"].as_array().expect("spectra").iter();
    rows.filter(|row| row["polar_deg"].as_f64().is_none_or(|deg| deg == 0.0)).cloned().collect()
}

/// The rows of a stack without a layer, and of that layer alone.
fn left_out(results: &Value, layer: &str) -> Vec<Value> {
    let rows = results["left_out"].as_array().expect("rows without layers").iter();
    rows.filter(|row| row["layer"] == layer).cloned().collect()
}

/// Colours and contrast ratio of a part of a stack are those of a study of it, bars included.
fn assert_same_colours(whole: &Value, layer: &str, part: &str, other: &Value) {
    let all = whole["left_out_colours"].as_array().expect("colours");
    let colours = &all.iter().find(|colours| colours["layer"] == layer).expect("of the layer")[part];
    let same = |one: &Value, two: &Value| {
        let [one, two] = [one, two].map(|x| x.as_f64().unwrap_or(0.0));
        assert!((one - two).abs() < 1e-9, "{layer} {part}: {one} and {two}");
    };
    for (k, name) in ["natural_light", "lit_at_45"].into_iter().enumerate() {
        let colour = &other["colours"][k];
        for i in 0..3 {
            same(&colours[name][i]["value"], &colour["lab"][i]);
            same(&colours[name][i]["standard_error"], &colour["lab_standard_error"][i]);
        }
    }
    let maker = &other["ink_maker"];
    same(&colours["contrast_ratio"]["value"], &maker["contrast_ratio"]["value"]);
    same(&colours["contrast_ratio"]["standard_error"], &maker["contrast_ratio"]["standard_error"]);
    for i in 0..3 {
        same(&colours["over_black"][i]["value"], &maker["over_black"]["lab"][i]);
        same(&colours["over_black"][i]["standard_error"], &maker["over_black"]["lab_standard_error"][i]);
    }
}

/// A clear varnish over two inks in unlike binders.
const INKS: &str = r#"
title = "Varnish and two inks"
[stack]
period_um = 0.8
without_layers = true
[[layer]]
name = "varnish"
thickness_um = 0.3
binder.index = 1.45
[[layer]]
name = "red"
thickness_um = 0.5
binder.index = 1.5
[[layer.pigment]]
name = "red grains"
diameter_nm = 180
volume_fraction = 0.2
index = { n = 1.6, k = 0.08 }
[[layer]]
name = "blue"
thickness_um = 0.4
binder.index = 1.55
[[layer.pigment]]
name = "blue grains"
diameter_nm = 160
volume_fraction = 0.2
index = { n = 1.4, k = 0.03 }
[paper]
albedo = 0.9
[light]
wavelengths_nm = [420, 480, 550, 610, 680]
[angles]
count = 3
[run]
realisations = 4
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 40
[output]
picture_pixels = 16
"#;

/// [`INKS`] without these layers and without the key.
fn inks_without(layers: &[&str]) -> String {
    let mut text = INKS.replace("without_layers = true\n", "");
    for name in layers {
        let from = text.find(&format!("[[layer]]\nname = \"{name}\"")).unwrap();
        let next = text[from + 1..].find("[[layer]]\n").or_else(|| text[from + 1..].find("[paper]")).unwrap();
        text.replace_range(from..from + 1 + next, "");
    }
    text
}

/// Where the key means nothing it is refused.
#[test]
fn what_cannot_be_told_is_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let one = inks_without(&["varnish", "red"])
        .replace("period_um = 0.8\n", "period_um = 0.8\nwithout_layers = true\n");
    let composed =
        INKS.replace("without_layers = true\n", "without_layers = true\ncomposed = { slab_um = 0.5 }\n");
    for (text, words) in [
        (one, "2 layers or more"),
        (composed.replace("count = 3\n", ""), "a composed one tells this without it"),
        (INKS.replace("count = 3", "polar_deg = [0]"), "a stack without paper"),
        (INKS.replace("realisations = 4", "realisations = 1"), "one has no error bar"),
    ] {
        let done = run(&study(scratch.path(), &text), &scratch.path().join("none"), &[]);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        let said = said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(!done.status.success() && said.contains("stack.without_layers"), "{said}");
        assert!(said.contains(words), "{words}: {said}");
    }
}
