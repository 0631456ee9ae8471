//! Whole designs: a dye in a film, and grains in small cells, from the file to the verdict.

mod composed;
mod numbers;

use super::run_support::{plain, with};
use inkwave::design::recipe::load;
use inkwave::design::run::{DesignOutcome, DesignRun};
use inkwave::run::RunSettings;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// A dye in a film of 1 µm.
const DYE: &str = r#"
[layer]
thickness_um = 1.0
binder.index = 1.5
[[pigment]]
name = "dye"
diameter_nm = "molecular"
volume_fraction = 0.1
index = { built_in = "yellow" }
[paper]
albedo = 0.9
[light]
from_nm = 400
to_nm = 700
step_nm = 20
sampling = "listed"
[angles]
count = 5
[run]
realisations = 2
[resolution]
points_per_um = 4
planes_per_um = 8
"#;
/// The colour of that film with 15 % of the dye, as `inkwave run` prints it.
const OF_15_PERCENT: &str = "lab = [91.4267, -21.0611, 79.8461]";

/// Grains in small cells, few of them: seconds.
const GRAINS: &str = r#"
[layer]
thickness_um = 0.5
period_um = 0.7
binder.index = 1.5
[[pigment]]
name = "yellow"
diameter_nm = 200
volume_fraction = 0.1
share = "scale_sizes"
index = { built_in = "yellow" }
[paper]
albedo = 0.9
[light]
from_nm = 400
to_nm = 700
step_nm = 50
[angles]
count = 4
[run]
realisations = 4
seed = 1
[resolution]
points_per_um = 12
planes_per_um = 26
"#;

/// A variable: its field, and from where to where it varies.
type Varied<'a> = (&'a str, f64, f64);
const SHARE: &str = "pigment[0].volume_fraction";

/// The design of a study: what it is to reach, what varies, its settings, and the study as its base.
fn design(target: &str, varied: &[Varied], settings: &str, study: &str) -> String {
    let mut text = format!("[target]\n{target}\n");
    for (field, from, to) in varied {
        text += &format!("[[vary]]\nfield = \"{field}\"\nfrom = {from}\nto = {to}\n");
    }
    text += &format!("[design]\n{settings}\n");
    for line in study.lines() {
        let in_base = match line.strip_prefix("[[") {
            Some(table) => format!("[[base.{table}"),
            None => line.strip_prefix('[').map_or(line.to_owned(), |table| format!("[base.{table}")),
        };
        text += &(in_base + "\n");
    }
    text
}

/// The share of a dye in a film, for a target.
fn dye(target: &str) -> String {
    design(target, &[(SHARE, 0.05, 0.4)], "delta_e = 0.5", DYE)
}

fn write(folder: &Path, name: &str, text: &str) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("written");
    path
}

fn inkwave(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.args(arguments).current_dir(folder).output().expect("the program")
}

/// Runs `design.toml` of this text in a folder, with results in `out`.
fn run(folder: &Path, text: &str) -> Output {
    write(folder, "design.toml", text);
    inkwave(&["design", "design.toml", "-o", "out"], folder)
}

/// The results that `run` wrote.
fn results(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("out/design.json")).expect("results")).expect("JSON")
}

fn designed(text: &str) -> DesignOutcome {
    let folder = tempfile::tempdir().expect("a folder");
    let task = load(&write(folder.path(), "design.toml", text)).expect("a design");
    let folder = OutputFolder::open(&folder.path().join("out"), Holds::Design).expect("a folder");
    let run = DesignRun { task: &task, folder: &folder, settings: RunSettings::default(), watch: &() };
    run.design().expect("designed")
}

