//! Runs that are stopped, and go on.

use super::super::run_continue::StopAfter;
use super::*;
use inkwave::evaluate::evaluated::FinishedSolves;
use inkwave::report::publish::evaluate_and_publish;
use inkwave::run::{RunError, RunSettings};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::work::alone::run_study;
use std::sync::atomic::AtomicUsize;

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
