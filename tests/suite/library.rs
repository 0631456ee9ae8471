//! Libraries of plates: a composed stack is what a run of that stack gives, in the program, in the page's engine and in Python;
//! and what does not fit together is refused.

mod angles;
mod left_out;
mod refusals;

use super::run_support::{results, results_of, study, succeed, value};
use inkwave::evaluate::composed::composition::{Composition, compose};
use inkwave::evaluate::composed::library::Library;
use inkwave::wave::Wave;
use num_complex::Complex64;
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

/// Two inks that are solved whole, one of them thinner than its joint, and a white in slabs.
const PLATES: &str = r#"
title = "Plates"
[stack]
period_um = 0.8
composed = { joint_index = 1.5, slab_um = 0.5 }
[[layer]]
name = "red"
thickness_um = 0.5
binder.index = 1.5
[[layer.pigment]]
name = "red"
diameter_nm = 200
volume_fraction = 0.2
index = { n = 1.6, k = 0.05 }
[[layer]]
name = "white"
thickness_um = [1, 2.3]
slab_um = 0.5
binder.index = 1.5
[[layer.pigment]]
name = "white"
diameter_nm = 200
volume_fraction = 0.15
index = 2.0
[paper]
albedo = 0.8
[light]
wavelengths_nm = [420, 500, 580, 660]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 40
"#;

/// A file of `validation/data`, as `scripts/library-golden` writes it.
fn data(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/data").join(name);
    std::fs::read_to_string(path).expect("committed")
}

fn inkwave(words: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inkwave")).args(words).current_dir(folder).output().expect("runs")
}

