//! Runs of composed layers that are noisy, shared, shortened or stopped.

use super::run_support::{COMPOSED, command, plain, results, run, study, succeed, with};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

/// Slabs whose grid is searched, and coarser for longer waves.
fn searched() -> String {
    let layer = with(COMPOSED, "[450, 550, 650]", "[430, 540, 660]");
    with(&layer, "points_per_um = 12\nplanes_per_um = 36", "accuracy = 5e-2\nper_wavelength = true")
}

/// Longest time between a signal and the end, on a loaded machine: the promise is a second or two.
const PROMPT: Duration = Duration::from_secs(10);

/// Few realisations of a masstone leave no coherent light in the mean of an inner slab: what follows
/// from its logarithm is withheld, and the run ends. *Planted*: the logarithm taken all the same.
#[test]
fn slabs_without_coherent_light_end_and_withhold_what_follows_from_it() {
    let scratch = tempfile::tempdir().unwrap();
    let text = r#"
title = "Red iron oxide masstone"
[layer]
thickness_um = [6, 12]
period_um = 0.9
binder.index = { material = "PMMA" }
composed = { slab_um = 1.0 }
[[pigment]]
name = "haematite"
shape = "sphere"
diameter_nm = 200
volume_fraction = 0.15
share = "scale_sizes"
index = { material = "Fe2O3" }
[paper]
albedo = 0.85
[light]
wavelengths_nm = [640]
[run]
realisations = 4
seed = 1
[resolution]
accuracy = 1e-1
"#;
    let file = study(scratch.path(), text);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let results = results(&output);
    let medium = &results["medium"][0];
    assert!(medium["coherent_path_um"].is_null() && medium["asymmetry"].is_null(), "{medium}");
    let munk = medium["kubelka_munk_scattering_per_um"]["value"].as_f64();
    assert!(munk.is_some_and(|s| s > 0.0), "{medium}");
    let withheld = results["withheld"].to_string();
    assert!(withheld.contains("not determined by these realisations at 640 nm"), "{withheld}");
}

/// Fits of a composed base are refused that search on both sides of the binder's index, where coats do not scatter.
#[test]
fn fits_of_composed_layers_on_both_sides_of_the_binder_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| {
        std::fs::write(scratch.path().join(name), text).expect("written");
        scratch.path().join(name)
    };
    put("base.toml", &searched().replace("[1, 2, 50]", "20").replace("realisations = 2", "realisations = 6"));
    put("card.csv", "wavelength_nm,reflectance\n400,0.5\n700,0.6\n");
    let fit = "base = \"base.toml\"\n[[measured]]\nfile = \"card.csv\"\nbacking = 0.8\n";
    let refusal = format!("{:?}", inkwave::fit::load::load(&put("fit.toml", fit)).err());
    assert!(refusal.contains("fit.n") && refusal.contains("above or all below the binder's"), "{refusal}");
}

/// A masstone in tiny cells, whose grids are too coarse for truth but the same in both: its index is found from 45:0 of
/// other packings.
const MASSTONE: &str = r#"
[layer]
period_um = 0.6
thickness_um = 16
binder.index = 1.5
composed = { slab_um = 0.5, directions = [2, 2] }
[[pigment]]
name = "grains"
diameter_nm = 180
volume_fraction = 0.15
index = INDEX
[paper]
albedo = 0.04
[light]
wavelengths_nm = [500, 600]
[run]
realisations = 8
seed = SEED
[resolution]
points_per_um = 14
planes_per_um = 20
"#;

