//! Bad input: every fault is reported with its field, what was found, what is allowed and what to try; the exit
//! code is not zero and nothing is written.

use crate::run_support::{TINY, run, study};
use crate::slips::{BLANK, BLANK_IN_STACKS, INK, K, LIGHT, NUMBER, OF_STACKS, STACK, Slip};
use std::path::Path;

/// The message without the frame and the line breaks of the terminal.
fn plain(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text).replace('│', " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn refused(study: &Path, output: &Path) -> String {
    let done = run(study, output, &[]);
    let message = plain(&done.stderr);
    assert!(!done.status.success(), "accepted");
    assert!(!message.contains("panicked"), "{message}");
    assert!(!output.exists(), "something was written: {message}");
    message
}

#[test]
fn every_mistake_is_reported_with_field_value_range_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let csv = |name: &str, rows: &str| {
        std::fs::write(folder.path().join(name), format!("wavelength_nm,kappa\n{rows}")).unwrap();
    };
    csv("negative.csv", "400,-0.2\n700,0.1\n");
    csv("narrow.csv", "500,0.1\n600,0.1\n");
    csv("wide.csv", "380,0.1\n780,0.1\n");
    csv("huge.csv", "380,1e5\n780,1e5\n");
    csv("angstrom.csv", "3000,0.1\n8000,0.2\n");
    csv("empty.csv", "400,0.1\n550,\n700,0.1\n");
    csv("micrometres.csv", "0.4,0.1\n0.7,0.1\n");
    std::fs::write(folder.path().join("dark.csv"), "wavelength_nm,reflectance\n400,0.8\n700,2.9\n").unwrap();
    std::fs::write(folder.path().join("angstrom_print.csv"), "nm,reflectance\n3000,0.5\n8000,0.6\n").unwrap();
    std::fs::write(folder.path().join("comma.csv"), "wavelength_nm,reflectance\n400,0,5\n").unwrap();
    std::fs::write(folder.path().join("below.csv"), "wavelength_nm,weight\n400,1\n700,-0.5\n").unwrap();
    for (name, constant) in [("negative_square.yml", "-2"), ("small_n.yml", "0.0001")] {
        let record = format!(
            "DATA:\n  - type: formula 3\n    wavelength_range: 0.3 0.9\n    coefficients: {constant} 0 0\n"
        );
        std::fs::write(folder.path().join(name), record).unwrap();
    }
    let mut missed = Vec::new();
    let of_layers = INK.iter().chain(LIGHT).chain(NUMBER).chain(BLANK).map(|slip| (TINY, slip));
    let of_stacks = OF_STACKS.iter().chain(BLANK_IN_STACKS).map(|slip| (STACK, slip));
    for (good, Slip { from, to, says }) in of_layers.chain(of_stacks) {
        assert!(good.contains(from), "{from}");
        let text = good.replacen(from, to, 1);
        let message = refused(&study(folder.path(), &text), &folder.path().join("out"));
        for part in says {
            if !message.contains(part) {
                missed.push(format!("{to:?} does not say {part:?}: {message}"));
            }
        }
        let line = to.lines().last().unwrap_or_default();
        if (message.contains("NaN") && !to.contains("nan")) || message.contains("found given") {
            missed.push(format!("{to:?} says no value: {message}"));
        }
        if !line.is_empty() && !message.contains("study.toml:") {
            missed.push(format!("{to:?} does not show its line: {message}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n\n"));
}

#[test]
fn all_faults_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("seed = 7", "seed = 7\n[paper]\nalbedo = 2").replace("count = 3", "count = 1000");
    let message = refused(&study(folder.path(), &text), &folder.path().join("out"));
    assert!(
        message.contains("2 fields") && message.contains("paper.albedo") && message.contains("angles.count"),
        "{message}"
    );
}

