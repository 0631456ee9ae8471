//! The comparison from its file to its folder.

use inkwave::solve::{Registry, Silent, Step, Watch};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::wave::Scheme;
use inkwave_bench::experiment::ComparisonFile;
use inkwave_bench::page::Comparison;
use inkwave_bench::row::Row;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::Path;

const TINY: &str = r#"
title = "tiny"
strategies = ["krylov", "born", "relaxation", "direct"]
schemes = ["cubic", "second_difference"]
resolutions = [{ points = 5, cells = 6 }]
repeats = 1

[study.layer]
cell = "fixed"
period_um = 0.5
thickness_um = 0.5
binder.index = 1.558
[[study.pigment]]
diameter_nm = 250
volume_fraction = 0.12
index = 2.5
[study.light]
wavelengths_nm = [600]
"#;

fn tiny(folder: &Path) -> ComparisonFile {
    written(folder, "tiny.toml", TINY)
}

fn written(folder: &Path, name: &str, text: &str) -> ComparisonFile {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("written");
    ComparisonFile::read(&path).expect("parsed")
}

/// Writes a comparison into the folder `out`.
fn write(comparison: &Comparison, folder: &Path) {
    let output = OutputFolder::open(&folder.join("out"), Holds::Comparison).expect("a folder");
    comparison.write(&output).expect("written");
}

#[test]
fn every_strategy_is_a_row_and_every_file_is_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = tiny(folder.path());
    let comparison = file.run(&Registry::default(), &mut Silent, |_| ()).expect("compared");
    assert_eq!(comparison.rows.len(), 8);
    let find = |name: &str| comparison.rows.iter().find(|r| r.strategy == name).expect("a row");
    // One discrete system: krylov and the dense solve have the same error, to the residual asked for (1e-6, amplified).
    let krylov = find("krylov").result.clone().expect("converged");
    let direct = find("direct").result.clone().expect("converged");
    assert!((krylov - direct).abs() < 1e-4, "{krylov:.3e} and {direct:.3e}");
    // Index 2.5 is beyond the Born series: a row that says why, not a crash.
    assert!(find("born").outcome().contains("diverges"), "{}", find("born").outcome());
    write(&comparison, folder.path());
    for name in
        ["comparison.csv", "residuals.csv", "residuals.svg", "error_against_work.svg", "comparison.html"]
    {
        let size = std::fs::metadata(folder.path().join("out").join(name)).map_or(0, |m| m.len());
        assert!(size > 100, "{name}: {size} bytes");
    }
}

/// A film without grains is solved in no step, whose residual of 0 no logarithmic axis shows: the chart is left out, with a word.
#[test]
fn a_film_alone_is_compared_without_the_chart_of_its_residuals() {
    let folder = tempfile::tempdir().expect("a folder");
    let film = r#"{ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.3, "eta": [1.5, 0] }] }"#;
    std::fs::write(folder.path().join("film.json"), film).expect("written");
    let file =
        written(folder.path(), "film.toml", "case = \"film.json\"\nstrategies = [\"krylov\", \"direct\"]\n");
    let comparison = file.run(&Registry::default(), &mut Silent, |_| ()).expect("compared");
    write(&comparison, folder.path());
    let out = folder.path().join("out");
    for name in ["README.md", "comparison.html"] {
        let page = std::fs::read_to_string(out.join(name)).expect("a page");
        assert!(
            page.contains("Left out, as there is nothing to show: Residual on the finest grid"),
            "{name}: {page}"
        );
    }
    assert!(!out.join("residuals.svg").exists() && out.join("comparison.csv").exists());
    assert!(!out.join("PARTIAL").exists());
}