/// Carries out a command that must succeed.
fn carried_out(words: &[&str], folder: &Path) {
    let done = inkwave(words, folder);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

fn library_of(path: &Path) -> Library {
    Library::read(&std::fs::read_to_string(path).expect("a file")).expect("a library")
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

/// What a library gives for a composition.
fn composed(library: &Library, composition: Value) -> Value {
    let composition: Composition = serde_json::from_value(composition).expect("a composition");
    serde_json::to_value(compose(library, &composition).expect("composed")).expect("JSON")
}

/// The stack of the run itself, composed of its plates, of slabs that are whole and in part: all numbers are the run's. The
/// library keeps every digit of the means, and of what replicates differ by 1/32767. *Planted*: the front face left out.
#[test]
fn a_composition_is_the_run_of_its_stack() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    succeed(&study(folder, PLATES), &folder.join("out"), &[]);
    carried_out(&["library", "out", "--output", "library.json", "--page", "page.html"], folder);
    let library = library_of(&folder.join("library.json"));
    let run = results(&folder.join("out"));
    for (k, um) in [1.0, 2.3].into_iter().enumerate() {
        let layers = json!([{ "plate": "red" }, { "plate": "white", "thickness_um": um }]);
        let found = composed(&library, json!({ "layers": layers, "paper": { "albedo": 0.8 } }));
        let rows = run["spectra"].as_array().expect("rows");
        let rows: Vec<&Value> = rows.iter().filter(|row| row["thickness_um"] == um).collect();
        assert_eq!(rows.len(), 4, "{um}");
        for (own, row) in found["spectra"].as_array().expect("rows").iter().zip(rows) {
            for (name, part) in row.as_object().expect("a row").iter().filter(|(_, part)| part.is_object()) {
                let number = |value: &Value, key: &str| value[key].as_f64().expect("a number");
                let off = (number(&own[name], "value") - number(part, "value")).abs();
                assert!(off < 1e-12, "{um} {name}: {off}");
                let bar = number(&own[name], "standard_error");
                let other = number(part, "standard_error");
                assert!((bar - other).abs() < 1e-3 * other + 1e-7, "{um} {name}: {bar} {other}");
            }
        }
        for name in ["natural_light", "lit_at_45"] {
            for c in 0..3 {
                let off = found["colours"][name][c]["value"].as_f64().unwrap()
                    - run["colours"][k][name][c]["value"].as_f64().unwrap();
                assert!(off.abs() < 1e-9, "{um} {name}: {off}");
            }
        }
    }
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    // of addresses there is the name of the SVG elements alone, which nothing fetches
    let addresses = page.replace("http://www.w3.org/2000/svg", "");
    assert!(
        page.contains("inkwave_library") && !addresses.contains("http://") && !addresses.contains("https://")
    );
}

/// Random stacks of made-up plates, on papers that fluoresce and in dots of every ink too, and their bars, are those that NumPy
/// finds by code of its own. *Planted*: a block of a plate that is transposed.
#[test]
fn stacks_of_made_up_plates_are_those_of_numpy() {
    let library = Library::read(&data("library.json")).expect("a library");
    let golden: Vec<Value> = serde_json::from_str(&data("library-golden.json")).expect("JSON");
    assert_eq!(golden.len(), 48);
    for one in golden {
        let found = composed(&library, one["composition"].clone());
        for (name, numbers) in one["numbers"].as_object().expect("numbers") {
            let own: Vec<&Value> = match name.as_str() {
                "lab_natural_light" => found["colours"]["natural_light"].as_array().unwrap().iter().collect(),
                "lab_lit_at_45" => found["colours"]["lit_at_45"].as_array().unwrap().iter().collect(),
                "contrast_ratio" => vec![&found["colours"]["contrast_ratio"]],
                "lab" | "factors" => found["dots"][name].as_array().unwrap().iter().collect(),
                _ => found["spectra"].as_array().unwrap().iter().map(|row| &row[name]).collect(),
            };
            let bars = numbers["bar"].as_array().unwrap();
            for ((own, value), bar) in own.into_iter().zip(numbers["value"].as_array().unwrap()).zip(bars) {
                let parts = ["chance", "model", "grid", "directions"].map(|part| own[part].as_f64().unwrap());
                let error = parts.into_iter().fold(0.0, f64::hypot);
                let apart = (error - bar.as_f64().unwrap()).abs();
                assert!(apart < 1e-2 * error + 1e-8, "{name} {error} {bar}: {}", one["composition"]);
                let off = own["value"].as_f64().unwrap() - value.as_f64().unwrap();
                // a promise; L*, a* and b* are of the order of 100
                let size = if name.contains("lab") { 100.0 } else { 1.0 };
                assert!(off.abs() < 1e-6 * size, "{name} {off}: {}", one["composition"]);
            }
        }
    }
}

/// A print in dots on a paper that fluoresces, under the lights of instruments and under daylight, is what a run of it gives.
/// *Planted*: the albedo below a brightener taken whole; the condition's light left out; bars without what the wavelengths
/// leave open.
#[test]
fn a_brightened_print_in_dots_is_that_of_the_run() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let brightener = "{ excitation = [[415, 0], [430, 0.5], [480, 0]], emission = [[450, 0], [500, 1], [600, 0]], yield = 0.6 }";
    let paper = format!("[paper]\nalbedo = 0.8\nfluorescence = {brightener}\n");
    let text = PLATES.replace("[paper]\nalbedo = 0.8\n", &paper).replace("[1, 2.3]", "1")
        + "[dots]\nruling_per_cm = 60\nspread_um = 40\n[[area]]\ncoverage = 0.4\n";
    succeed(&study(folder, &text), &folder.join("out"), &[]);
    carried_out(&["library", "out", "--output", "library.json"], folder);
    let library = library_of(&folder.join("library.json"));
    let run = results(&folder.join("out"));
    let fluorescence = json!({
        "excitation": [[415, 0], [430, 0.5], [480, 0]],
        "emission": [[450, 0], [500, 1], [600, 0]],
        "yield": 0.6
    });
    let printed = |illuminant: &str, condition: Option<&str>| {
        let print = json!({
            "layers": [{ "plate": "red" }, { "plate": "white", "thickness_um": 1.0 }],
            "paper": { "albedo": 0.8, "fluorescence": fluorescence },
            "dots": { "coverage": 0.4, "ruling_per_cm": 60, "spread_um": 40 },
            "illuminant": illuminant,
            "condition": condition,
        });
        composed(&library, print)
    };
    let number = |value: &Value| value["value"].as_f64().expect("a number");
    let daylight = printed("D65", None);
    let rows = run["spectra"].as_array().expect("rows");
    for (own, row) in daylight["spectra"].as_array().expect("rows").iter().zip(rows) {
        for name in ["natural_light", "lit_at_45", "over_black"] {
            let off = number(&own[name]) - number(&row[name]);
            assert!(off.abs() < 1e-12, "{name}: {off}");
        }
    }
    let prints = run["prints"]["prints"].as_array().expect("prints");
    let mut emitted = 0.0_f64;
    for condition in ["M0", "M1", "M2"] {
        let is_own = |print: &&Value| print["condition"] == condition && print["nominal"] == 0.4;
        let print = prints.iter().find(is_own).expect("a print");
        let own = &printed("D50", Some(condition))["dots"];
        for (own, factor) in
            own["factors"].as_array().unwrap().iter().zip(print["factors"].as_array().unwrap())
        {
            assert!((number(own) - number(factor)).abs() < 1e-12, "{condition}: {own} {factor}");
        }
        for c in 0..3 {
            let off = number(&own["lab"][c]) - number(&print["lab"][c]);
            assert!(off.abs() < 1e-9, "{condition}: {off}");
            let bar = |value: &Value| value["standard_error"].as_f64().expect("a bar");
            let [own, print] = [&own["lab"][c], &print["lab"][c]].map(bar);
            assert!((own / print - 1.0).abs() < 1e-4, "{condition}: ± {own} for ± {print}");
        }
        emitted = emitted.max((number(&own["factors"][1]) - number(&daylight["dots"]["factors"][1])).abs());
    }
    // the conditions differ, or there were nothing to compare
    assert!(emitted > 1e-4, "{emitted}");
}

