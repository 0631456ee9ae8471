//! Designs of layers composed of slabs, of which a thickness and a paper need no further solves.

use super::{DYE, SHARE, Varied, design, designed, inkwave, results, run, write};
use crate::run_support::{plain, with};
use inkwave::design::recipe::load;
use inkwave::design::run::Interpolated;
use serde_json::Value;

/// A layer composed of slabs that are solved in milliseconds.
const SLABS: &str = r#"
[layer]
thickness_um = 1.0
period_um = 0.8
binder.index = 1.5
composed = { slab_um = 0.5, directions = [2, 2] }
[[pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.15
share = "scale_sizes"
index = 2.0
[paper]
albedo = 0.5
[light]
wavelengths_nm = [430, 540, 660]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 10
planes_per_um = 32
"#;
const TARGET: &str = "lab = [72, 1, 8]\ncontrast_ratio = 0.1";

fn of_slabs(varied: &[Varied], settings: &str) -> String {
    design(TARGET, varied, settings, SLABS)
}

/// Thickness and paper alone: one run answers for all of them, and its answer is that of `inkwave run` with the same
/// packings. *Planted*: thickness or paper interpolated between variants; the thickness of a whole number of slabs.
#[test]
fn what_enters_after_the_solves_is_answered_as_by_a_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = of_slabs(&[("layer.thickness_um", 1.0, 3.0), ("paper.albedo", 0.3, 0.9)], "verifications = 1");
    let told = plain(&run(folder.path(), &text));
    let file = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect(name);
    let design = &results(folder.path())["design"];
    assert_eq!(design["variants"], 1, "{told}");
    assert_eq!(design["composed"], serde_json::json!(["layer.thickness_um", "paper.albedo"]));
    assert_eq!((&design["interpolated"], &design["interpolated_as"]), (&serde_json::json!([]), &Value::Null));
    assert!(
        told.contains("composed exactly") && file("out/report.html").contains("composed exactly"),
        "{told}"
    );
    let verified = &design["verified"][0];
    let [thickness, albedo] = [0, 1].map(|i| verified["values"][i].as_f64().expect("a value"));
    let recipe = with(SLABS, "thickness_um = 1.0", &format!("thickness_um = [1.0, {thickness}]"));
    let recipe = with(&recipe, "albedo = 0.5", &format!("albedo = {albedo}"));
    write(folder.path(), "recipe.toml", &recipe);
    let done = inkwave(&["run", "recipe.toml", "-o", "run"], folder.path());
    assert!(done.status.success(), "{}", plain(&done));
    let results: Value = serde_json::from_str(&file("run/results.json")).expect("JSON");
    let lab = &results["colours"][1]["lit_at_45"];
    let lab: [f64; 3] = std::array::from_fn(|i| lab[i]["value"].as_f64().expect("a number"));
    let distance = inkwave::appearance::colour::ciede2000(lab, [72.0, 1.0, 8.0]);
    let predicted = verified["predicted"].as_f64().expect("a prediction");
    assert!((distance - predicted).abs() < 1e-9, "{distance} {predicted} {lab:?}");
    // the verifying run has other packings
    let run = verified["delta_e_2000"]["value"].as_f64().expect("a distance");
    assert!((run - predicted).abs() > 1e-6, "{verified}");
}

/// A whole design of a composed layer: the share is interpolated between variants, the thickness is not.
#[test]
fn a_share_is_interpolated_between_slabs_of_every_thickness() {
    let varied = [("layer.thickness_um", 1.0, 3.0), (SHARE, 0.05, 0.2)];
    let outcome = designed(&of_slabs(&varied, "variants = 6\nverifications = 2\ndelta_e = 1.0"));
    assert_eq!((outcome.variants, outcome.left_out.len()), (6, 0), "{outcome:?}");
    assert_eq!(outcome.composed, ["layer.thickness_um"]);
    assert_eq!(outcome.interpolated, ["pigment[0].volume_fraction"]);
    assert!(outcome.interpolated_as.is_some_and(|what| what != Interpolated::BeyondFilm), "{outcome:?}");
    let best = &outcome.verified[0];
    assert!((1.0..=3.0).contains(&best.values[0]) && best.realisations == 2, "{best:?}");
    assert!(best.delta_e_2000.is_some_and(|distance| distance.standard_error.is_some()), "{best:?}");
    assert!(outcome.surface_error > 0.0 && outcome.surface_error < 10.0, "{outcome:?}");
}

/// A paper among the variables takes no variants of its own: 9 for a share, as without it. Films are exact.
#[test]
fn a_paper_among_the_variables_takes_no_further_variants() {
    let varied = [(SHARE, 0.05, 0.4), ("paper.albedo", 0.7, 0.95)];
    let study = with(DYE, "step_nm = 20", "step_nm = 60");
    let outcome = designed(&design("lab = [91.4, -21.1, 79.8]", &varied, "delta_e = 0.5", &study));
    assert_eq!(
        (outcome.variants, &outcome.composed[..]),
        (9, &["paper.albedo".to_owned()][..]),
        "{outcome:?}"
    );
    let verified = &outcome.verified[0];
    let [predicted, distance] = [verified.predicted, verified.delta_e_2000.map(|found| found.value)];
    assert!(predicted.zip(distance).is_some_and(|(a, b)| (a - b).abs() < 1e-9), "{verified:?}");
    assert!(outcome.surface_error < 1e-9, "{outcome:?}");
}

/// *Planted*: each refusal left out.
#[test]
fn composed_bases_without_one_thickness_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |text: &str| plain(&run(folder.path(), text));
    let text = of_slabs(&[("paper.albedo", 0.3, 0.9)], "");
    let told = refused(&with(&text, "thickness_um = 1.0", "thickness_um = [1.0, 2.0]"));
    assert!(told.contains("base.layer.thickness_um") && told.contains("as a [[vary]]"), "{told}");
    let told = refused(&of_slabs(&[("layer.thickness_um", 0.6, 3.0)], ""));
    assert!(told.contains("slab_um") && told.contains("half of the thinnest"), "{told}");
    let told = refused(&of_slabs(&[(SHARE, 0.1, 0.2)], "variants = 3"));
    assert!(told.contains("design.variants"), "{told}");
}

