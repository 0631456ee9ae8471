//! Every field of a study counts: a folder that holds other studies' solves gives what a fresh folder gives.
//!
//! A key that forgets an input would hand out an old number for a new question. So each field is changed in turn, run
//! once in a folder that all studies before it have used and once afresh, and all published files are compared.

mod changes;

use crate::run_support::{run, study, succeed};
use changes::Moves::{Nothing, Published, Spectra};
use changes::{CHANGES, ELSEWHERE, MEASURED};
use inkwave::input::file::StudyFile;
use inkwave::input::load::read_file;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

const BASE: &str = r#"
title = "Tiny mixture"
[layer]
cell = "varied"
period_um = 0.8
thickness_um = 0.4
binder.index = 1.558
index_out = 1.0
[[pigment]]
name = "yellow"
diameter_nm = 160
volume_fraction = 0.10
index = { n = 1.40, k = 0.1 }
[[pigment]]
name = "clear"
diameter_nm = 150
volume_fraction = 0.05
index = 1.45
[paper]
albedo = 0.9
[light]
from_nm = 400
to_nm = 700
step_nm = 150
[angles]
count = 3
azimuth_deg = 0
[run]
realisations = 2
seed = 7
[packing]
method = "sequential_addition"
[resolution]
points_per_um = 14
planes_per_um = 30
[solver]
strategy = "krylov"
tolerance = 1e-4
[output]
picture_pixels = 24
"#;

fn base() -> toml::Table {
    toml::from_str(BASE).expect("the base study is TOML")
}

/// The base study with a change.
fn changed(edits: &[(&str, &str)]) -> String {
    let mut file = toml::Value::Table(base());
    for (path, value) in edits {
        let (inside, key) = path.rsplit_once('.').unwrap_or(("", path));
        let mut place = &mut file;
        for part in inside.split('.').filter(|part| !part.is_empty()) {
            place = match part.parse::<usize>() {
                Ok(number) => &mut place[number],
                Err(_) => {
                    place.as_table_mut().expect("a table").entry(part).or_insert(toml::Table::new().into())
                }
            };
        }
        let table = place.as_table_mut().expect("a table");
        match *value {
            "" => drop(table.remove(key).expect("something to take out")),
            value => {
                let written: toml::Table = toml::from_str(&format!("value = {value}")).expect(value);
                table.insert(key.to_owned(), written["value"].clone());
            }
        }
    }
    toml::to_string(&file).expect("a table of tables")
}

/// The published numbers, without what a repetition may change (times) and what no number depends on: the study itself.
fn published(out: impl AsRef<Path>) -> BTreeMap<&'static str, String> {
    let read = |name: &str| std::fs::read(out.as_ref().join(name)).unwrap_or_default();
    let mut results: Value = serde_json::from_slice(&read("results.json")).expect("results.json");
    let object = results.as_object_mut().expect("an object");
    object.retain(|key, _| {
        !key.contains("seconds") && !["study_hash", "study", "title"].contains(&key.as_str())
    });
    let mut files: BTreeMap<&str, String> =
        object.iter().map(|(key, value)| (leaked(key), format!("{value:#}"))).collect();
    for name in ["spectra.csv", "bdf.csv", "kubelka-munk.csv", "measured.csv"] {
        files.insert(name, String::from_utf8(read(name)).expect("UTF-8"));
    }
    files.insert("picture.png", format!("{:?}", pixels(&read("picture.png"))));
    files
}

/// Names of keys, a few dozen in all, for as long as the test runs.
fn leaked(name: &str) -> &'static str {
    name.to_owned().leak()
}

/// The picture's pixels; its text chunks name the study.
fn pixels(png: &[u8]) -> Vec<u8> {
    let Ok(mut reader) = png::Decoder::new(std::io::Cursor::new(png)).read_info() else { return Vec::new() };
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("a picture");
    pixels
}

/// The first line that differs, of every file that does.
fn differences(one: &BTreeMap<&'static str, String>, other: &BTreeMap<&'static str, String>) -> Vec<String> {
    let differing = |name: &&str| one.get(name) != other.get(name);
    let names: BTreeSet<&str> =
        one.keys().chain(other.keys()).copied().filter(|name| differing(name)).collect();
    let text = |of: &BTreeMap<&'static str, String>, name: &str| of.get(name).cloned().unwrap_or_default();
    let shown = |name: &str| {
        let a = text(one, name);
        let b = text(other, name);
        let line = a.lines().zip(b.lines()).find(|(a, b)| a != b).unwrap_or(("more", "fewer"));
        format!("{name}: {:.200} / {:.200}", line.0, line.1)
    };
    names.into_iter().map(shown).collect()
}