/// What `inkwave run` prints of this layer with 15 % of the dye is found again. Films have no differences from themselves:
/// surfaces are exact. *Planted*: surfaces of spectra with the film, or a search that ends early.
#[test]
fn the_share_of_a_dye_is_found_again() {
    let outcome = designed(&dye(OF_15_PERCENT));
    let [verified] = &outcome.verified[..] else { panic!("one run is sure: {outcome:?}") };
    assert!(outcome.met && outcome.left_out.is_empty(), "{outcome:?}");
    // The search ends with steps of 0.1/2⁶ of the range of 0.35, and a digit of L*, a* and b* is 1e-4.
    assert!((verified.values[0] - 0.15).abs() < 6e-4, "{verified:?}");
    let distance = verified.delta_e_2000.expect("of a colour").value;
    assert!(distance < 0.02, "{verified:?}");
    let predicted = verified.predicted.expect("the surfaces' answer");
    assert!((predicted - distance).abs() < 1e-9, "{verified:?}");
    assert!(outcome.surface_error < 1e-9 && verified.surface_error.is_some_and(|e| e < 1e-9), "{outcome:?}");
}

/// A quick design of grains, whose variable has a cost; `settings` beside the usual ones.
fn quick(target: &str, varied: Varied, settings: &str, study: &str) -> String {
    let settings = format!("delta_e = 0.55\nverifications = 2\n{settings}");
    with(&design(target, &[varied], &settings, study), "[design]", "cost = 1\n[design]")
}

/// The share of the grains.
fn grains(study: &str) -> String {
    quick("lab = [88, -10, 54]", (SHARE, 0.05, 0.3), "variants = 6\nrealisations = 8", study)
}

/// A whole design against golden numbers. *Planted*: `design.realisations` unheard, verifying runs on the packings of the
/// surfaces, a run taken as sure at the near end of its bar, and what a run has shown taken off
/// the surfaces.
#[test]
fn a_design_of_grains_goes_as_before() {
    let outcome = designed(&grains(GRAINS));
    let found: Vec<f64> = outcome.verified.iter().map(|run| run.values[0]).collect();
    // The first run, 0.31 ± 0.14, meets the wish and is not sure; the second has other packings, and does not meet it.
    let golden =
        [[0.2536, 88.124, -9.887, 54.913, 0.315, 1.533], [0.2488, 87.583, -8.714, 55.272, 1.012, 0.125]];
    assert_eq!(outcome.verified.len(), golden.len(), "{found:?}");
    for (run, [share, l, a, b, delta_e, predicted]) in outcome.verified.iter().zip(golden) {
        assert_eq!(run.realisations, 8);
        assert!((run.values[0] - share).abs() < 1e-4, "{run:?}");
        // Digits of the golden numbers; solves agree to their residual of 1e-5.
        let lab = run.lab.iter().zip([l, a, b]).map(|(found, golden)| (found - golden).abs());
        assert!(lab.fold(0.0, f64::max) < 2e-3, "{run:?}");
        assert!(run.delta_e_2000.is_some_and(|found| (found.value - delta_e).abs() < 2e-3), "{run:?}");
        assert!(run.predicted.is_some_and(|found| (found - predicted).abs() < 2e-3), "{run:?}");
        assert_eq!(run.cost, run.values[0]);
    }
    assert!(outcome.met && outcome.verdict.starts_with(&outcome.verified[0].recipe), "{}", outcome.verdict);
    assert_eq!(outcome.variants, 6, "{outcome:?}");
    assert!((outcome.surface_error - 0.885).abs() < 2e-3, "{outcome:?}");
}

/// Clear grains whose index varies: two cells give some of them an impossible colour, which is withheld.
fn withheld(to: f64, variants: usize) -> String {
    let mut study = GRAINS.to_owned();
    for (part, instead) in [
        ("{ built_in = \"yellow\" }", "{ n = 1.6, k = 0.0 }"),
        ("realisations = 4\nseed = 1", "realisations = 2\nseed = 2"),
        ("volume_fraction = 0.1", "volume_fraction = 0.3"),
        ("step_nm = 50", "step_nm = 100"),
        ("points_per_um = 12", "points_per_um = 14"),
        ("planes_per_um = 26", "planes_per_um = 32"),
    ] {
        study = with(&study, part, instead);
    }
    let varied = ("pigment[0].index.n", 1.5, to);
    quick("lab = [99, 0, 0]", varied, &format!("variants = {variants}"), &study)
}

