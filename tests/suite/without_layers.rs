//! Stacks that are solved as a whole, without each of their layers and each of them alone.

use super::run_continue::StopAfter;
use super::run_support::{run, study, succeed};
use inkwave::evaluate::evaluated::FinishedSolves;
use inkwave::input::load::load;
use inkwave::input::study::Study;
use inkwave::report::publish::evaluate_and_publish;
use inkwave::run::{RunError, RunSettings};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::work::alone::run_study;
use inkwave::work::plan::by_size;
use inkwave::work::variant::of_one;
use inkwave_validation::formulas::films::Film;
use inkwave_validation::formulas::stacks::totals;
use num_complex::Complex64;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;

const PAPER: f64 = 0.9;

fn results(output: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(output.join("results.json")).expect("results")).expect("JSON")
}

fn value(row: &Value, name: &str) -> f64 {
    row[name]["value"].as_f64().unwrap_or_else(|| panic!("{name}: {row}"))
}

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

/// Films in unlike, partly absorbing binders, without a grain.
const FILMS: &str = r#"
title = "Films"
[stack]
without_layers = true
[[layer]]
name = "front"
thickness_um = 0.31
binder.index = { n = 1.42, k = 0.03 }
[[layer]]
name = "middle"
thickness_um = 0.52
binder.index = { n = 1.65, k = 0.01 }
[[layer]]
name = "back"
thickness_um = 0.27
binder.index = 1.5
[paper]
albedo = 0.9
[light]
wavelengths_nm = [400, 420, 440, 460, 480, 500, 520, 540, 560, 580, 600, 620, 640, 660, 680, 700]
[output]
picture_pixels = 16
"#;

/// The film of a layer of [`FILMS`].
fn film(layer: &str) -> Film {
    let [n, k, thickness_um] = match layer {
        "front" => [1.42, 0.03, 0.31],
        "middle" => [1.65, 0.01, 0.52],
        _ => [1.5, 0.0, 0.27],
    };
    Film { index: Complex64::new(n, k), thickness_um }
}

/// Radiance factor at 45:0 of films over an air gap, by characteristic matrices: light that enters at 45°, returns from a
/// Lambertian paper many times, and leaves at 0°.
fn lit_at_45(films: &[Film], wavelength_um: f64) -> f64 {
    let at = |films: &[Film], polar_deg: f64| totals([1.0, 1.0], films, wavelength_um, polar_deg, false);
    let behind: Vec<Film> = films.iter().rev().copied().collect();
    // in equal steps of sin², as diffuse light is
    let count = 4000;
    let sine = |i: i32| ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
    let back =
        (0..count).map(|i| at(&behind, sine(i).asin().to_degrees())[0]).sum::<f64>() / f64::from(count);
    at(films, 45.0)[1] * at(films, 0.0)[1] * PAPER / (1.0 - PAPER * back)
}

