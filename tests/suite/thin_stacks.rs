//! Stacks that are solved as one: what their files hold, relief, and runs that end at a target.

use super::run_support::{run, study, succeed};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A clear varnish over two inks in unlike binders.
const STACK: &str = r#"
title = "Varnish over two inks"
[stack]
period_um = 0.8
[[layer]]
name = "varnish"
thickness_um = 0.3
binder.index = 1.5
[[layer]]
name = "top"
thickness_um = 0.4
binder.index = 1.55
[[layer.pigment]]
name = "red"
diameter_nm = 150
volume_fraction = 0.05
index = { n = 1.6, k = 0.05 }
[[layer]]
name = "bottom"
thickness_um = 0.3
binder.index = 1.6
[[layer.pigment]]
name = "blue"
diameter_nm = 150
volume_fraction = 0.05
index = { n = 1.5, k = 0.02 }
[paper]
albedo = 0.9
[light]
wavelengths_nm = [400, 450, 500, 550, 600, 650, 700]
[run]
realisations = 1
seed = 7
[resolution]
points_per_um = 16
planes_per_um = 36
[output]
picture_pixels = 16
"#;

fn results(output: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(output.join("results.json")).expect("results")).expect("JSON")
}

fn exported(output: &Path, format: &str, to: &Path) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    let done = command.arg("export").arg(output).args(["--to", format, "-o"]).arg(to).output().unwrap();
    assert!(done.status.success(), "{format}: {}", String::from_utf8_lossy(&done.stderr));
    [done.stdout, done.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat()
}

