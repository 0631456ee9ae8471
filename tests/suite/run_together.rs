//! Two processes that run one study in one folder share its work, and neither takes the folder from the other.

use crate::run_support::{TINY, command, study, succeed};
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

fn start(study: &Path, out: &Path) -> Child {
    let mut command = command(study, out, &["--jobs", "1"]);
    command.env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat()
}

/// Solves that a process says it has made.
fn solved(output: &Output) -> usize {
    let told = said(output);
    let line = told.lines().find(|line| line.contains(" solves in "));
    line.map_or(0, |line| line.split_whitespace().next().unwrap().parse().unwrap())
}

fn wait_until(what: &str, holds: impl Fn() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < Duration::from_secs(60), "no {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Eight cells of 13 × 3 solves.
fn long_study() -> String {
    TINY.replace("step_nm = 100", "step_nm = 25").replace("realisations = 2", "realisations = 8")
}

#[test]
fn two_runs_on_one_folder_share_the_solves() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), &long_study());
    let alone = folder.path().join("alone");
    let shared = folder.path().join("shared");
    succeed(&study, &alone, &[]);
    let both = [(); 2].map(|()| start(&study, &shared)).map(|child| child.wait_with_output().unwrap());
    assert!(both.iter().all(|done| done.status.success()), "{}", both.each_ref().map(said).concat());
    let all = 8 * 13 * 3;
    assert_eq!(both.iter().map(solved).sum::<usize>(), all, "each solve is made once");
    assert!(both.iter().all(|done| solved(done) < all), "{:?}", both.each_ref().map(solved));
    assert!(both.iter().any(|done| said(done).contains("Report:")));
    for file in ["spectra.csv", "bdf.csv", "picture.png"] {
        assert!(
            std::fs::read(alone.join(file)).unwrap() == std::fs::read(shared.join(file)).unwrap(),
            "{file}"
        );
    }
    assert!(!shared.join("PARTIAL").exists());
}

#[cfg(unix)]
#[test]
fn a_run_that_is_stopped_leaves_the_folder_to_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), &long_study());
    for round in 0..3 {
        let out = folder.path().join(format!("new{round}"));
        let first = start(&study, &out);
        wait_until("folder", || out.join("inkwave.json").exists());
        let second = start(&study, &out);
        std::thread::sleep(Duration::from_millis(40 * round));
        let pid = first.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        let stopped = first.wait_with_output().unwrap();
        let done = second.wait_with_output().unwrap();
        assert!(done.status.success(), "{}\n{}", said(&stopped), said(&done));
        assert!(out.join("results.json").exists() && !out.join("PARTIAL").exists(), "{}", said(&done));
    }
}