/// Films without each of them, and each alone, are what characteristic matrices say, with their densities over the bare paper;
/// every number is, to rounding, that of a study without the layer. *Planted*: another layer left out, a layer alone in the
/// place of what is left without it, densities of the wrong sign.
#[test]
fn films_without_a_film_are_other_films() {
    let scratch = tempfile::tempdir().unwrap();
    let whole = results(&ran(scratch.path(), "whole", FILMS));
    let names = ["front", "middle", "back"];
    let nm = |row: &Value| row["wavelength_nm"].as_f64().unwrap();
    // the mean over directions of a film's reflection: the program's nodes, and these steps
    let close = |found: f64, truth: f64| assert!((found - truth).abs() < 2e-5, "{found} and {truth}");
    for layer in names {
        let others: Vec<Film> = names.into_iter().filter(|name| *name != layer).map(film).collect();
        let rows = left_out(&whole, layer);
        assert_eq!(rows.len(), 16);
        for row in rows {
            close(value(&row, "lit_at_45_without"), lit_at_45(&others, 1e-3 * nm(&row)));
            close(value(&row, "lit_at_45_alone"), lit_at_45(&[film(layer)], 1e-3 * nm(&row)));
        }
    }
    let density = |films: &[Film], nm: f64| -(lit_at_45(films, 1e-3 * nm) / PAPER).log10();
    let rows = whole["densities"].as_array().expect("densities");
    assert_eq!(rows.len(), 16);
    for row in rows {
        let own = density(&names.map(film), nm(row));
        let sum: f64 = names.iter().map(|name| density(&[film(name)], nm(row))).sum();
        close(value(row, "density_of_stack"), own);
        close(value(row, "density_of_layers"), sum);
        assert!((value(row, "density_ratio") - own / sum).abs() < 1e-3, "{row} {own} {sum}");
    }
    let block = |name: &str| {
        let from = FILMS.find(&format!("[[layer]]\nname = \"{name}\"")).unwrap();
        let length = FILMS[from + 1..].find("\n[").unwrap() + 2;
        from..from + length
    };
    let plain = FILMS.replace("without_layers = true", "");
    for layer in names {
        let text = plain.replace(&FILMS[block(layer)], "");
        let other = results(&ran(scratch.path(), layer, &text));
        for (row, print) in left_out(&whole, layer).iter().zip(printed(&other)) {
            for light in ["lit_at_45", "natural_light"] {
                let own = value(row, &format!("{light}_without"));
                assert!((own - value(&print, light)).abs() < 1e-12, "{row} {print}");
            }
        }
        assert_same_colours(&whole, layer, "without", &other);
    }
    let alone = plain.replace(&FILMS[block("front")], "").replace(&FILMS[block("back")], "");
    let other = results(&ran(scratch.path(), "alone", &alone));
    for (row, print) in left_out(&whole, "middle").iter().zip(printed(&other)) {
        assert!((value(row, "natural_light_alone") - value(&print, "natural_light")).abs() < 1e-12);
    }
    assert_same_colours(&whole, "middle", "alone", &other);
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

/// Inks without a layer, and a layer alone, are, to rounding, studies without it with the same seed, their bars included; the
/// stack itself is what it is without the key, and the forecast counts what it costs. *Planted*: layers packed by their number
/// in the whole stack.
#[test]
fn inks_without_a_layer_are_studies_without_it() {
    let scratch = tempfile::tempdir().unwrap();
    let output = ran(scratch.path(), "whole", INKS);
    let whole = results(&output);
    for (layer, part, others) in [
        ("varnish", "without", &["varnish"][..]),
        ("red", "without", &["red"]),
        ("blue", "without", &["blue"]),
        ("red", "alone", &["varnish", "blue"]),
        ("blue", "alone", &["varnish", "red"]),
    ] {
        let other = results(&ran(scratch.path(), &format!("{layer} {part}"), &inks_without(others)));
        for (row, print) in left_out(&whole, layer).iter().zip(printed(&other)) {
            for light in ["lit_at_45", "natural_light"] {
                let name = format!("{light}_{part}");
                assert!((value(row, &name) - value(&print, light)).abs() < 1e-12, "{row} {print}");
                assert!((error(row, &name) - error(&print, light)).abs() < 1e-12, "{row} {print}");
            }
        }
        assert_same_colours(&whole, layer, part, &other);
    }
    let plain = results(&ran(scratch.path(), "plain", &inks_without(&[])));
    assert_eq!((&whole["spectra"], &whole["colours"]), (&plain["spectra"], &plain["colours"]));
    assert!(plain["left_out"].is_null() && plain["study_hash"] != whole["study_hash"]);
    let checked = load(&study(scratch.path(), INKS)).unwrap();
    let plan = by_size(&of_one("inks", checked.clone()), RunSettings::default());
    let solves = whole["solves"]["finished"].as_u64().unwrap() as usize;
    assert_eq!((plan.solves, checked.solves()), (solves, solves));
    assert!(solves > 3 * plain["solves"]["finished"].as_u64().unwrap() as usize);
    let page = std::fs::read_to_string(output.join("report.html")).unwrap();
    for words in ["Without each layer", "without varnish", "only blue", "Densities"] {
        assert!(page.contains(words), "{words}");
    }
    // the tables hold what the file does, under the names that composed stacks have
    let table = |name: &str| -> Vec<BTreeMap<String, String>> {
        let rows = csv::Reader::from_path(output.join(name)).expect("a table").into_deserialize();
        rows.collect::<Result<_, _>>().expect("rows")
    };
    let number = |text: &str| text.parse::<f64>().unwrap();
    let rows = whole["left_out"].as_array().unwrap();
    for (line, row) in table("left-out.csv").iter().zip(rows) {
        assert_eq!(number(&line["natural_light_alone"]), value(row, "natural_light_alone"));
        let bar = number(&line["lit_at_45_without_standard_error"]);
        assert_eq!(bar, error(row, "lit_at_45_without"));
    }
    for (line, row) in table("densities.csv").iter().zip(whole["densities"].as_array().unwrap()) {
        let of_layers = ["varnish", "red", "blue"].map(|layer| {
            let own = left_out(&whole, layer);
            let own = own.iter().find(|own| own["wavelength_nm"] == row["wavelength_nm"]).unwrap();
            -(value(own, "lit_at_45_alone") / PAPER).log10()
        });
        assert!((number(&line["density_of_layers"]) - of_layers.iter().sum::<f64>()).abs() < 1e-9);
        let [sum, ratio] = ["density_of_layers", "density_ratio"].map(|name| error(row, name));
        assert!(sum > 0.0 && ratio > 0.0, "{row}");
    }
}

/// The stack of plates of the same layers says the same within bars: another way to the same numbers.
#[test]
fn plates_say_the_same_of_layers_left_out() {
    let scratch = tempfile::tempdir().unwrap();
    let whole = results(&ran(scratch.path(), "whole", &INKS.replace("realisations = 4", "realisations = 8")));
    let plates =
        INKS.replace("without_layers = true", "composed = { slab_um = 0.5 }").replace("count = 3\n", "");
    let plates = results(&ran(scratch.path(), "plates", &plates));
    let mut apart = Vec::new();
    for (one, two) in whole["left_out"].as_array().unwrap().iter().zip(plates["left_out"].as_array().unwrap())
    {
        assert_eq!((&one["layer"], &one["wavelength_nm"]), (&two["layer"], &two["wavelength_nm"]));
        for name in ["lit_at_45_without", "lit_at_45_alone", "natural_light_without", "natural_light_alone"] {
            // films alone are exact in both, but for nodes of directions
            let bars = error(one, name).hypot(error(two, name)).hypot(5e-3);
            apart.push((value(one, name) - value(two, name)) / bars);
        }
    }
    for (one, two) in
        whole["densities"].as_array().unwrap().iter().zip(plates["densities"].as_array().unwrap())
    {
        for name in ["density_of_stack", "density_of_layers"] {
            let bars = error(one, name).hypot(error(two, name)).hypot(5e-3);
            apart.push((value(one, name) - value(two, name)) / bars);
        }
    }
    let mean = (apart.iter().map(|z| z * z).sum::<f64>() / apart.len() as f64).sqrt();
    let largest = apart.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
    // 70 numbers of 5 wavelengths: significance
    assert!(apart.len() == 70 && mean < 1.5 && largest < 4.5, "{mean} {largest}: {apart:?}");
}

/// A run that is stopped keeps the solves of all parts, tells what is there, and goes on to the same numbers. *Planted*: the
/// parts' solves not among those asked for.
#[test]
fn a_stopped_run_keeps_the_parts_of_its_stack() {
    let scratch = tempfile::tempdir().unwrap();
    let text = INKS
        .replace("[420, 480, 550, 610, 680]", "[450, 650]")
        .replace("realisations = 4", "realisations = 2");
    let file = study(scratch.path(), &text);
    let [whole, parts] = ["whole", "parts"].map(|name| scratch.path().join(name));
    succeed(&file, &whole, &[]);
    let checked = load(&file).unwrap();
    let settings = RunSettings { jobs: Some(1), ..RunSettings::default() };
    let mut stored = 0;
    for solves in [20, checked.solves() - 30] {
        let watch = StopAfter { solves, done: AtomicUsize::new(0) };
        let output = OutputFolder::open(&parts, Holds::Study).unwrap();
        stored += solves;
        match run_study(&checked, &output, settings, &watch) {
            Ok(ran) => {
                let solved = FinishedSolves::Whole(Box::new(ran.collected));
                evaluate_and_publish(&checked, &solved, &output).unwrap();
                let found = results(&parts);
                assert_eq!(found["status"], "partial");
                assert_eq!(found["solves"]["finished"].as_u64(), Some(stored as u64));
            }
            // no realisation of the whole stack yet
            Err(stopped) => assert!(matches!(stopped, RunError::Stopped), "{stopped}"),
        }
    }
    let said = succeed(&file, &parts, &[]);
    assert!(said.contains(&format!("{stored} of {} solves were already stored", checked.solves())), "{said}");
    for name in ["left-out.csv", "densities.csv", "spectra.csv"] {
        let [one, two] = [&whole, &parts].map(|folder| std::fs::read(folder.join(name)).expect(name));
        assert!(one == two, "{name}");
    }
    // read back from its folder
    let to = scratch.path().join("crate");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
    let done = command.arg("export").arg(&parts).args(["--to", "crate", "-o"]).arg(&to).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(
        std::fs::read(to.join("left-out.csv")).unwrap(),
        std::fs::read(whole.join("left-out.csv")).unwrap()
    );
}

fn loaded(folder: &Path, text: &str) -> Study {
    load(&study(folder, text)).expect("sound")
}

/// Of two layers each is what is left without the other, and solved once; joints stay open only where grains reached across all
/// that is left out; a rough face leaves with its layer. *Planted*: both layers twice; every joint kept.
#[test]
fn parts_of_stacks_are_stacks() {
    let scratch = tempfile::tempdir().unwrap();
    let open = INKS
        .replace("n = 1.45", "n = 1.5")
        .replace("binder.index = 1.45", "binder.index = 1.5")
        .replace("binder.index = 1.55", "binder.index = 1.5");
    let joints = open.replace("thickness_um = 0.3\n", "thickness_um = 0.3\njoint = \"open\"\n");
    let one_open = loaded(scratch.path(), &joints);
    let both_open = loaded(
        scratch.path(),
        &joints.replace("thickness_um = 0.5\n", "thickness_um = 0.5\njoint = \"open\"\n"),
    );
    let names = |study: &Study| study.substacks().into_iter().map(|part| part.name).collect::<Vec<_>>();
    assert_eq!(
        names(&one_open),
        ["without varnish", "without red", "without blue", "varnish alone", "red alone", "blue alone"]
    );
    let without_red = |study: &Study| study.substacks().swap_remove(study.place_without(1)).study;
    assert_eq!(without_red(&one_open).stack[0].joint, inkwave::ink::Joint::Wall);
    assert_eq!(without_red(&both_open).stack[0].joint, inkwave::ink::Joint::Open);
    for part in both_open.substacks() {
        let Study { stack, packing, pigments, layer, angles, .. } = &part.study;
        assert!(stack.last().is_none_or(|last| last.joint == inkwave::ink::Joint::Wall), "{}", part.name);
        assert_eq!((packing.layers.len(), packing.pigments.len()), (stack.len(), pigments.len()));
        assert_eq!(packing.thickness_um, layer.thickness_um);
        // one even layer is the same from both sides
        assert_eq!(angles.exit_strata == 0, stack.is_empty(), "{}", part.name);
    }
    let two = loaded(
        scratch.path(),
        &inks_without(&["varnish"]).replace("period_um = 0.8\n", "period_um = 0.8\nwithout_layers = true\n"),
    );
    assert_eq!(names(&two), ["without red", "without blue"]);
    assert_eq!((two.place_without(0), two.place_alone(0), two.place_alone(1)), (0, 1, 0));
    assert_eq!(two.substacks()[0].study.pigments[0].name, "blue grains");
    let rough = INKS.replace(
        "thickness_um = 0.4\n",
        "thickness_um = 0.4\nrelief = { depth_um = 0.1, face = \"exit\" }\n",
    );
    for part in loaded(scratch.path(), &rough).substacks() {
        let is_rough = part.study.packing.relief.is_some();
        let has_blue = part.study.pigments.iter().any(|pigment| pigment.name == "blue grains");
        assert_eq!(is_rough, has_blue, "{}", part.name);
        // a rough layer is another one from behind
        assert!(!is_rough || part.study.angles.exit_strata > 0, "{}", part.name);
    }
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