/// One comparison as two machines would have made it, the second of them twice as fast. *Planted*: seconds instead of transforms.
#[test]
fn folders_of_several_machines_are_merged() {
    let folder = tempfile::tempdir().expect("a folder");
    let machine = |name: &str, rate: f64, seconds: f64| {
        let place = folder.path().join(name);
        std::fs::create_dir(&place).expect("a folder");
        let json = serde_json::json!({ "processor": name, "threads": 2,
            "transforms_per_second": { "value": rate, "standard_error": 0.02 * rate } });
        std::fs::write(place.join("machine.json"), json.to_string()).expect("written");
        let table = format!(
            "case,strategy,error,processor_seconds\na,x,0.005,{seconds}\na,x,0.0005,{}\n",
            8.0 * seconds
        );
        std::fs::write(place.join("comparison.csv"), table).expect("written");
        place
    };
    let folders = [machine("slow", 1000.0, 2.0), machine("fast", 2000.0, 1.0)];
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/merge-comparisons");
    let merge = |folders: &[std::path::PathBuf]| {
        let mut command = std::process::Command::new("python3");
        command
            .arg(&script)
            .args(folders)
            .arg("-o")
            .arg(folder.path().join("merged"))
            .output()
            .expect("python3")
    };
    assert!(merge(&folders).status.success());
    let page = std::fs::read_to_string(folder.path().join("merged/README.md")).expect("a page");
    for name in ["fast", "slow"] {
        assert!(page.contains(&format!("| a | x | {name} | 2e+03 | 1.6e+04 | – | 2.0 % |")), "{page}");
    }
    // What the program writes is what the script reads.
    let comparison = tiny(folder.path()).run(&Registry::default(), &mut Silent, |_| ()).expect("compared");
    write(&comparison, folder.path());
    assert!(merge(&[folder.path().join("out")]).status.success());
    std::fs::remove_file(folder.path().join("out/machine.json")).expect("removed");
    let refused = merge(&[folder.path().join("out")]);
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("machine.json"));
}

/// Stops the step after the first row.
struct StopAfterOne<'a>(&'a Cell<usize>);

impl Watch for StopAfterOne<'_> {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        if self.0.get() > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn what_was_solved_before_a_stop_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = tiny(folder.path());
    let rows = Cell::new(0);
    let told = |_: &_| rows.set(rows.get() + 1);
    let comparison = file.run(&Registry::default(), &mut StopAfterOne(&rows), told).expect("one row");
    assert_eq!((comparison.rows.len(), comparison.asked), (1, 8));
    write(&comparison, folder.path());
    for name in ["comparison.html", "README.md"] {
        let page = std::fs::read_to_string(folder.path().join("out").join(name)).expect("read");
        assert!(page.contains("Stopped: 7 of 8 solves are missing."), "{name}");
    }
    // before the first row there is nothing to keep
    rows.set(1);
    let nothing = file.run(&Registry::default(), &mut StopAfterOne(&rows), |_| ());
    assert!(nothing.is_err_and(|error| error.is_stop()));
}

#[test]
fn slips_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for (from, to, told) in [
        ("\"krylov\"", "\"krilov\"", "krylov"),
        ("\"krylov\"", "\"krylov\", \"krylov\"", "twice"),
        ("repeats = 1", "repeats = 0", "repeats"),
        ("points = 5", "pionts = 5", "pionts"),
        ("volume_fraction = 0.12", "volume_fraction = 1.2", "volume_fraction"),
        ("[study.layer]", "case = \"x.json\"\n[study.layer]", "exactly one"),
        ("repeats = 1", "accuracy = 1e-2", "resolutions"),
        ("repeats = 1", "accuracy = 2", "resolutions"),
        ("points = 5", "points = 0", "resolutions[0].points"),
        ("points = 5", "points = 60000", "would need"),
        ("repeats = 1", "goal.tolerance = -1", "goal.tolerance"),
        ("repeats = 1", "goal.max_applications = 0", "goal.max_applications"),
        ("repeats = 1", "wavelength_nm = 900", "wavelength_nm"),
        ("repeats = 1", "polar_deg = 90", "polar angle"),
    ] {
        let path = folder.path().join("slip.toml");
        std::fs::write(&path, TINY.replace(from, to)).expect("written");
        let [run, plan] =
            [true, false].map(|run| refusal(&path, run).unwrap_or_else(|| panic!("{to}: {run}")));
        assert!(run.contains(told) && run.contains("slip.toml"), "{to}: {run}");
        // what a run refuses, its plan refuses in the same words; the memory that is free may have changed
        let words = |told: &str| told.split(" of the ").next().map(str::to_owned);
        assert_eq!(words(&run), words(&plan));
    }
}

/// What a run, or its plan, says against a file.
fn refusal(path: &Path, run: bool) -> Option<String> {
    let read = ComparisonFile::read(path);
    let registry = Registry::default();
    let error = match read {
        Err(error) => Some(error),
        Ok(file) if run => file.run(&registry, &mut Silent, |_| ()).err(),
        Ok(file) => file.plan(&registry).err(),
    };
    error.map(|error| error.to_string())
}

/// The cases of a matrix: weak and strong contrast.
const MATRIX: &str = "[matrix]\npigments = [[1.5, 0.0], [2.5, 0.0]]\nperiods_um = [0.5]\n";