/// Grains lie in their layers, and files say where these are and that each has its own binder: read back as grains of
/// one layer they would be another print. *Planted*: the hint of a single layer.
#[test]
fn files_of_a_stack_tell_its_layers() {
    let scratch = tempfile::tempdir().unwrap();
    let output = scratch.path().join("out");
    succeed(&study(scratch.path(), STACK), &output, &[]);
    let to = scratch.path().join("positions");
    let said = exported(&output, "positions", &to);
    for words in ["varnish to z = 0.3000 µm in a binder of 1.5", "bottom to z = 1.0000 µm in a binder of 1.6"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
    let mut grains = csv::Reader::from_path(to.join("grains.csv")).unwrap();
    let mut counts = [0; 2];
    for row in grains.deserialize::<std::collections::BTreeMap<String, String>>() {
        let row = row.unwrap();
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let pigment = number("pigment") as usize;
        let [from, to] = [[0.3, 0.7], [0.7, 1.0]][pigment];
        let (z, r) = (number("z_um"), number("radius_um"));
        // rounding
        assert!(z - r > from - 1e-9 && z + r < to + 1e-9, "{row:?}");
        counts[pigment] += 1;
    }
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
    let said = exported(&output, "labels", &scratch.path().join("labels"));
    assert!(said.contains("0 is each layer's own binder") && !said.contains("voxel_nm"), "{said}");
    let said = exported(&output, "vti", &scratch.path().join("vti"));
    assert!(said.contains("less that of the first layer's binder"), "{said}");
    for format in ["mitsuba", "cxf", "cgats", "npz", "viewer", "crate"] {
        let to = scratch.path().join(format);
        exported(&output, format, &to);
        assert!(std::fs::read_dir(to).unwrap().count() > 1, "{format}");
    }
    // the spectra of the file are those of the run
    let text = std::fs::read_to_string(scratch.path().join("cgats").join("spectra.cgats")).unwrap();
    let fields: Vec<&str> =
        text.lines().find(|line| line.starts_with("SAMPLE_ID")).unwrap().split(' ').collect();
    let line = text.lines().find(|line| line.starts_with("2 ")).expect("the print under a uniform sky");
    let values = line.rsplit(' ').collect::<Vec<_>>();
    let of = |nm: usize| {
        let from_end = fields.len() - fields.iter().position(|f| *f == format!("SPEC_{nm}")).unwrap() - 1;
        values[from_end].parse::<f64>().unwrap() / 100.0
    };
    let all = results(&output);
    let rows = all["spectra"].as_array().unwrap();
    for row in rows.iter().filter(|row| row["polar_deg"].as_f64() == Some(0.0)) {
        let own = row["natural_light"]["value"].as_f64().unwrap();
        let nm = row["wavelength_nm"].as_f64().unwrap() as usize;
        // six decimals of per cents
        assert!((of(nm) - own).abs() < 1e-7, "{nm} nm: {} and {own}", of(nm));
    }
}

/// A stack is solved until the interval of its colour is as narrow as asked. *Planted*: the target not compared.
#[test]
fn a_stack_reaches_its_target() {
    let scratch = tempfile::tempdir().unwrap();
    let output = scratch.path().join("out");
    let bottom = STACK.find("[[layer]]\nname = \"bottom\"").unwrap()..STACK.find("[paper]").unwrap();
    let text = STACK.replace(&STACK[bottom], "").replace("realisations = 1\n", "target_delta_e = 1.0\n");
    succeed(&study(scratch.path(), &text), &output, &[]);
    let found = results(&output);
    let reached = found["colours"][0]["delta_e_2000_95"].as_f64().expect("an interval");
    let [asked, finished] = ["asked", "finished"].map(|k| found["realisations"][k].as_u64().unwrap());
    assert!(reached <= 1.0 && finished > 1 && finished < asked, "{reached}, {finished} of {asked}");
}

/// A rough outer face loses no light, on either side, and is not a plane one; faces inside are refused, and so are those of
/// layers without grains, which would be plane without a word.
#[test]
fn outer_faces_of_a_stack_may_be_rough() {
    let scratch = tempfile::tempdir().unwrap();
    let clear = STACK.replace(", k = 0.05", ", k = 0").replace(", k = 0.02", ", k = 0");
    let clear = clear.replace("[400, 450, 500, 550, 600, 650, 700]", "[550]");
    let varnish = clear.find("[[layer]]\nname = \"varnish\"").unwrap()
        ..clear.find("[[layer]]\nname = \"top\"").unwrap();
    let inks = clear.replace(&clear[varnish], "");
    let at_front = inks.replace("index = 1.55\n", "index = 1.55\nrelief = { depth_um = 0.1 }\n");
    let behind = inks.replace("index = 1.6\n", "index = 1.6\nrelief = { depth_um = 0.1, face = \"exit\" }\n");
    let mut passed = Vec::new();
    for (k, text) in [&inks, &at_front, &behind].into_iter().enumerate() {
        let folder = scratch.path().join(k.to_string());
        std::fs::create_dir(&folder).unwrap();
        let output = folder.join("out");
        succeed(&study(&folder, text), &output, &[]);
        let row = results(&output)["spectra"][0].clone();
        let [r, t] = ["reflectance", "transmittance"].map(|name| row[name]["value"].as_f64().unwrap());
        // the residual of solves
        assert!((r + t - 1.0).abs() < 1e-5, "{k}: {r} + {t}");
        passed.push(t);
    }
    assert!((passed[0] - passed[1]).abs() > 1e-4 && (passed[0] - passed[2]).abs() > 1e-4, "{passed:?}");
    let inside = clear.replace("index = 1.55\n", "index = 1.55\nrelief = { depth_um = 0.1 }\n");
    let varnish = clear.replace("index = 1.5\n", "index = 1.5\nrelief = { depth_um = 0.1 }\n");
    let bare = "[layer]\nthickness_um = 0.3\nbinder.index = 1.5\nrelief = { depth_um = 0.1 }\n\
                [light]\nwavelengths_nm = [550]\n";
    for (text, field, words) in [
        (inside.as_str(), "layer[1].relief", "a relief inside"),
        (varnish.as_str(), "layer[0].relief", "a rough face of a layer without grains"),
        (bare, "layer.relief", "a rough face of a layer without grains"),
    ] {
        let done = run(&study(scratch.path(), text), &scratch.path().join("none"), &[]);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && said.contains(field) && said.contains(words), "{said}");
    }
}

/// One even layer in air is the same from both sides; a stack and a gradient are not, and what the paper sends back into them is
/// solved from behind. *Planted*: either from the front alone.
#[test]
fn what_differs_from_behind_is_solved_from_behind() {
    let scratch = tempfile::tempdir().unwrap();
    let layer = "[layer]\nthickness_um = 1.0\n[[pigment]]\nname = \"a\"\ndiameter_nm = 200\nindex = 1.7\nSHARE\n[light]\nwavelengths_nm = [500]\n";
    let one = layer.replace("SHARE", "volume_fraction = 0.2");
    let gradient = layer.replace("SHARE", "profile = [[0.0, 0.1], [1.0, 0.3]]");
    for (name, text, is_alike) in
        [("one", one.as_str(), true), ("gradient", gradient.as_str(), false), ("stack", STACK, false)]
    {
        let study = inkwave::input::load::load(&study(scratch.path(), text)).expect("sound");
        let expected = if is_alike { 0 } else { study.angles.strata };
        assert!(
            study.angles.strata > 0 && study.angles.exit_strata == expected,
            "{name}: {:?}",
            study.angles
        );
    }
}
