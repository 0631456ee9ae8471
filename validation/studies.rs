//! Small studies run as a user runs them, for claims about whole results.

use inkwave::evaluate::composed::summary::summarise_slabs;
use inkwave::evaluate::manifest::Manifest;
use inkwave::evaluate::seen::{Seen, see};
use inkwave::evaluate::summary::summarise;
use inkwave::input::load::load;
use inkwave::input::study::{Study, StudyKind};
use inkwave::material::mixing::MixingRule;
use inkwave::run::{Collected, RunSettings};
use inkwave::solve::accuracy::grid_error::GridError;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::work::alone::{run_portions, run_study};
use serde_json::Value;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A study with all that follows from its solves.
pub struct Done {
    /// What its solves say.
    pub seen: Seen,
    /// `results.json`.
    pub results: Value,
}

/// Runs studies, whose numbers begin at 0, on as many plain threads as there are cores. In rayon's loops a study that waits
/// for its solves would begin another on the same stack, until hundreds have overflowed it.
pub fn side_by_side<T: Send>(count: usize, run: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let mine = || {
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        numbers.take_while(|&number| number < count).map(|number| (number, run(number))).collect::<Vec<_>>()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut all: Vec<(usize, T)> = std::thread::scope(|scope| {
        let all: Vec<_> = (0..threads).map(|_| scope.spawn(mine)).collect();
        all.into_iter().flat_map(|thread| thread.join().expect("no study panics")).collect()
    });
    all.sort_by_key(|&(number, _)| number);
    all.into_iter().map(|(_, one)| one).collect()
}

/// Checks and runs a study file's text in a folder of its own.
pub fn done(text: &str) -> Done {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let study = checked(text);
    told(&study, &solved(&study, &folder.path().join("out")))
}

/// `results.json` with bars that hold everything but the grid's error, of a study that is run in `folder` as far as it
/// is not there already.
pub fn apart_from_the_grid(text: &str, folder: &Path) -> Value {
    let study = checked(text);
    let mut collected = solved(&study, folder);
    collected.resolved.grid_error = GridError::default();
    told(&study, &collected).results
}

/// `results.json` as it is, and with bars that hold everything but the grid's error.
pub fn with_and_without_the_grid(text: &str, folder: &Path) -> [Value; 2] {
    let study = checked(text);
    let whole = solved(&study, folder);
    let mut apart = whole.clone();
    apart.resolved.grid_error = GridError::default();
    [whole, apart].map(|collected| told(&study, &collected).results)
}

/// `results.json` of a composed layer.
pub fn composed(text: &str) -> Value {
    composed_between(text, None)
}

/// `results.json` of a composed layer whose slabs are solved between half-spaces by a mixing rule; without one, by that
/// of its wave equation.
pub fn composed_between(text: &str, mixing: Option<MixingRule>) -> Value {
    let mut study = checked(text);
    let folder = tempfile::tempdir().expect("a temporary folder");
    if let StudyKind::Composed(composed) = &mut study.kind {
        composed.mixing = mixing;
    }
    let output = OutputFolder::open(folder.path(), Holds::Study).expect("a folder for the study");
    let solved = run_portions(&study, &output, RunSettings::default(), &()).expect("slabs that run").solved;
    serde_json::to_value(summarise_slabs(&study, &solved).expect("complete slabs")).expect("JSON")
}

/// A study file's text, checked.
pub fn checked(text: &str) -> Study {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).expect("written");
    load(&path).expect("a sound study")
}

fn solved(study: &Study, folder: &Path) -> Collected {
    let output = OutputFolder::open(folder, Holds::Study).expect("a folder for the study");
    run_study(study, &output, RunSettings::default(), &()).expect("a study that runs").collected
}

fn told(study: &Study, collected: &Collected) -> Done {
    let seen = see(study, collected).expect("records that belong together");
    let manifest: Manifest = summarise(study, collected, &seen);
    Done { results: serde_json::to_value(&manifest).expect("JSON"), seen }
}

/// Value and standard error of an estimate in `results.json`.
pub fn estimate(value: &Value) -> [f64; 2] {
    ["value", "standard_error"].map(|key| value[key].as_f64().unwrap_or(f64::NAN))
}

/// Row of the spectra at a wavelength and angle.
pub fn row(results: &Value, nm: f64, polar_deg: f64) -> &Value {
    let here = |row: &&Value| {
        let near = |key: &str, wanted: f64| (row[key].as_f64().unwrap_or(f64::NAN) - wanted).abs() < 1e-6;
        near("wavelength_nm", nm) && near("polar_deg", polar_deg)
    };
    results["spectra"].as_array().and_then(|rows| rows.iter().find(here)).expect("a row of the spectra")
}