/// Layers in dots of their own over a paper that does not spread light are Neugebauer's mean of their overprints, each composed
/// alone; of a layer that covers nothing there is none. *Planted*: Demichel's shares of the inks changed round.
#[test]
fn dots_of_every_ink_are_neugebauers_mean() {
    let library = Library::read(&data("library.json")).expect("a library");
    let factors = |found: &Value| -> Vec<f64> {
        let all = found["dots"]["factors"].as_array().expect("factors");
        all.iter().map(|factor| factor["value"].as_f64().unwrap()).collect()
    };
    let solid = |names: &[&str]| -> Vec<f64> {
        let layers: Vec<Value> = names.iter().map(|name| json!({ "plate": name })).collect();
        let found = composed(&library, json!({ "layers": layers, "paper": { "albedo": 0.7 } }));
        let rows = found["spectra"].as_array().unwrap();
        rows.iter().map(|row| value(row, "lit_at_45")).collect()
    };
    let [a, b] = [0.3, 0.6];
    let layers =
        json!([{ "plate": "light" }, { "plate": "red", "coverage": a }, { "plate": "white", "coverage": b }]);
    let screen = json!({ "ruling_per_cm": 60, "spread_um": 0 });
    let found = composed(&library, json!({ "layers": layers, "paper": { "albedo": 0.7 }, "dots": screen }));
    let parts = [
        ((1.0 - a) * (1.0 - b), solid(&["light"])),
        (a * (1.0 - b), solid(&["light", "red"])),
        ((1.0 - a) * b, solid(&["light", "white"])),
        (a * b, solid(&["light", "red", "white"])),
    ];
    for (w, factor) in factors(&found).into_iter().enumerate() {
        let mean: f64 = parts.iter().map(|(share, spectrum)| share * spectrum[w]).sum();
        // an identity: rounding
        assert!((factor - mean).abs() < 1e-12, "{factor} {mean}");
    }
    let none = json!([{ "plate": "light", "coverage": 0.0 }]);
    let found = composed(&library, json!({ "layers": none, "paper": { "albedo": 0.7 }, "dots": screen }));
    assert!(factors(&found).into_iter().all(|factor| (factor - 0.7).abs() < 1e-15));
}

/// Grains lighter than their binder, mean index 1.47, in slabs between joints of 1.5: without absorption all light of a uniform sky
/// comes back from a perfect white, and compositions of their plates are the runs, of slabs that are whole and in part.
/// *Planted*: slabs between half-spaces of their own index (0.4 of the light came back); the run's film compared with the joint (up
/// to 0.008 at 45:0).
#[test]
fn slabs_less_dense_than_their_joints_keep_all_light() {
    let text = |thickness: &str| {
        format!(
            "title = \"Light grains\"\n[stack]\nperiod_um = 0.6\nindex_out = 1.5\ncomposed = {{ joint_index = 1.5 }}\n[[layer]]\nname = \"film\"\n\
             {thickness}binder.index = 1.5\n[[layer.pigment]]\nname = \"light\"\ndiameter_nm = 150\n\
             volume_fraction = 0.2\nindex = 1.35\n[paper]\nalbedo = 1.0\ncoupling = \"optical_contact\"\n[light]\n\
             wavelengths_nm = [450, 600]\n[run]\nrealisations = 2\nseed = 7\n[resolution]\npoints_per_um = 14\nplanes_per_um = 40\n"
        )
    };
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let paper = json!({ "albedo": 1.0, "contact": true });
    for (name, thickness) in
        [("slabs", "thickness_um = [0.97, 1.2]\nslab_um = 0.3\n"), ("whole", "thickness_um = 1.2\n")]
    {
        let file = folder.join(format!("{name}.toml"));
        std::fs::write(&file, text(thickness)).unwrap();
        succeed(&file, &folder.join(name), &[]);
        let own = format!("{name}.json");
        carried_out(&["library", name, "--output", &own], folder);
        let library = library_of(&folder.join(own));
        let run = results(&folder.join(name));
        for rows in run["spectra"].as_array().unwrap().chunks(2) {
            let layer = json!({ "plate": "film", "thickness_um": rows[0]["thickness_um"] });
            let found = composed(&library, json!({ "layers": [layer], "paper": paper }));
            for (own, row) in found["spectra"].as_array().unwrap().iter().zip(rows) {
                // an identity: the balance of the fluxes
                assert!((value(row, "natural_light") - 1.0).abs() < 1e-6, "{name}: {row}");
                for number in ["lit_at_45", "transmittance_diffuse", "reflectance_45", "natural_light"] {
                    let off = value(own, number) - value(row, number);
                    assert!(off.abs() < 1e-12, "{name} {number}: {own} {row}");
                }
            }
        }
    }
}