/// *Planted*: the first recipe without a colour ends the design.
#[test]
fn recipes_without_a_colour_are_left_out_with_the_reason() {
    let outcome = designed(&withheld(1.75, 12));
    let reasons: Vec<String> = outcome.left_out.iter().map(ToString::to_string).collect();
    let variants_left_out = outcome.left_out.iter().filter(|left| !left.verifying).count();
    assert!(variants_left_out > 0 && outcome.variants + variants_left_out == 12, "{reasons:?}");
    // Both gates: a total that no layer has, and a colour that none has.
    assert!(reasons[0].contains("pigment[0].index.n 1.750 (reflectance is -0.1"), "{reasons:?}");
    assert!(reasons.iter().any(|reason| reason.contains("(colour over black: Lab")), "{reasons:?}");
    assert!(!outcome.verified.is_empty(), "the design goes on: {reasons:?}");
}

#[test]
fn too_few_recipes_with_a_colour_end_a_design_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let done = run(folder.path(), &withheld(2.2, 7));
    let told = plain(&done);
    assert!(!done.status.success(), "{told}");
    for words in [
        "2 of 7 variants gave no colour",
        "pigment[0].index.n 2.200 (colour",
        "Narrow the ranges in [[vary]]",
    ] {
        assert!(told.contains(words), "{words:?} is missing: {told}");
    }
}

/// *Planted*: results of another design stay where its successor is stopped.
#[test]
fn results_of_another_design_do_not_outlive_its_successor() {
    let place = tempfile::tempdir().expect("a folder");
    let text = dye(OF_15_PERCENT);
    let design = |text: &str| run(place.path(), text);
    let there = |name: &str| place.path().join("out").join(name).exists();
    let done = design(&text);
    assert!(
        done.status.success() && there("design.json") && there("report.html") && !there("PARTIAL"),
        "{}",
        plain(&done)
    );
    assert_eq!(results(place.path())["design"]["left_out"], serde_json::json!([]));
    // Cells of the next one are too high for its waves: it ends before it has results.
    let done = design(&grains(&with(GRAINS, "planes_per_um = 26", "planes_per_um = 20")));
    assert!(!done.status.success() && plain(&done).contains("gave no colour"), "{}", plain(&done));
    assert!(there("PARTIAL") && !there("design.json") && !there("report.html"), "{}", plain(&done));
    // The first one again finds its solves.
    let done = design(&text);
    assert!(done.status.success() && there("design.json") && !there("PARTIAL"), "{}", plain(&done));
}

/// *Planted*: a link in place of `runs` or of one of them is followed.
#[cfg(unix)]
#[test]
fn a_design_writes_through_no_link() {
    let place = tempfile::tempdir().expect("a folder");
    let run = || run(place.path(), &dye(OF_15_PERCENT));
    assert!(run().status.success());
    let runs = place.path().join("out/runs");
    let one = std::fs::read_dir(&runs).expect("runs").next().expect("a run").expect("an entry").path();
    let elsewhere = place.path().join("elsewhere");
    for link in [one, runs] {
        std::fs::create_dir(&elsewhere).expect("a folder");
        std::fs::remove_dir_all(&link).expect("removed");
        std::os::unix::fs::symlink(&elsewhere, &link).expect("a link");
        let done = run();
        let told = plain(&done);
        assert!(!done.status.success() && told.contains("is a link") && told.contains("--output"), "{told}");
        assert_eq!(std::fs::read_dir(&elsewhere).expect("a folder").count(), 0, "{}", link.display());
        std::fs::remove_file(&link).expect("removed");
        std::fs::remove_dir(&elsewhere).expect("removed");
    }
}