/// One change in the shared folder and in a fresh one; what is wrong with it.
fn wrong(
    number: usize,
    folder: &Path,
    shared: &Path,
    before: &BTreeMap<&'static str, String>,
) -> Option<String> {
    let (edits, moves) = CHANGES[number];
    let own = folder.join(format!("fresh-{number}"));
    std::fs::create_dir_all(&own).expect("a folder");
    for name in MEASURED.map(|(name, _)| name) {
        std::fs::copy(folder.join(name), own.join(name)).expect("a copy");
    }
    let file = study(&own, &changed(edits));
    for out in [shared, &own.join("out")] {
        let done = run(&file, out, &[]);
        if !done.status.success() {
            return Some(format!("{edits:?}: {}", String::from_utf8_lossy(&done.stderr)));
        }
    }
    let mixed = published(shared);
    let alone = published(own.join("out"));
    let stale = differences(&mixed, &alone);
    if !stale.is_empty() {
        return Some(format!("{edits:?}: another study's numbers were taken for this one's: {stale:#?}"));
    }
    let moved = differences(before, &alone);
    let spectra = moved.iter().any(|file| file.starts_with("spectra.csv"));
    let fits = match moves {
        Spectra => spectra,
        Published => !moved.is_empty(),
        Nothing => moved.is_empty(),
    };
    (!fits).then(|| format!("{edits:?} should move {moves:?} and moves {moved:#?}"))
}

/// Two threads, each with a folder that it shares among its studies.
#[test]
fn a_changed_field_is_never_answered_with_an_old_number() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in MEASURED {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    let next = AtomicUsize::new(0);
    let faults = Mutex::new(Vec::new());
    let work = |worker: usize| {
        let shared = folder.path().join(format!("shared-{worker}"));
        let place = folder.path().join(format!("base-{worker}"));
        std::fs::create_dir_all(&place).expect("a folder");
        succeed(&study(&place, BASE), &shared, &[]);
        let before = published(&shared);
        let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&number| number < CHANGES.len());
        while let Some(number) = take() {
            faults.lock().expect("no panic").extend(wrong(number, folder.path(), &shared, &before));
        }
    };
    std::thread::scope(|scope| {
        (0..2).for_each(|worker| {
            drop(scope.spawn({
                let work = &work;
                move || work(worker)
            }))
        })
    });
    let faults = faults.into_inner().expect("no panic");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Variants share packings in a sweep: only those that are the same in every realisation. Two periods that hold as many whole grains
/// in the first one are the trap.
#[test]
fn variants_of_a_sweep_are_what_their_studies_are_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut sweep = toml::Table::new();
    sweep.insert("base".to_owned(), base().into());
    let axis: toml::Table =
        toml::from_str("name = 'period'\nfield = 'layer.period_um'\nvalues = [0.8, 0.81]").expect("an axis");
    sweep.insert("axis".to_owned(), toml::Value::Array(vec![axis.into()]));
    let file = folder.path().join("sweep.toml");
    std::fs::write(&file, toml::to_string(&sweep).expect("tables")).expect("a file");
    let out = folder.path().join("sweep");
    let mut inkwave = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
    inkwave.env_remove("SLURM_ARRAY_TASK_ID").arg("sweep").arg(&file).arg("--output").arg(&out);
    let done = inkwave.output().expect("the program starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    for variant in std::fs::read_dir(out.join("variants")).expect("variants") {
        let variant = variant.expect("a variant").path();
        let alone = folder.path().join("alone").join(variant.file_name().expect("a name"));
        succeed(&variant.join("study.toml"), &alone, &[]);
        for table in ["spectra.csv", "bdf.csv"] {
            let [shared, own] =
                [&variant, &alone].map(|of| std::fs::read_to_string(of.join(table)).expect("a table"));
            assert_eq!(shared, own, "{}", variant.display());
        }
    }
}

/// A field that is added to study files is added here.
#[test]
fn every_field_is_among_the_changes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.toml");
    std::fs::write(&path, BASE).expect("written");
    let (_, file) = read_file::<StudyFile>(&path).expect("a study file");
    let written = serde_json::to_value(file).expect("plain values");
    let mut fields = BTreeSet::new();
    for (table, value) in written.as_object().expect("tables") {
        let inside = value.as_object().or_else(|| value.get(0)?.as_object());
        match inside {
            Some(keys) => fields.extend(keys.keys().map(|key| format!("{table}.{key}"))),
            None => drop(fields.insert(table.clone())),
        }
    }
    let named = |path: &str| {
        path.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".")
    };
    let changed: BTreeSet<String> =
        CHANGES.iter().flat_map(|(edits, _)| edits.iter()).map(|edit| named(edit.0)).collect();
    let whole = |field: &String| {
        field.split_once('.').is_some_and(|(table, key)| {
            CHANGES
                .iter()
                .flat_map(|(edits, _)| edits.iter())
                .any(|(path, value)| *path == table && value.contains(&format!("{key} =")))
        })
    };
    let missing: Vec<&String> = fields
        .iter()
        .filter(|field| !changed.contains(*field) && !whole(field) && !ELSEWHERE.contains(&field.as_str()))
        .collect();
    assert!(missing.is_empty(), "no change tests {missing:?}");
}