/// A film of grains that its binder hides, in six slabs between joints of a denser medium, is the film of Airy's formula: the steps
/// to the joints cancel between neighbours. *Planted*: what inner slabs mirror left out (up to 17 errors off).
#[test]
fn slabs_between_denser_joints_are_their_film() {
    let scratch = tempfile::tempdir().unwrap();
    let text = "title = \"Film\"\n[stack]\nperiod_um = 0.6\ncomposed = { joint_index = 1.558 }\n[[layer]]\nname = \"film\"\n\
        thickness_um = 1.2\nslab_um = 0.2\nbinder.index = 1.5\n[[layer.pigment]]\nname = \"unseen\"\ndiameter_nm = 80\n\
        volume_fraction = 0.1\nindex = 1.5\n[light]\nwavelengths_nm = [420, 500, 600, 700]\n[run]\nrealisations = 2\nseed = 7\n\
        [resolution]\npoints_per_um = 14\nplanes_per_um = 40\n";
    let results = results_of(scratch.path(), text);
    for row in results["spectra"].as_array().unwrap() {
        let phase = 2.0 * std::f64::consts::TAU * 1.5 * 1.2 / (1e-3 * row["wavelength_nm"].as_f64().unwrap());
        let face = ((1.5 - 1.0) / 2.5_f64).powi(2);
        let swing = 2.0 * face * (1.0 - phase.cos());
        let exact = swing / ((1.0 - face).powi(2) + swing);
        // rounding of six products
        assert!((value(row, "reflectance_normal") - exact).abs() < 1e-9, "{exact}: {row}");
    }
}

/// A film that absorbs, denser than its joints, in four slabs and in part of one more: compositions of its plates are the run, and R
/// and T at 0° those of the film's formula. *Planted*: a library whose media absorb nothing (T .541 for .536).
#[test]
fn absorbing_slabs_of_a_library_are_their_film() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let text = "title = \"Film\"\n[stack]\nperiod_um = 0.6\ncomposed = { joint_index = 1.5 }\n[[layer]]\nname = \"film\"\n\
        thickness_um = [1.2, 1.35]\nslab_um = 0.3\nbinder.index = { n = 1.6, k = 0.02 }\n[[layer.pigment]]\nname = \"unseen\"\n\
        diameter_nm = 60\nvolume_fraction = 0.05\nindex = { n = 1.60001, k = 0.02 }\n[paper]\nalbedo = 0.8\n[light]\n\
        wavelengths_nm = [420, 540, 660]\n[run]\nrealisations = 2\nseed = 7\n[resolution]\naccuracy = 3e-2\n";
    std::fs::write(folder.join("film.toml"), text).unwrap();
    succeed(&folder.join("film.toml"), &folder.join("film"), &[]);
    carried_out(&["library", "film", "--output", "film.json"], folder);
    let library = library_of(&folder.join("film.json"));
    let run = results(&folder.join("film"));
    for rows in run["spectra"].as_array().unwrap().chunks(3) {
        let layer = json!({ "plate": "film", "thickness_um": rows[0]["thickness_um"] });
        let found = composed(&library, json!({ "layers": [layer], "paper": { "albedo": 0.8 } }));
        for (own, row) in found["spectra"].as_array().unwrap().iter().zip(rows) {
            for number in ["reflectance_normal", "transmittance_normal", "lit_at_45", "natural_light"] {
                let off = value(own, number) - value(row, number);
                assert!(off.abs() < 1e-12, "{number}: {own} {row}");
            }
            let index = Complex64::new(1.6, 0.02);
            let place = |name: &str| row[name].as_f64().unwrap();
            let wavenumber = std::f64::consts::TAU / (1e-3 * place("wavelength_nm"));
            let once = (Complex64::I * wavenumber * index * place("thickness_um")).exp();
            let face = (1.0 - index) / (1.0 + index);
            let many = 1.0 / (1.0 - face * face * once * once);
            let reflected = (face * (1.0 - once * once) * many).norm_sqr();
            let passed = ((1.0 - face * face) * once * many).norm_sqr();
            // the grid's own estimate of its error is 6e-6
            for (name, wanted) in [("reflectance_normal", reflected), ("transmittance_normal", passed)] {
                assert!((value(row, name) - wanted).abs() < 2e-5, "{name} {wanted}: {row}");
            }
        }
    }
}

