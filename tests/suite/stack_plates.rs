//! Stacks that are lists of plates, as a user runs them.

use super::run_support::{results, results_of, study, succeed, value};
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

/// Two thin inks under a varnish, all of them solved whole or known.
const INKS: &str = r#"
title = "Varnish and two inks"
[stack]
period_um = 0.8
composed = { slab_um = 0.5 }
[[layer]]
name = "varnish"
thickness_um = 3.0
binder.index = 1.5
[[layer]]
name = "top/red"
thickness_um = 0.5
binder.index = 1.5
[[layer.pigment]]
name = "red"
diameter_nm = 180
volume_fraction = 0.2
index = { n = 1.6, k = 0.08 }
[[layer]]
name = "top red"
thickness_um = 0.4
binder.index = 1.5
[[layer.pigment]]
name = "blue"
diameter_nm = 160
volume_fraction = 0.2
index = { n = 1.4, k = 0.03 }
[paper]
albedo = 0.9
[light]
wavelengths_nm = [420, 550, 680]
[run]
realisations = 3
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 24
"#;

/// Rows of a table by the name of the layer.
fn of_layer(folder: &Path, layer: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let rows = csv::Reader::from_path(folder.join("left-out.csv")).expect("a table").into_deserialize();
    let rows = rows.collect::<Result<Vec<std::collections::BTreeMap<String, String>>, _>>().expect("rows");
    rows.into_iter().filter(|row| row["layer"] == layer).collect()
}

/// A stack without a layer is the study without it, whose inks have the same packings; a layer alone is the layer solved by
/// itself in another way. *Planted*: another layer left out.
#[test]
fn a_layer_left_out_is_a_study_without_it() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = |name: &str, text: &str| {
        let folder = scratch.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        let output = folder.join("out");
        succeed(&study(&folder, text), &output, &[]);
        output
    };
    let whole = folder("whole", INKS);
    let varnish = INKS.find("[[layer]]\nname = \"varnish\"").unwrap()
        ..INKS.find("[[layer]]\nname = \"top/red\"").unwrap();
    let without = folder("without", &INKS.replace(&INKS[varnish], ""));
    let rows = results(&without);
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mut apart = 0.0_f64;
    for (left, row) in of_layer(&whole, "varnish").iter().zip(rows["spectra"].as_array().unwrap()) {
        for light in ["lit_at_45", "natural_light"] {
            let bar = row[light]["standard_error"].as_f64().unwrap();
            let bars = bar.hypot(number(&left[&format!("{light}_without_standard_error")]));
            let off = (number(&left[&format!("{light}_without")]) - value(row, light)).abs();
            // the same packings: what differs is the face, solved with the ink or composed with it
            assert!(off < 2.0 * bars + 0.01, "{light}: {off} of bars {bars}");
            apart = apart.max((value(row, light) - number(&left[&format!("{light}_alone")])).abs());
        }
    }
    // without the varnish there is ink, and of it alone there is none
    assert!(apart > 0.1, "{apart}");
    let alone = INKS[INKS.find("[[layer]]\nname = \"top red\"").unwrap()..].replacen(
        "[[layer]]",
        "[layer]\nperiod_um = 0.8",
        1,
    );
    let alone = alone
        .replace("name = \"top red\"\n", "")
        .replace("layer.pigment", "pigment")
        .replace("realisations = 3", "realisations = 12");
    let alone = folder("alone", &alone);
    let direct = results(&alone);
    let direct =
        direct["spectra"].as_array().unwrap().iter().filter(|row| row["lit_at_45"]["value"].is_f64());
    let mut compared = 0;
    for (left, row) in of_layer(&whole, "top red").iter().zip(direct) {
        let bar = row["lit_at_45"]["standard_error"].as_f64().unwrap();
        let bars = bar.hypot(number(&left["lit_at_45_alone_standard_error"]));
        let off = (number(&left["lit_at_45_alone"]) - value(row, "lit_at_45")).abs();
        assert!(off < 3.0 * bars, "{off} of bars {bars}");
        compared += 1;
    }
    assert_eq!(compared, 3);
}

/// The densities are those of the stack and of its layers alone; the page and the files of solves tell layers apart. *Planted*:
/// the paper's factor not divided by; one file for two layers whose names differ by a sign.
#[test]
fn layers_of_a_stack_have_densities_and_files() {
    let scratch = tempfile::tempdir().unwrap();
    let whole = scratch.path().join("out");
    succeed(&study(scratch.path(), INKS), &whole, &[]);
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mut densities = csv::Reader::from_path(whole.join("densities.csv")).unwrap();
    let stack = results(&whole);
    for (w, row) in densities.deserialize::<std::collections::BTreeMap<String, String>>().enumerate() {
        let row = row.unwrap();
        // an air gap passes all that the bare paper sends back
        let density = |factor: f64| -(factor / 0.9).log10();
        let layers = ["varnish", "top/red", "top red"]
            .map(|layer| density(number(&of_layer(&whole, layer)[w]["lit_at_45_alone"])));
        let own = density(value(&stack["spectra"][w], "lit_at_45"));
        let expected = [own, layers.iter().sum::<f64>()];
        for (name, expected) in ["density_of_stack", "density_of_layers"].into_iter().zip(expected) {
            // rounding
            assert!((number(&row[name]) - expected).abs() < 1e-9, "{name}: {} and {expected}", row[name]);
        }
    }
    let colours = stack["left_out_colours"].as_array().expect("colours");
    assert_eq!(colours.len(), 3);
    // a varnish hides nothing, an ink something
    let hides = |k: usize| colours[k]["alone"]["contrast_ratio"]["value"].as_f64().unwrap_or(0.0);
    assert!(hides(0).abs() < 1e-6 && hides(1) > 1e-4, "{} {}", hides(0), hides(1));
    let page = std::fs::read_to_string(whole.join("report.html")).unwrap();
    assert!(page.contains("without varnish") && page.contains("only top red"));
    let to = scratch.path().join("orders");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
    assert!(
        command.arg("export").arg(&whole).args(["--to", "npz", "-o"]).arg(&to).status().unwrap().success()
    );
    // six portions, of layers whose names a file's name does not tell apart
    let files = std::fs::read_dir(&to).unwrap().filter_map(Result::ok).map(|file| file.file_name());
    assert_eq!(files.filter(|name| name.to_string_lossy().ends_with(".npz")).count(), 6);
}