/// κ of an opaque coat is found where n is known at one wavelength, with its error; without, n is said to be undetermined.
/// The plan tells the solves of all nodes.
#[test]
fn an_opaque_coat_gives_kappa_where_n_is_known() {
    let scratch = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| std::fs::write(scratch.path().join(name), text).expect("written");
    let truth = [[500.0, 0.06], [600.0, 0.02]];
    put("index.csv", "wavelength_nm,kappa,n\n500,0.06,2.0\n600,0.02,2.0\n");
    let other = MASSTONE.replace("SEED", "11").replace("INDEX", "{ csv = \"index.csv\" }");
    succeed(&study(scratch.path(), &other), &scratch.path().join("truth"), &[]);
    let rows = results(&scratch.path().join("truth"))["spectra"].clone();
    let rows = rows.as_array().expect("rows").iter();
    let factor = |row: &Value| row["lit_at_45"]["value"].as_f64().expect("a factor");
    let spectrum: Vec<f64> = rows.map(factor).collect();
    put("coat.csv", &format!("wavelength_nm,reflectance\n500,{}\n600,{}\n", spectrum[0], spectrum[1]));
    put("base.toml", &MASSTONE.replace("SEED", "1").replace("INDEX", "1.9"));
    let fit = |known: &str| {
        put(
            "fit.toml",
            &format!(
                "base = \"base.toml\"\n[[measured]]\nfile = \"coat.csv\"\nbacking = 0.04\n[fit]\nn = [1.8, 2.2]\nkappa = [0.0, 0.3]\n{known}"
            ),
        );
        let program = |more: &[&str]| {
            let mut words = vec!["fit", "fit.toml", "--output", "fitted"];
            words.extend(more);
            let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
            program.current_dir(scratch.path()).args(words).output().expect("the program")
        };
        if !known.is_empty() {
            let plan = String::from_utf8_lossy(&program(&["--plan"]).stdout).into_owned();
            // 3 × 5 nodes of n and κ, each with four slabs
            assert!(plan.contains("variants          60"), "{plan}");
        }
        let done = program(&[]);
        assert!(done.status.success(), "{}", plain(&done));
        let json = std::fs::read(scratch.path().join("fitted/fit.json")).expect("a fit");
        serde_json::from_slice::<Value>(&json).expect("JSON")["fit"].clone()
    };
    let known = fit("known_n = { n_nm = 550, n = 2.0, n_error = 0.02 }\n");
    for (row, [nm, kappa]) in known["index"].as_array().expect("rows").iter().zip(truth) {
        let found = row["kappa"].as_f64().expect("κ");
        let error = row["kappa_error"].as_f64().expect("its error");
        assert!((found - kappa).abs() < 3.0 * error, "{nm}: {found} ± {error} for {kappa}");
        assert!(error < 0.4 * kappa && (found / kappa - 1.0).abs() < 0.3, "{nm}: {found} ± {error}");
    }
    let open = fit("");
    assert_eq!(open["n_is_determined"], false);
    assert!(open["remarks"][0].as_str().is_some_and(|said| said.contains("fit.known_n")), "{open}");
}

fn start(file: &Path, output: &Path) -> Child {
    let mut command = command(file, output, &["--jobs", "1"]);
    command.env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// Number of solves that a process says it has made.
fn solved(output: &Output) -> usize {
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let line = told.lines().find(|line| line.contains(" solves in "));
    line.map_or(0, |line| line.split_whitespace().next().expect("a number").parse().expect("a number"))
}

/// Two processes on one composed layer end well and make every solve once, each some of them.
/// *Planted*: every process with work of its own name.
#[test]
fn processes_in_one_folder_share_a_composed_layer() {
    let scratch = tempfile::tempdir().unwrap();
    let text = searched().replace("realisations = 2", "realisations = 8");
    let file = study(scratch.path(), &text);
    let alone = scratch.path().join("alone");
    let all = solved(&run(&file, &alone, &[]));
    let shared = scratch.path().join("shared");
    let workers = [(); 2].map(|()| start(&file, &shared));
    let ends = workers.map(|worker| worker.wait_with_output().expect("an end"));
    for end in &ends {
        assert!(end.status.success(), "{}", plain(end));
        assert!((1..all).contains(&solved(end)), "{} of {all}: {}", solved(end), plain(end));
    }
    assert_eq!(ends.iter().map(solved).sum::<usize>(), all, "each solve is made once");
    let one = results(&alone);
    let other = results(&shared);
    assert_eq!(other["status"], "complete");
    for key in ["spectra", "medium", "colours"] {
        assert_eq!(one[key], other[key], "{key}");
    }
}

/// Part of a list of wavelengths needs no solve, whichever part. *Planted*: the coarsening relative
/// to the shortest wavelength that is left.
#[test]
fn fewer_wavelengths_need_no_solve() {
    let scratch = tempfile::tempdir().unwrap();
    let file = study(scratch.path(), &searched());
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let first = results(&output);
    for (list, rows) in [("[430, 660]", [0, 2]), ("[540, 660]", [1, 2]), ("[430, 540]", [0, 1])] {
        let fewer = study(scratch.path(), &searched().replace("[430, 540, 660]", list));
        let said = succeed(&fewer, &output, &[]);
        assert!(said.contains("already stored") && !said.contains("per hour"), "{list}: {said}");
        let fewer = results(&output);
        for (k, row) in rows.into_iter().enumerate() {
            let own = &fewer["spectra"][k];
            let before = &first["spectra"][row];
            for key in ["wavelength_nm", "reflectance_normal", "transmittance_45", "lit_at_45"] {
                // errors look at neighbouring wavelengths, numbers do not
                let number = |row: &Value| row[key]["value"].as_f64().or(row[key].as_f64());
                assert_eq!(number(own), number(before), "{list}: {key}");
            }
        }
    }
}

/// A signal while the numbers of stored solves are evaluated ends the program at once, and the same
/// command goes on from there. *Planted*: a flag that only solves read.
#[cfg(unix)]
#[test]
fn evaluation_hears_both_signals_and_loses_nothing() {
    use nix::sys::signal::{Signal, kill};
    let scratch = tempfile::tempdir().unwrap();
    let text = searched().replace("realisations = 2", "realisations = 6");
    let file = study(scratch.path(), &text);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let whole = results(&output);
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let mut child = start(&file, &output);
        let mut lines = BufReader::new(child.stderr.take().expect("standard error"));
        let mut line = String::new();
        while !line.contains("evaluating the layer") {
            line.clear();
            assert!(lines.read_line(&mut line).expect("text") > 0, "it ended before its evaluation");
        }
        let clock = Instant::now();
        let process = nix::unistd::Pid::from_raw(i32::try_from(child.id()).expect("a number of a process"));
        kill(process, signal).expect("a signal");
        let status = child.wait().expect("an end");
        assert!(clock.elapsed() < PROMPT, "{signal}: {:?}", clock.elapsed());
        let mut rest = String::new();
        lines.read_to_string(&mut rest).expect("text");
        assert_eq!(status.code(), Some(130), "{signal}: {rest}");
        assert!(rest.contains("everything solved is kept") && rest.contains("to resume"), "{rest}");
    }
    let done = run(&file, &output, &[]);
    assert!(done.status.success() && !plain(&done).contains("per hour"), "{}", plain(&done));
    assert_eq!(results(&output)["spectra"], whole["spectra"]);
}