/// A library of the scalar wave says what it makes of the paper's surface where bare paper lies between dots: as the run of such a
/// print does, and of no other paper. *Planted*: said of solids too, and of no print.
#[test]
fn a_scalar_library_tells_of_the_surface_between_dots() {
    let mut library = Library::read(&data("library.json")).expect("a library");
    let print = |contact: bool, dots: bool| {
        let screen = dots.then(|| json!({ "coverage": 0.4, "ruling_per_cm": 60, "spread_um": 40 }));
        let paper = json!({ "albedo": 0.9, "contact": contact });
        json!({ "layers": [{ "plate": "red" }], "paper": paper, "dots": screen })
    };
    library.wave = Wave::Scalar;
    let told = &composed(&library, print(true, true))["scalar_surface"];
    let read = |place: &str| told[place]["lit_at_45"].as_f64().expect("a factor");
    assert!(read("below_clear_layer") > read("bare_paper"), "{told}");
    for (contact, dots) in [(true, false), (false, true)] {
        assert_eq!(composed(&library, print(contact, dots))["scalar_surface"], Value::Null);
    }
    library.wave = Wave::Unpolarised;
    assert_eq!(composed(&library, print(true, true))["scalar_surface"], Value::Null);
}

/// The plates of a single layer are asked for alone: no report, and the library that the folder of a stack gives.
#[test]
fn a_run_gives_its_plates_alone() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let one = PLATES
        .replace("[stack]\nperiod_um = 0.8\ncomposed = { joint_index = 1.5, slab_um = 0.5 }\n", "")
        .split("[[layer]]\nname = \"white\"")
        .next()
        .map(|first| {
            first
                .replace("[[layer]]\nname = \"red\"", "[layer]\nperiod_um = 0.8")
                .replace("[[layer.pigment]]", "[[pigment]]")
        })
        .expect("a layer");
    let rest = PLATES.split_once("[paper]").expect("a paper").1;
    std::fs::write(folder.join("study.toml"), format!("{one}[paper]{rest}")).unwrap();
    carried_out(&["run", "study.toml", "--library"], folder);
    let out = folder.join("out/study-plates");
    for name in ["report.html", "results.json", "PARTIAL"] {
        assert!(!out.join(name).exists(), "{name}");
    }
    let library = library_of(&out.join("library.json"));
    assert_eq!(library.joint.index, 1.5);
    assert_eq!(library.plates[0].name, "Plates");
    carried_out(&["library", "out/study-plates", "--output", "all.json"], folder);
    assert_eq!(read(&folder.join("all.json")), read(&out.join("library.json")));
}

/// The page's engine by Node.js, where there is one; Python's by NumPy, where there is one.
#[test]
fn page_and_python_compose_as_the_program() {
    let python = std::env::var("INKWAVE_PYTHON").unwrap_or_else(|_| "python3".into());
    let has_numpy =
        Command::new(&python).args(["-c", "import numpy"]).output().is_ok_and(|done| done.status.success());
    let has_node = Command::new("node").arg("--version").output().is_ok_and(|done| done.status.success());
    let judges = [
        (has_node, "node", "scripts/check_library.mjs"),
        (has_numpy, &*python, "python/tests/test_library.py"),
    ];
    for (is_there, program, script) in judges {
        if !is_there {
            eprintln!("skipped: no {program} for {script}");
            continue;
        }
        let done =
            Command::new(program).arg(script).current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("runs");
        let said =
            [&done.stdout, &done.stderr].map(|text| String::from_utf8_lossy(text).into_owned()).concat();
        assert!(done.status.success(), "{said}");
    }
}
