//! Small whole fits: solves, search, descent and errors, on layers whose index is known.
//!
//! The spectra come from closed forms of a film, or from `inkwave run` on the same packings, whose solves the fit does not
//! share: so without noise the fit must find the index itself. The errors have no other source and are pinned.

mod films;
mod solved;

use inkwave::fit::load::{FitTask, load};
use inkwave::fit::response::Origin;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Tiny cells of large grains: ensemble errors are larger than the noise.
const GRAINS: &str = "[layer]\nperiod_um = 0.8\nthickness_um = 0.5\nbinder.index = 1.5\n[[pigment]]\nname = \"a\"\n\
                      diameter_nm = 200\nvolume_fraction = 0.2\nindex = INDEX\n[light]\nwavelengths_nm = WAVES\n\
                      [angles]\ncount = 5\n[run]\nrealisations = 6\nseed = 7\n[resolution]\npoints_per_um = 20\nplanes_per_um = 40\n";
const WHITE: f64 = 0.85;
const BLACK: f64 = 0.04;

fn study(text: &str, index: &str, waves: &str) -> String {
    text.replace("INDEX", index).replace("WAVES", waves)
}

fn inkwave(folder: &Path, words: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    program.current_dir(folder).args(words).output().expect("the program")
}

fn said(done: &Output) -> String {
    String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr)
}

/// Runs a study on a card, and gives one column of its spectra at 0°: wavelength and value.
fn spectrum(folder: &Path, text: &str, albedo: f64, column: &str) -> Vec<[f64; 2]> {
    let text = format!("{text}[paper]\nalbedo = {albedo}\n");
    std::fs::write(folder.join("truth.toml"), text).expect("written");
    let done = inkwave(folder, &["run", "truth.toml", "--output", "truth"]);
    assert!(done.status.success(), "{}", said(&done));
    let mut table = csv::Reader::from_path(folder.join("truth/spectra.csv")).expect("a table");
    let names = table.headers().expect("a header").clone();
    let place = |name: &str| names.iter().position(|own| own == name).expect("a column");
    let places = [place("wavelength_nm"), place(column)];
    let zero = place("polar_deg");
    let rows = table.records().map(|row| row.expect("a row")).filter(|row| &row[zero] == "0");
    rows.map(|row| places.map(|i| row[i].parse().expect("a number"))).collect()
}

/// Writes a measured spectrum; a single wavelength becomes two of equal values about it.
fn write_spectrum(path: &Path, rows: &[[f64; 2]]) {
    write_column(path, "reflectance", rows);
}

fn write_column(path: &Path, column: &str, rows: &[[f64; 2]]) {
    let mut text = format!("wavelength_nm,{column}\n");
    for [nm, value] in rows {
        let around: &[f64] = if rows.len() == 1 { &[-1.0, 1.0] } else { &[0.0] };
        around.iter().for_each(|by| text += &format!("{},{value}\n", nm + by));
    }
    std::fs::write(path, text).expect("written");
}

/// A `[[measured]]` table.
fn measured(file: &str, backing: f64, geometry: &str) -> String {
    let card = if geometry == "transmittance" { String::new() } else { format!("backing = {backing}\n") };
    format!("[[measured]]\nfile = \"{file}\"\n{card}geometry = \"{geometry}\"\n")
}

/// Carries a fit out in a folder; what it said, and `fit.json`.
fn fitted(folder: &Path, base: &str, fit: &str) -> (String, Value) {
    std::fs::write(folder.join("base.toml"), base).expect("written");
    std::fs::write(folder.join("fit.toml"), format!("base = \"base.toml\"\n{fit}")).expect("written");
    let done = inkwave(folder, &["fit", "fit.toml", "--output", "fit"]);
    assert!(done.status.success(), "{}", said(&done));
    let json = std::fs::read(folder.join("fit/fit.json")).expect("a result");
    (said(&done), serde_json::from_slice(&json).expect("JSON"))
}

/// A number of every wavelength of an index.
fn column(index: &Value, name: &str) -> Vec<f64> {
    index.as_array().expect("rows").iter().map(|row| row[name].as_f64().expect("a number")).collect()
}