#[test]
fn a_fault_of_the_light_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("from_nm = 400", "from_nm = 1");
    let message = refused(&study(folder.path(), &text), &folder.path().join("out"));
    assert!(!message.contains("fields") && !message.contains("pigment[0].index"), "{message}");
    let text = TINY.replace("seed = 7", "seed = 7\ntarget_delta_e = 1e-300");
    let message = refused(&study(folder.path(), &text), &folder.path().join("out"));
    assert!(message.contains("run.target_delta_e: found 1e-300;"), "{message}");
}

#[test]
fn a_sweep_gets_the_name_of_its_own_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = study(
        folder.path(),
        "base = \"yellow.toml\"\n[[axis]]\nfield = \"paper.albedo\"\nvalues = [0.5, 0.9]\n",
    );
    let message = refused(&path, &folder.path().join("out"));
    assert!(message.contains("study.toml is a sweep") && message.contains("`inkwave sweep "), "{message}");
    // a slip in a study stays one
    let message =
        refused(&study(folder.path(), &TINY.replace("[run]", "[base]")), &folder.path().join("out"));
    assert!(message.contains("unknown key") && !message.contains("is a sweep"), "{message}");
}

#[test]
fn all_unknown_keys_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("seed = 7", "sead = 7\nspeed = 3").replace("built_in", "builtin");
    let text = text.replace("[output]", "[ouput]");
    let message = refused(&study(folder.path(), &text), &folder.path().join("out"));
    for part in
        ["run.sead", "did you mean seed?", "run.speed", "pigment[0].index.builtin", "ouput", "4 fields"]
    {
        assert!(message.contains(part), "{part}: {message}");
    }
}

#[test]
fn concentrations_that_cannot_be_packed_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("volume_fraction = 0.15", "volume_fraction = 0.64");
    let text = text.replace("[output]", "[packing.relaxation]\nmax_steps = 200\n[output]");
    let message = refused(&study(folder.path(), &text), &folder.path().join("out"));
    for part in ["volume fraction", "0.64", "not reached", "volume_fraction"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn paths_that_cannot_be_read_or_written_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let good = study(folder.path(), TINY);
    let out = folder.path().join("out");
    let message = refused(&folder.path().join("none.toml"), &out);
    assert!(
        message.contains("none.toml") && message.contains("cannot read") && message.contains("give the path"),
        "{message}"
    );

    let below_a_file = good.join("out");
    let message = refused(&good, &below_a_file);
    assert!(message.contains("cannot write") && message.contains("--output DIR"), "{message}");

    std::fs::write(folder.path().join("thesis.txt"), "years of work").unwrap();
    let done = run(&good, folder.path(), &[]);
    let message = plain(&done.stderr);
    assert!(
        !done.status.success() && message.contains("holds other files") && message.contains("--output DIR"),
        "{message}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing was added");
}

/// Wide gaps between rows may be meant so: they are told of once, and the study goes on to its next fault, or runs.
#[test]
fn wide_gaps_between_rows_are_told_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("two.csv"), "wavelength_nm,kappa\n400,0.1\n700,0.2\n").unwrap();
    std::fs::write(folder.path().join("print.csv"), "wavelength_nm,reflectance\n400,0.1\n700,0.2\n").unwrap();
    let text = TINY.replacen(K, "index = { csv = \"two.csv\", n = 1.4 }", 1);
    let text = text.replace("[output]", "[compare]\nmeasured = \"print.csv\"\n[output]");
    let done = run(&study(folder.path(), &text), &folder.path().join("out"), &["--plan"]);
    let message = plain(&done.stderr);
    assert!(done.status.success(), "{message}");
    let measured = text.replace("n = 1.4", "kramers_kronig = { n_nm = 550, n = 1.5 }");
    let done = run(&study(folder.path(), &measured), &folder.path().join("out"), &["--plan"]);
    let said = plain(&done.stderr);
    assert!(said.contains("two.csv: κ is 0.200 at 700 nm, where the table ends"), "{said}");
    for file in ["two.csv: no row between 400 and 700 nm", "print.csv: no row between 400 and 700 nm"] {
        assert_eq!(message.matches(file).count(), 1, "{message}");
    }
}