/// What plates cannot hold is refused with its field.
#[test]
fn what_plates_cannot_hold_is_refused() {
    let cases = [
        ("name = \"ink\"\n", "name = \"ink\"\njoint = \"open\"\n", "layer[1].joint"),
        ("thickness_um = 0.5\n", "thickness_um = 0.5\nslab_um = -1\n", "layer[1].slab_um"),
        ("thickness_um = [1, 3]\n", "thickness_um = [1, 3]\nslab_um = 0.8\n", "layer[2].slab_um"),
        // slabs half as thick are solved as well: no room for the grains
        (
            "diameter_nm = 200\nvolume_fraction = 0.15",
            "diameter_nm = 300\nvolume_fraction = 0.15",
            "layer[2].slab_um",
        ),
        ("thickness_um = [1, 3]\n", "thickness_um = [3, 1]\n", "layer[2].thickness_um"),
        // so are halves of a layer that is solved whole
        (
            "diameter_nm = 200\nvolume_fraction = 0.2\n",
            "diameter_nm = 255\nvolume_fraction = 0.2\n",
            "layer[1].thickness_um",
        ),
        ("thickness_um = 3.0\n", "thickness_um = 3.0\nslab_um = 1\n", "layer[0].slab_um"),
        ("thickness_um = [1, 3]\n", "thickness_um = 60\nslab_um = 60\n", "a layer of 60 µm solved whole"),
        ("thickness_um = 3.0\n", "thickness_um = [3, 4]\n", "layer[2].thickness_um"),
        ("volume_fraction = 0.15\n", "profile = [[0.0, 0.1], [1.0, 0.2]]\n", "layer[2].pigment[0].profile"),
        ("index = 2.0\n", "index = { n = 0.1, k = 8 }\n", "layer[2].pigment: found a mixture of index"),
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

/// One complaint of thicknesses of layers or slabs that are none, where they stand.
#[test]
fn a_wrong_thickness_is_refused_once() {
    for (list, said_of_it) in
        [("[-1, 3]", "layer[2].thickness_um[0]: found -1"), ("[]", "found an empty list")]
    {
        let scratch = tempfile::tempdir().unwrap();
        let file = study(scratch.path(), &STACK.replacen("[1, 3]", list, 1));
        let done = super::run_support::run(&file, &scratch.path().join("out"), &[]);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(said.contains(said_of_it) && !said.contains("fields need another value"), "{said}");
    }
}

/// Three layers on paper in contact, the middle one of a low index, and the first one alone.
const OVER_LOW_INDEX: &str = r#"
title = "Over a low index"
[stack]
period_um = 0.8
index_out = 1.5
composed = { slab_um = 0.5 }
[[layer]]
name = "coat"
thickness_um = 0.8
binder.index = { n = 1.5, k = 0.02 }
[[layer]]
name = "low"
thickness_um = 0.6
binder.index = 1.3
[[layer]]
name = "ink"
thickness_um = 0.4
binder.index = 1.5
[[layer.pigment]]
name = "grains"
diameter_nm = 150
volume_fraction = 0.1
index = 1.52
[paper]
coupling = "optical_contact"
albedo = 0.85
[light]
wavelengths_nm = [500, 600]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 24
"#;

/// A layer alone does not know what lay behind it: a coat on paper of its own index is the film on this paper, whatever lay
/// between them. *Planted*: joints of the index behind them, which mirror light from the paper where that is lower.
#[test]
fn a_layer_alone_forgets_its_neighbours() {
    let scratch = tempfile::tempdir().unwrap();
    let stack = results_of(scratch.path(), OVER_LOW_INDEX);
    let film = "[layer]\nthickness_um = 0.8\nbinder.index = { n = 1.5, k = 0.02 }\nindex_out = 1.5\n\
                [paper]\ncoupling = \"optical_contact\"\nalbedo = 0.85\n[light]\nwavelengths_nm = [500, 600]\n";
    let other = scratch.path().join("film");
    std::fs::create_dir(&other).unwrap();
    let film = results_of(&other, film);
    let rows = stack["left_out"].as_array().expect("rows").iter();
    let alone: Vec<_> = rows.filter(|row| row["layer"] == "coat").collect();
    let prints = film["spectra"].as_array().expect("spectra").iter();
    let prints: Vec<_> = prints.filter(|row| row["polar_deg"].as_f64() == Some(0.0)).collect();
    assert_eq!((alone.len(), prints.len()), (2, 2));
    for (row, print) in alone.iter().zip(prints) {
        for light in ["lit_at_45", "natural_light"] {
            let (own, truth) = (value(row, &format!("{light}_alone")), value(print, light));
            // three directions in each zone; a joint of 1.3 leaves a quarter of the light
            assert!((own - truth).abs() < 6e-3, "{light}: {own} and {truth}");
        }
    }
}
