//! Every example through every command that it makes sense for, as far as each command goes without solving: plans, packings of one
//! realisation, and for what a command cannot do a reason.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;

/// Kind of an example, from its first line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Study,
    Sweep,
    Compare,
    Case,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")
}

fn examples() -> Vec<(String, Kind)> {
    let files = std::fs::read_dir(folder()).expect("examples");
    let names = files.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut all: Vec<_> =
        names.filter(|name| name.ends_with(".toml")).map(|name| (name.clone(), kind(&name))).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

fn kind(name: &str) -> Kind {
    let text = std::fs::read_to_string(folder().join(name)).expect("readable");
    let line = text.lines().find(|line| line.starts_with("#:schema")).expect("a line #:schema");
    match line.rsplit('/').next() {
        Some("study.json") => Kind::Study,
        Some("sweep.json") => Kind::Sweep,
        Some("compare.json") => Kind::Compare,
        Some("case.json") => Kind::Case,
        other => panic!("{name}: {other:?}"),
    }
}

fn inkwave(args: &[&str], here: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inkwave")).args(args).current_dir(here).output().expect("started")
}

/// Smaller cells and fewer realisations for examples whose plans and packings would take most of the time.
const LIGHTER: [(&str, &str, &str); 14] = [
    ("pack-dense-spheres.toml", "period_um = [10.0, 10.0]", "period_um = 1.5"),
    ("pack-cylinders.toml", "period_um = [6.0, 6.0]", "period_um = 1.6"),
    ("composed-small.toml", "period_um = 1.2", "period_um = 0.8"),
    ("crowding.toml", "period_um = 1.2", "period_um = 0.8"),
    ("primer.toml", "period_um = 1.2", "period_um = 0.8"),
    ("primer.toml", "points_per_um = 20", "points_per_um = 12"),
    ("white-paint.toml", "slab_um = 1.0", "slab_um = 0.5"),
    ("paper-study.toml", "realisations = 96", "realisations = 8"),
    ("pack-mixture.toml", "period_um = [5.0, 5.0]", "period_um = 2.0"),
    ("pack-periodic-fluid.toml", "sweeps = 250", "sweeps = 50"),
    ("scalar-against-vector.toml", "period_um = 1.6", "period_um = 1.0"),
    ("mica.toml", "points_per_um = 20", "points_per_um = 12"),
    ("coats.toml", "accuracy = 1e-1", "accuracy = 3e-1"),
    ("paper-study-errors.toml", "2e-3", "1e-2"),
];

/// What a command says about an example, or about a lighter one: success, or the error.
fn outcome(command: &[&str], name: &str) -> Result<String, String> {
    let scratch = tempfile::tempdir().expect("a folder");
    let mut text = std::fs::read_to_string(folder().join(name)).expect("readable");
    for (_, from, to) in LIGHTER.into_iter().filter(|(example, ..)| *example == name) {
        assert!(text.contains(from), "{name} has no {from}");
        text = text.replace(from, to);
    }
    std::fs::write(scratch.path().join(name), text).expect("written");
    if name != "yellow.toml" {
        std::fs::copy(folder().join("yellow.toml"), scratch.path().join("yellow.toml")).expect("copied");
    }
    for data in ["positions.csv", "cut.npy"] {
        std::fs::copy(folder().join(data), scratch.path().join(data)).expect("copied");
    }
    let mut args = vec![command[0], name];
    args.extend(&command[1..]);
    let output = inkwave(&args, scratch.path());
    let printed = if output.status.success() { Ok(output.stdout) } else { Err(output.stderr) };
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    printed.map(text).map_err(text)
}

/// The layers without walls are for packings alone.
fn is_for_packings(name: &str) -> bool {
    std::fs::read_to_string(folder().join(name)).expect("readable").contains("walls = false")
}

/// Strategies are compared for the scalar wave alone.
fn is_vector(name: &str) -> bool {
    std::fs::read_to_string(folder().join(name)).expect("readable").contains("wave = \"unpolarised\"")
}

fn pack(name: &str) -> Result<String, String> {
    outcome(&["pack", "--realisations", "1", "--output", "packed"], name)
}

/// Examples whose grains are those of another one: their plans pack them, and their pages of packings show nothing new.
const PACKED_LIKE_OTHERS: [&str; 9] = [
    "brightened-paper.toml",
    "coats.toml",
    "composed-small.toml",
    "halftone.toml",
    "primer.toml",
    "production.toml",
    "varnish.toml",
    "white-paint.toml",
    "yellow-full.toml",
];

/// Commands that take the example.
fn taken(name: &str, kind: Kind) -> Vec<(&'static str, Result<String, String>)> {
    let mut all = tried(name, kind);
    if !PACKED_LIKE_OTHERS.contains(&name) && kind == Kind::Study {
        all.push(("pack", pack(name)));
    }
    all
}

/// The commands but `pack`.
fn tried(name: &str, kind: Kind) -> Vec<(&'static str, Result<String, String>)> {
    match kind {
        Kind::Study if is_for_packings(name) => Vec::new(),
        Kind::Study if is_vector(name) => vec![("run", outcome(&["run", "--plan"], name))],
        Kind::Study => vec![
            ("run", outcome(&["run", "--plan"], name)),
            ("compare", outcome(&["compare", "--plan"], name)),
        ],
        Kind::Sweep => vec![("sweep", outcome(&["sweep", "--plan"], name))],
        Kind::Compare => vec![("compare", outcome(&["compare", "--plan"], name))],
        Kind::Case => vec![("solve", outcome(&["solve", "--nxy", "5", "--nz", "6"], name))],
    }
}

/// Commands that refuse it, and a word of the reason.
fn refused(name: &str, kind: Kind) -> Vec<(&'static str, Result<String, String>, &'static str)> {
    match kind {
        Kind::Study if is_for_packings(name) => vec![
            ("run", outcome(&["run", "--plan"], name), "walls"),
            ("compare", outcome(&["compare", "--plan"], name), "walls"),
        ],
        Kind::Study => {
            let mut all = vec![("sweep", outcome(&["sweep", "--plan"], name), "inkwave run")];
            all.extend(is_vector(name).then(|| ("compare", outcome(&["compare", "--plan"], name), "scalar")));
            all
        }
        Kind::Sweep => vec![("run", outcome(&["run", "--plan"], name), "inkwave sweep")],
        Kind::Compare => vec![("run", outcome(&["run", "--plan"], name), "layer")],
        Kind::Case => vec![("run", outcome(&["run", "--plan"], name), "inkwave solve")],
    }
}

#[test]
fn every_example_goes_through_every_command_it_is_for() {
    let all = examples();
    for kind in [Kind::Study, Kind::Sweep, Kind::Compare] {
        assert!(all.iter().filter(|example| example.1 == kind).count() >= 3, "{kind:?}");
    }
    let wrong = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for half in all.chunks(all.len().div_ceil(2)) {
            let wrong = &wrong;
            scope.spawn(move || {
                for (name, kind) in half {
                    for (command, said) in taken(name, *kind) {
                        if let Err(error) = said {
                            wrong.lock().expect("no panic").push(format!("{command} {name}: {error}"));
                        }
                    }
                    for (command, said, word) in refused(name, *kind) {
                        if !said.as_ref().is_err_and(|error| error.contains(word)) {
                            wrong
                                .lock()
                                .expect("no panic")
                                .push(format!("{command} {name} should tell of {word}: {said:?}"));
                        }
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().expect("no panic");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A comparison that names a study file and one that holds the same study have the same rows.
#[test]
fn a_study_is_the_same_wherever_it_is_written() {
    let scratch = tempfile::tempdir().expect("a folder");
    let study = "layer = { cell = 'fixed', period_um = 0.5, thickness_um = 0.4 }\n\
        [[pigment]]\ndiameter_nm = 200\nvolume_fraction = 0.1\nindex = 1.4\n\
        [light]\nwavelengths_nm = [500, 600]\n[angles]\npolar_deg = [0]\n[run]\nseed = 3\n";
    let inner = study.replace("layer =", "study.layer =").replace("[[pigment]]", "[[study.pigment]]");
    let inner = inner
        .replace("[light]", "[study.light]")
        .replace("[angles]", "[study.angles]")
        .replace("[run]", "[study.run]");
    let lists = "strategies = ['krylov', 'born']\nresolutions = [{ points = 5, cells = 4 }]\nrepeats = 1\n";
    let mut tables = Vec::new();
    for (name, text) in [
        ("study.toml", study.to_owned()),
        ("by-name.toml", format!("{lists}study = 'study.toml'\n")),
        ("inside.toml", format!("{lists}{inner}")),
    ] {
        std::fs::write(scratch.path().join(name), text).expect("written");
        if name == "study.toml" {
            continue;
        }
        let output = inkwave(&["compare", name, "--output", name.trim_end_matches(".toml")], scratch.path());
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let table = scratch.path().join(name.trim_end_matches(".toml")).join("comparison.csv");
        let mut rows = csv::Reader::from_path(table).expect("a table");
        let column =
            rows.headers().expect("a header").iter().position(|name| name == "error").expect("errors");
        let errors: Vec<String> = rows.records().map(|row| row.expect("a row")[column].to_owned()).collect();
        assert!(errors.len() == 4 && errors.iter().all(|error| error.parse::<f64>().is_ok()), "{errors:?}");
        tables.push(errors);
    }
    assert!(tables.windows(2).all(|pair| pair[0] == pair[1]), "{tables:?}");
}