/// Fields that a matrix varies are checked wherever they are written, without a solve.
#[test]
fn plans_of_matrices_look_at_every_case() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("matrix.toml");
    std::fs::write(&path, format!("{TINY}{MATRIX}")).expect("written");
    assert_eq!(refusal(&path, false), None);
    for (from, to, told) in [
        ("[2.5, 0.0]", "[25, 0.0]", "matrix.pigments[1][0]"),
        ("[2.5, 0.0]", "[2.5, -1.0]", "matrix.pigments[1][1]"),
        ("[0.5]", "[0.5, -0.5]", "matrix.periods_um[1]"),
        ("[0.5]", "[0.5, 0.2]", "period"),
        ("[0.5]", "[0.5]\naccuracy = 0.1", "accuracy"),
    ] {
        std::fs::write(&path, format!("{TINY}{}", MATRIX.replace(from, to))).expect("written");
        let plan = refusal(&path, false).unwrap_or_else(|| panic!("{to}"));
        assert!(plan.contains(told) && plan.contains("matrix.toml"), "{to}: {plan}");
    }
    let case = folder.path().join("case.json");
    let film = r#"{ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] }"#;
    std::fs::write(case, film).expect("written");
    for (more, told) in [(MATRIX, "a study, whose period"), ("polar_deg = 20\n", "own direction")] {
        std::fs::write(&path, format!("case = \"case.json\"\n{more}")).expect("written");
        let [run, plan] = [true, false].map(|run| refusal(&path, run).expect("refused"));
        assert!(run == plan && plan.contains(told), "{run}\n{plan}");
    }
}

const WHOLE: &str = "[study.layer]\ncell = 'fixed'\nperiod_um = 0.5\nthickness_um = 0.5\n[[study.pigment]]\n\
    diameter_nm = 250\nvolume_fraction = 0.12\nindex = 1.4\n[study.light]\nwavelengths_nm = [550]\n";

#[test]
fn keys_of_studies_without_effect_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    assert!(tiny(folder.path()).unused().is_empty());
    let more = "[study.layer.composed]\nslab_um = 0.2\n[study.paper]\nalbedo = 0.5\n[study.run]\nseed = 3\nrealisations = 9\n[study.solver]\ntolerance = 1e-3\n";
    let own = written(folder.path(), "own.toml", &format!("{WHOLE}{more}"));
    assert_eq!(
        own.unused(),
        ["study.layer.composed", "study.paper", "study.solver", "study.run.realisations"]
    );
    let matrix = "repeats = 2\nstudy = 'study.toml'\n[matrix]\npigments = [[1.5, 0.0]]\nperiods_um = [0.5]\n";
    std::fs::write(folder.path().join("study.toml"), WHOLE.replace("study.", "")).expect("written");
    let beside = written(folder.path(), "matrix.toml", matrix);
    let varied =
        ["layer.cell", "layer.period_um", "pigment[0].index"].map(|key| format!("study.toml: {key}"));
    assert_eq!(beside.unused(), varied);
}

/// A matrix of the tiny study with `keys`, run in `folder`.
fn matrix(folder: &Path, keys: &str, pigments: &str) -> Comparison {
    let lists = "schemes = [\"cubic\", \"second_difference\"]\nresolutions = [{ points = 5, cells = 6 }]\n";
    let text = TINY.replace(lists, keys).replace("\"direct\"", "\"bicgstab\"");
    let matrix = format!("[matrix]\npigments = {pigments}\nperiods_um = [0.5]\n");
    let file = written(folder, "my matrix.toml", &(text + &matrix));
    let plan = file.plan(&Registry::default()).expect("a plan");
    let comparison = file.run(&Registry::default(), &mut Silent, |_| ()).expect("compared");
    assert_eq!((plan.rows, comparison.asked), (comparison.rows.len(), comparison.rows.len()));
    comparison
}