/// The fitted index is the true one within this share of its standard errors.
fn assert_found(fit: &Value, truth: [f64; 2], share: f64) {
    for (name, truth) in ["n", "kappa"].into_iter().zip(truth) {
        let values = column(&fit["index"], name);
        let errors = column(&fit["index"], &format!("{name}_error"));
        for (value, error) in values.iter().zip(&errors) {
            assert!((value - truth).abs() < share * error, "{name} {value} ± {error} for {truth}: {fit}");
        }
    }
}

/// Regression: numbers of this program, pinned. Other processors round sums otherwise, to a millionth.
fn assert_pinned(fit: &Value, pinned: &[(&str, &[f64])]) {
    for (name, expected) in pinned {
        let found = if fit[name].is_number() {
            vec![fit[name].as_f64().unwrap()]
        } else {
            column(&fit["index"], name)
        };
        let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-3 * b.abs();
        assert!(found.len() == expected.len() && found.iter().zip(*expected).all(close), "{name}: {found:?}");
    }
}

/// Runs a study on cards, and gives the `[[measured]]` tables of its spectra in these geometries.
fn on_cards(folder: &Path, truth: &str, cards: &[(&str, &str)]) -> String {
    let mut tables = String::new();
    for (card, geometry) in cards {
        let backing = if *card == "white" { WHITE } else { BLACK };
        let column = if *geometry == "45:0" { "lit_at_45" } else { "natural_light" };
        let file = format!("{card}-{column}.csv");
        write_spectrum(&folder.join(&file), &spectrum(folder, truth, backing, column));
        tables += &measured(&file, backing, geometry);
    }
    tables
}

/// Both cards in both geometries.
const ALL_CARDS: [(&str, &str); 4] =
    [("white", "45:0"), ("white", "natural"), ("black", "45:0"), ("black", "natural")];
/// The fewest that may tell n from κ.
const TWO_CARDS: [(&str, &str); 2] = [("white", "45:0"), ("black", "natural")];

/// What the film of a task predicts of its first drawdown at two wavelengths of one index, with the logarithm of a factor on
/// all thicknesses.
fn predicted(task: &FitTask, index: [f64; 2], log_thickness: f64) -> Vec<f64> {
    let all = Origin::Film.spectra(task, &task.measured, &[index; 2], ([0.0; 2], log_thickness));
    all.expect("spectra")[0].values.clone()
}

/// The fit of grains whose spectra were run on the same packings.
fn grains(folder: &Path) -> (String, Value) {
    let waves = "[500, 560, 620]";
    let truth = study(GRAINS, "{ n = 1.75, k = 0.05 }", waves);
    let fit = on_cards(folder, &truth, &ALL_CARDS);
    fitted(folder, &study(GRAINS, "1.6", waves), &(fit + "[fit]\nprior = \"smooth\"\nnoise = 0.002\n"))
}

/// Solves of the plan, the fit's own count, and their processor time.
///
/// *Planted*: errors of few cells not widened, the grid's error of T left out (pinned errors), and every cell's solves
/// stored as those of the first (no scatter: the index misses the truth by many errors).
#[test]
fn grains_give_their_index_back_and_the_plan_its_cost() {
    let folder = tempfile::tempdir().expect("a folder");
    let (said, found) = grains(folder.path());
    let fit = &found["fit"];
    // no noise, and the same cells: the prior pulls, and the way that is left where steps end
    assert_found(fit, [1.75, 0.05], 0.5);
    assert_pinned(fit, PINNED_GRAINS);
    let planned = inkwave(folder.path(), &["fit", "fit.toml", "--plan"]);
    let plan = String::from_utf8_lossy(&planned.stdout).into_owned();
    // 5 directions of 3 wavelengths: 12 nodes in 2 cells, and all 6 cells in each linearisation
    let rounds = fit["linearisations"].as_u64().expect("a number");
    assert!(plan.contains("coarse table of n and κ: 360 solves") && plan.contains("90 solves"), "{plan}");
    let seconds = |line: &str| -> f64 {
        let line = plan.lines().find(|own| own.starts_with(line)).expect(&plan);
        let (before, _) = line.split_once(" processor seconds").expect(line);
        before.rsplit(' ').next().expect(line).parse().expect(line)
    };
    let solved = said.split(" solves in").next().and_then(|s| s.rsplit(char::is_whitespace).next());
    let solved: f64 = solved.expect(&said).parse().expect(&said);
    let linearisations = (solved - 360.0) / 90.0;
    assert!(
        linearisations.fract() == 0.0 && linearisations >= rounds as f64,
        "{solved} solves, {rounds} rounds"
    );
    let forecast = seconds("grids") + seconds("coarse table") + linearisations * seconds("each of");
    let used = found["processor_seconds"].as_f64().expect("a number");
    // promised; the trial's few solves differ by a third
    assert!(
        (forecast / used - 1.0).abs() < 0.5 || (used / forecast - 1.0).abs() < 0.5,
        "{forecast} s for {used} s: {plan}"
    );
}