/// The colour of a composed recipe may be that of a file. *Planted*: its spectrum refused with the slabs.
#[test]
fn the_target_of_a_composed_design_may_be_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = (0..16).map(|i| format!("{},{}\n", 400 + 20 * i, 0.4));
    write(folder.path(), "grey.csv", &format!("wavelength_nm,factor\n{}", rows.collect::<String>()));
    let text = with(&of_slabs(&[("paper.albedo", 0.3, 0.9)], ""), "lab = [72, 1, 8]", "file = \"grey.csv\"");
    let task = load(&write(folder.path(), "design.toml", &text)).unwrap_or_else(|error| panic!("{error}"));
    // Y of 0.4: L* = 116 ∛0.4 − 16
    let [l, a, b] = task.lab.expect("a colour");
    assert!((l - 69.47).abs() < 0.01 && a.abs() < 0.05 && b.abs() < 0.05, "{l} {a} {b}");
}

/// A target that lacks so much of the visible light that its end values would be a guess is refused with the range that it
/// has and the one that it needs; a file that lacks little is taken, with what that is worth. *Planted*: end values taken
/// however far they are continued; one end alone looked at.
#[test]
fn a_target_that_lacks_much_of_the_visible_light_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = super::dye("file = \"target.csv\"");
    let of_range = |from: u32, to: u32| {
        let rows = (from..=to).step_by(10).map(|nm| format!("{nm},0.4\n")).collect::<String>();
        write(folder.path(), "target.csv", &format!("wavelength_nm,factor\n{rows}"));
        load(&write(folder.path(), "design.toml", &text))
    };
    for (from, to) in [(430, 700), (400, 670), (500, 600)] {
        let told = match of_range(from, to) {
            Ok(task) => panic!("{from} to {to} nm: {:?}", task.lab),
            Err(_) => plain(&run(folder.path(), &text)),
        };
        for words in ["target.file", &format!("[{from}.0, {to}.0] nm"), "covers 420 to 680 nm", "give lab"] {
            assert!(told.contains(words), "{words:?} is missing: {told}");
        }
    }
    for (from, to, lacks) in [(400, 700, false), (420, 700, true), (400, 680, true), (420, 680, true)] {
        let task = of_range(from, to).unwrap_or_else(|error| panic!("{from} to {to} nm: {error}"));
        let has_remark = task.remarks.iter().any(|remark| remark.contains("its end values are taken beyond"));
        assert_eq!(has_remark, lacks, "{from} to {to} nm: {:?}", task.remarks);
        // a grey stays a grey
        let [l, a, b] = task.lab.expect("a colour");
        assert!((l - 69.47).abs() < 0.05 && a.abs() < 0.1 && b.abs() < 0.1, "{l} {a} {b}");
    }
}