#[test]
fn a_matrix_tells_costs_and_reasons() {
    let folder = tempfile::tempdir().expect("a folder");
    let matrix = matrix(folder.path(), "accuracy = 0.1\n", "[[1.5, 0.0], [2.5, 0.0]]");
    assert_eq!(matrix.rows.len(), 8);
    for case in matrix.rows.chunks(4) {
        // One discrete problem: what converges agrees to the residual, a hundredth of 0.1, amplified.
        let errors: Vec<f64> = case.iter().filter_map(|row| row.result.clone().ok()).collect();
        let least = errors.iter().copied().reduce(f64::min).expect("krylov's");
        let most = errors.iter().copied().reduce(f64::max).expect("krylov's");
        assert!(most - least < 2e-2 && most < 0.2, "{errors:?}");
        let strong = case[0].case.is_some_and(|varied| varied.pigment[0] == 2.5);
        assert_eq!(case[1].outcome().contains("diverges"), strong, "{}", case[1].outcome());
    }
    assert!(matrix.rows.iter().filter(|row| row.strategy == "krylov").all(Row::converged));
    write(&matrix, folder.path());
    let page = std::fs::read_to_string(folder.path().join("out/comparison.html")).expect("the page");
    assert!(page.contains("1.5\u{a0}+\u{a0}0i") && page.contains("diverges"));
    // the default limit, and how to make the page again
    assert!(
        page.contains("after 2000 applications") && page.contains("my matrix.toml&#x27; --output"),
        "{page}"
    );
    // Born is missing beside 2.5; all others keep their colours there.
    let plot = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a plot");
    let weak = plot("out/applications-1.svg");
    let strong = plot("out/applications-2.svg");
    assert!(weak.contains("\nborn\n") && !strong.contains("\nborn\n"));
    for name in ["krylov", "bicgstab"] {
        assert_eq!(colour(&weak, name), colour(&strong, name), "{name}");
    }
    assert_ne!(colour(&weak, "krylov"), colour(&weak, "bicgstab"));
}

/// Scheme, grid and mean of every row.
fn discrete(comparison: &Comparison) -> Vec<(Scheme, usize, bool)> {
    let discrete = |row: &Row| row.discrete.map(|d| (d.resolution.scheme, d.resolution.nx, d.absorbing_mean));
    comparison.rows.iter().filter_map(discrete).collect()
}

/// Keys beside a matrix were taken and had no effect.
#[test]
fn every_key_beside_a_matrix_has_its_effect() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |keys: &str| matrix(folder.path(), keys, "[[1.5, 0.05]]");
    // krylov, born and bicgstab with both means, relaxation with the real one alone
    let usual = discrete(&run("accuracy = 0.1\n"));
    assert_eq!(usual.iter().filter(|row| row.2).count(), 3);
    assert_eq!(usual.len(), 7);
    let real = discrete(&run("accuracy = 0.1\nabsorbing_mean = false\n"));
    assert!(real.len() == 4 && real.iter().all(|row| !row.2));
    let absorbing = run("accuracy = 0.1\nabsorbing_mean = true\n");
    assert!(discrete(&absorbing).len() == 4 && discrete(&absorbing).iter().all(|row| row.2));
    assert!(absorbing.rows[2].outcome().contains("real ⟨k²⟩"), "relaxation: {}", absorbing.rows[2].outcome());
    let listed = run("schemes = [\"quadratic\"]\nresolutions = [{ points = 7, cells = 6 }]\n");
    assert!(discrete(&listed).iter().all(|row| (row.0, row.1) == (Scheme::Quadratic, 7)));
    let whole = run("accuracy = 0.1\nmean_depends_on_z = false\n");
    let residuals =
        |c: &Comparison| c.rows.iter().map(|r| r.account.clone().map(|a| a.residual)).collect::<Vec<_>>();
    assert_ne!(residuals(&whole), residuals(&run("accuracy = 0.1\n")));
}

/// With strong absorption the mean decides: the Born series converges about an absorbing medium and diverges about a real one.
#[test]
fn strategies_show_what_the_better_mean_makes_of_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let comparison = matrix(folder.path(), "accuracy = 0.1\n", "[[1.4, 0.5]]");
    let find = |name: &str, absorbing: bool| {
        let of =
            |row: &&Row| row.strategy == name && row.discrete.is_some_and(|d| d.absorbing_mean == absorbing);
        comparison.rows.iter().find(of).expect("a row")
    };
    assert!(find("born", true).converged(), "{}", find("born", true).outcome());
    assert!(find("born", false).outcome().contains("diverges"), "{}", find("born", false).outcome());
    write(&comparison, folder.path());
    let page = std::fs::read_to_string(folder.path().join("out/README.md")).expect("the page");
    assert!(page.contains("| absorbing |") && page.contains("| real |"), "{page}");
}

/// Colour of the line that the legend draws before a name.
fn colour<'a>(svg: &'a str, name: &str) -> &'a str {
    let after = svg.split(&format!("\n{name}\n")).nth(1).expect("a name");
    after.split("stroke=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a line")
}