/// Golden numbers of [`grains`]: a regression, not a truth.
const PINNED_GRAINS: &[(&str, &[f64])] = &[
    ("n_error", &[0.0166602, 0.0263544, 0.0329063]),
    ("kappa_error", &[0.00278961, 0.00281489, 0.00666580]),
    ("effective_unknowns", &[5.44551]),
];

/// Two layers, of which the second has the pigment that is not known.
const STACK: &str = "[[layer]]\nname = \"top\"\nthickness_um = 0.3\nbinder.index = 1.45\n[[layer.pigment]]\nname = \"a\"\n\
                     diameter_nm = 150\nvolume_fraction = 0.15\nindex = { n = 1.6, k = 0.02 }\n[[layer]]\nname = \"base\"\n\
                     thickness_um = 0.4\nbinder.index = 1.5\n[[layer.pigment]]\nname = \"a\"\ndiameter_nm = 150\n\
                     volume_fraction = 0.2\nindex = INDEX\n[stack]\nperiod_um = 0.6\n[light]\nwavelengths_nm = WAVES\n\
                     [angles]\ncount = 5\n[run]\nrealisations = 6\nseed = 7\n[resolution]\npoints_per_um = 16\nplanes_per_um = 24\n";

/// The pigment of one layer of a stack is found under the others; its layer's thickness alone is what a factor on the
/// thickness moves, and a share or a thickness of a drawdown is that of its layer. *Planted*: the pigment of the first layer
/// (its index is not the truth), and the whole stack thicker.
#[test]
fn a_layer_of_a_stack_gives_its_pigments_index_back() {
    let scratch = tempfile::tempdir().expect("a folder");
    let folder = scratch.path();
    let truth = study(STACK, "{ n = 1.75, k = 0.05 }", "[500, 600]");
    let fit = on_cards(folder, &truth, &ALL_CARDS);
    let settings = "[fit]\npigment = \"base.a\"\nprior = \"smooth\"\nnoise = 0.002\n";
    let (_, found) = fitted(folder, &study(STACK, "1.6", "[500, 600]"), &(fit + settings));
    // no noise, and the same cells: the prior pulls, and the way that is left where steps end
    assert_found(&found["fit"], [1.75, 0.05], 0.5);
    // a factor on the thickness is one on the pigment's layer, as its thickness in the file is
    let read = |changes: &str| {
        let text = format!(
            "base = \"base.toml\"\n{}{changes}{settings}",
            measured("white-lit_at_45.csv", WHITE, "45:0")
        );
        std::fs::write(folder.join("fit.toml"), text).expect("written");
        load(&folder.join("fit.toml"))
    };
    let index = [1.75, 0.05];
    let whole = read("").expect("sound");
    let thick = read("thickness_um = 0.6\nvolume_fraction = 0.2\n").expect("sound");
    assert!((thick.coats[0].layer.thickness_um - 0.9).abs() < 1e-12);
    let written = predicted(&thick, index, 0.0);
    let factor = predicted(&whole, index, 1.5_f64.ln());
    assert!(written.iter().zip(&factor).all(|(a, b)| (a - b).abs() < 1e-12), "{written:?} {factor:?}");
    // names and keys that a stack has not
    let several = std::fs::read_to_string(folder.join("fit.toml")).expect("a fit").replace("base.a", "a");
    std::fs::write(folder.join("fit.toml"), several).expect("written");
    let refused = load(&folder.join("fit.toml")).map(|_| ()).expect_err("two pigments of one name");
    let refused = format!("{refused:?}");
    assert!(refused.contains("2 pigments") && refused.contains("top.a, base.a"), "{refused}");
    for (changes, field) in
        [("opaque = true\n", "measured[0].opaque"), ("volume_fractions = { a = 0.2 }\n", "base.layer")]
    {
        let done = read(changes).map(|_| ()).expect_err(changes);
        assert!(format!("{done:?}").contains(field), "{done:?}");
    }
}