/// A sweep of composed layers in two shards, with grids that were chosen before, gives the same as
/// the sweep in one process, each solve made once. *Planted*: every slab's grid chosen on its own.
#[test]
fn shards_of_composed_layers_are_merged() {
    let scratch = tempfile::tempdir().unwrap();
    let path = |name: &str| scratch.path().join(name).display().to_string();
    let base = searched()
        .replace("realisations = 2", "realisations = 3")
        .replace("wavelengths_nm = [430, 540, 660]", "wavelengths_nm = [540]");
    std::fs::write(path("base.toml"), base).unwrap();
    let axis = "base = \"base.toml\"\n[[axis]]\nname = \"paper\"\nfield = \"paper.albedo\"\nvalues = [1.0, 0.6]\n\
                [[axis]]\nname = \"index\"\nfield = \"pigment.grains.index\"\nvalues = [2.0, 2.2]\n";
    std::fs::write(path("sweep.toml"), axis).unwrap();
    let sweep = path("sweep.toml");
    let made = |arguments: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
        let done = command.args(arguments).output().expect("the program starts");
        assert!(done.status.success(), "{}", plain(&done));
        solved(&done)
    };
    let whole = made(&["sweep", &sweep, "--output", &path("whole")]);
    made(&["sweep", &sweep, "--output", &path("grids"), "--grids-only"]);
    let shards = ["1/2", "2/2"].map(|shard| {
        let folder = path(&shard[..1]);
        let grids = path("grids");
        made(&["sweep", &sweep, "--output", &folder, "--shard", shard, "--grids", &grids])
    });
    assert!(shards.iter().all(|&solves| solves > 0), "{shards:?}");
    // papers share all solves: the two of a unit stay together
    assert_eq!(shards.iter().sum::<usize>(), whole);
    made(&["merge", &path("1"), &path("2"), "--output", &path("merged")]);
    let table = |folder: &str| std::fs::read(scratch.path().join(folder).join("composed.csv")).unwrap();
    assert!(table("merged") == table("whole"), "{}", String::from_utf8_lossy(&table("merged")));
    for variant in std::fs::read_dir(scratch.path().join("whole/variants")).unwrap() {
        let name = variant.unwrap().file_name();
        let spectra = |folder: &str| {
            results(&scratch.path().join(folder).join("variants").join(&name))["spectra"].clone()
        };
        assert_eq!(spectra("merged"), spectra("whole"), "{}", name.display());
    }
    assert!(!scratch.path().join("merged/PARTIAL").exists());
}