/// s- and p-polarised solves are different ones, and so are those of two cells that are lit alike: what a fit finds in its
/// store gives the same numbers again. *Planted*: stored without their polarisation, or all as those of the first cell, so
/// that one stands for others.
#[test]
fn unpolarised_light_gives_the_index_back_at_one_wavelength() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let small = GRAINS.replace("period_um = 0.8\nthickness_um = 0.5", "period_um = 0.6\nthickness_um = 0.4");
    let small =
        small.replace("points_per_um = 20\nplanes_per_um = 40", "points_per_um = 16\nplanes_per_um = 24");
    let small = small.replace("diameter_nm = 200", "diameter_nm = 150");
    let small = small.replace("[layer]\n", "[layer]\ncell = \"fixed\"\n");
    let small = small.replace("[light]\n", "[light]\nwave = \"unpolarised\"\n");
    let truth = study(&small, "{ n = 1.75, k = 0.05 }", "[560]");
    let fit = on_cards(folder, &truth, &TWO_CARDS) + "[fit]\nnoise = 0.001\n";
    let (_, found) = fitted(folder, &study(&small, "1.6", "[560]"), &fit);
    // two numbers: a step that scatter stops leaves up to half an error of each unknown, and both add up
    assert_found(&found["fit"], [1.75, 0.05], 1.0);
    let (said, again) = fitted(folder, &study(&small, "1.6", "[560]"), &fit);
    assert!(said.contains("were already stored"), "{said}");
    assert_eq!(found["fit"], again["fit"]);
}

/// Two numbers, two unknowns, and scattering that is alike above and below the binder's index. *Planted*: the second branch
/// not looked at.
#[test]
fn two_solutions_are_found_drawn_and_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let truth = study(GRAINS, "{ n = 1.7, k = 0.01 }", "[560]");
    let fit = on_cards(folder, &truth, &[("white", "45:0"), ("black", "45:0")]);
    let (said, found) =
        fitted(folder, &study(GRAINS, "1.6", "[560]"), &(fit + "[fit]\nnoise = 0.001\nn = [1.4, 1.9]\n"));
    let fit = &found["fit"];
    let both = [&fit["index"], &fit["other_solution"]["index"]].map(|index| column(index, "n")[0]);
    assert!(both.iter().any(|n| (n - 1.7).abs() < 0.02) && both.iter().any(|n| *n < 1.5), "{both:?} {said}");
    assert_eq!(fit["n_is_determined"], false);
    let page = std::fs::read_to_string(folder.join("fit/report.html")).expect("a page");
    let words = said.replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ");
    for text in [words.as_str(), page.as_str(), &fit["remarks"].to_string()] {
        assert!(text.contains("two solutions fit equally well"), "{text}");
        assert!(text.contains("under a uniform sky on a") && !text.contains("a second backing"), "{text}");
    }
    assert!(said.contains("second solution: n") && said.contains("too few for a verdict"), "{said}");
    assert_eq!(fit["trust"], "untested");
    assert!(page.contains("Both are drawn"));
    let second = std::fs::read_to_string(folder.join("fit/pigment-other.csv")).expect("a table");
    assert!(second.contains("wavelength_nm,n,kappa,n_error"), "{second}");
}

/// A search that is kept from the index says that the solution lies outside it.
#[test]
fn an_index_outside_the_searched_range_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let truth = study(GRAINS, "{ n = 1.75, k = 0.05 }", "[560]");
    let fit =
        on_cards(folder, &truth, &TWO_CARDS) + "[fit]\nnoise = 0.001\nn = [1.52, 1.7]\nkappa = [0.0, 0.3]\n";
    let (said, found) = fitted(folder, &study(GRAINS, "1.6", "[560]"), &fit);
    assert_eq!(found["fit"]["index"][0]["outside_search"], true, "{found}");
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("lies outside fit.n = [1.52, 1.7]"), "{said}");
}
