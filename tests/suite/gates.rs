//! Through the program itself: nothing unphysical, too large or endless passes, and nothing panics.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A command that takes longer does not end.
const PATIENCE: Duration = Duration::from_secs(120);

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.path(name), text).expect("a writable folder");
        self.path(name)
    }
}

fn inkwave(command: &str, path: &Path, options: &[&str]) -> Command {
    let mut inkwave = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    inkwave.arg(command).arg(path).args(options).stdin(Stdio::null());
    inkwave
}

/// Runs to the end, or fails the test when there is none.
fn output(mut command: Command) -> Output {
    let mut child =
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let clock = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if clock.elapsed() > PATIENCE {
            child.kill().expect("a child");
            panic!("{command:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.wait_with_output().expect("its output")
}

/// Standard error without the frame around it.
fn message(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '×', '╰', '─', '▶'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The program refuses, prints no result, and says every word.
fn refuses(command: Command, words: &[&str]) {
    let said = format!("{command:?}");
    let output = output(command);
    let message = message(&output);
    assert!(!output.status.success(), "accepted, but {words:?} was expected: {said}: {message}");
    assert_eq!(output.status.code(), Some(1), "{said}: {message}");
    assert!(output.stdout.is_empty(), "a refusal prints no result: {said}");
    for word in words {
        assert!(message.contains(word), "“{word}” is missing in: {message}");
    }
}

fn sphere(eta: [f64; 2]) -> Value {
    json!({
        "wavelength": 0.55, "L": 0.5, "H": 0.6, "eta_binder": [1.558, 0],
        "spheres": [{ "center": [0.2, 0.2, 0.3], "radius": 0.15, "eta": eta }]
    })
}

fn with(key: &str, value: Value) -> Value {
    let mut case = sphere([1.4, 0.1]);
    case[key] = value;
    case
}

const STUDY: &str = r#"
[layer]
period_um = 0.8
thickness_um = 0.5
binder.index = 1.558
[[pigment]]
name = "metal"
diameter_nm = 200
volume_fraction = 0.1
index = { n = 0.5, k = 7.0 }
[light]
wavelengths_nm = [450.0, 550.0]
[angles]
count = 3
[run]
realisations = 1
[resolution]
points_per_um = 12
planes_per_um = 24
[output]
picture_pixels = 61
"#;

#[test]
fn a_grid_that_makes_light_out_of_metal_gives_no_result() {
    let folder = Folder::new();
    let metal = folder.file("metal.json", &sphere([0.5, 7.0]).to_string());
    let unphysical = &["no result", "allowed is 0 … 1", "more points and cells"];
    for (points, cells) in [("6", "8"), ("8", "8"), ("12", "12")] {
        let solved = output(inkwave("solve", &metal, &["--nxy", points, "--nz", cells]));
        assert!(!solved.status.success() && solved.stdout.is_empty(), "{points}: {}", message(&solved));
    }
    refuses(inkwave("solve", &metal, &["--nxy", "6", "--nz", "8"]), unphysical);
    let study = folder.file("study.toml", STUDY);
    let out = folder.path("out");
    let run = output(inkwave("run", &study, &["--output", out.to_str().expect("UTF-8")]));
    assert!(!run.status.success(), "{}", message(&run));
    let results = std::fs::read_to_string(out.join("results.json")).unwrap_or_default();
    assert!(!results.contains("\"complete\""), "{results}");
}

#[test]
fn numbers_beyond_double_precision_give_no_result() {
    let folder = Folder::new();
    for (key, value) in [("wavelength", 1e200), ("wavelength", 1e-200), ("n_in", 1e-200), ("n_in", 1e200)] {
        let case = folder.file("case.json", &with(key, json!(value)).to_string());
        refuses(inkwave("solve", &case, &[]), &[]);
        let layers =
            json!({ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] });
        let mut film = layers;
        film[key] = json!(value);
        let film = folder.file("film.json", &film.to_string());
        let solved = output(inkwave("solve", &film, &[]));
        let text = String::from_utf8_lossy(&solved.stdout).into_owned();
        assert!(solved.status.success() != text.is_empty(), "{key} = {value}: {}", message(&solved));
        assert!(!text.contains("null"), "{key} = {value}: {text}");
        let out = folder.path("comparison");
        let compared = output(inkwave("compare", &film, &["--output", out.to_str().expect("UTF-8")]));
        let table = std::fs::read_to_string(out.join("comparison.csv")).unwrap_or_default();
        assert!(solved.status.success() || !table.contains("converged"), "{key} = {value}: {table}");
        assert!(solved.status.success() || !compared.status.success(), "{key} = {value}");
        let _ = std::fs::remove_dir_all(&out);
    }
}

#[test]
fn what_exceeds_the_memory_is_refused_before_it_is_built() {
    let folder = Folder::new();
    let case = folder.file("case.json", &sphere([1.4, 0.1]).to_string());
    let clock = Instant::now();
    for options in [
        &["--nxy", "3000", "--nz", "60", "--memory-gb", "0.1"][..],
        &["--nxy", "100000", "--nz", "100000"],
        &["--solver", "direct", "--nxy", "60", "--nz", "60", "--memory-gb", "0.1"],
    ] {
        refuses(inkwave("solve", &case, options), &["would need", "GB", "allowed"]);
    }
    for (key, value) in [("L", json!(1e12)), ("H", json!(1e12)), ("eta_binder", json!([1e9, 0]))] {
        let case = folder.file("wild.json", &with(key, value).to_string());
        // More points than any grid has, whatever the memory: the search ends before it asks for any.
        refuses(inkwave("solve", &case, &[]), &["would need", "check that the wavelength and all lengths"]);
    }
    let fine =
        STUDY.replace("= 12", "= 400").replace("= 24", "= 400").replace("0.8", "20").replace("0.5\n", "5\n");
    let study = folder.file("fine.toml", &fine);
    let out = folder.path("out");
    let options = ["--memory-gb", "4", "--output", out.to_str().expect("UTF-8")];
    refuses(inkwave("run", &study, &options), &["would need", "4.00 GB allowed"]);
    refuses(inkwave("run", &study, &["--memory-gb", "-1"]), &["--memory-gb is -1", "try 4"]);
    assert!(clock.elapsed() < PATIENCE, "nothing large was built");
}

#[test]
fn scarce_memory_shortens_the_basis_and_changes_nothing_else() {
    let folder = Folder::new();
    let case = folder.file("case.json", &sphere([1.4, 0.1]).to_string());
    let solve = |memory: &str| {
        let output = output(inkwave("solve", &case, &["--nxy", "16", "--nz", "12", "--memory-gb", memory]));
        assert!(output.status.success(), "{}", message(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("JSON")
    };
    let much = solve("4");
    let little = solve("0.012");
    let number = |v: &Value| v["R_total"].as_f64().expect("a number");
    assert!((number(&much) - number(&little)).abs() < 1e-5);
}

#[test]
fn overlap_of_unlike_bodies_and_lost_digits_are_refused() {
    let folder = Folder::new();
    let both = json!([{ "x": 0.3, "z": 0.3, "radius": 0.1, "eta": [1.4, 0] }]);
    let case = folder.file("case.json", &with("cylinders", both).to_string());
    refuses(
        inkwave("solve", &case, &[]),
        &["spheres[0] and cylinders[0]: found an overlap", "move them apart"],
    );
    let bars = json!({
        "wavelength": 0.55, "L": 0.6,
        "sublayers_from_z0": [{ "thickness": 0.4, "eta_background": [1.5, 0],
                                "bars": [{ "x0": 0.1, "x1": 0.3, "eta": [1.4, 0] }] }],
        "cylinders": [{ "x": 0.35, "z": 0.2, "radius": 0.1, "eta": [1.4, 0] }]
    });
    let case = folder.file("bars.json", &bars.to_string());
    refuses(inkwave("solve", &case, &[]), &["an overlap by 5.000e-2"]);
    let far = json!([{ "center": [1e15, 0.2, 0.3], "radius": 0.15, "eta": [1.4, 0.1] }]);
    let case = folder.file("far.json", &with("spheres", far).to_string());
    refuses(inkwave("solve", &case, &[]), &["1e15", "enough digits", "within the period"]);
}

#[test]
fn unusual_wavelengths_need_their_unit() {
    let folder = Folder::new();
    let film = |key: &str| {
        let mut case = json!({ "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] });
        case[key] = json!(550);
        folder.file("nm.json", &case.to_string())
    };
    refuses(
        inkwave("solve", &film("wavelength"), &[]),
        &["if you meant nm, write 0.55, or wavelength_nm = 550"],
    );
    for key in ["wavelength_um", "wavelength_nm"] {
        let solved = output(inkwave("solve", &film(key), &[]));
        assert!(solved.status.success(), "{key}: {}", message(&solved));
    }
}

#[test]
fn the_help_names_every_strategy() {
    let help = Command::new(env!("CARGO_BIN_EXE_inkwave")).args(["solve", "--help"]).output().expect("help");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    for name in inkwave::solve::SolverChoice::NAMES {
        assert!(help.contains(name), "{name} is missing: {help}");
    }
}

#[test]
fn names_and_long_lines_that_printers_stumble_over_are_told() {
    let folder = Folder::new();
    let film = json!({ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] });
    // "é" as two characters, and a control character.
    for (i, name) in ["cafe\u{301}.json", "bell\u{7}.json", "tab\t.json"].into_iter().enumerate() {
        let case = folder.file(name, &film.to_string());
        let out = folder.path(&format!("out{i}"));
        let compared = output(inkwave("compare", &case, &["--output", out.to_str().expect("UTF-8")]));
        assert!(compared.status.success(), "{name:?}: {}", message(&compared));
    }
    let long = format!("title = \"{}\" oops\n", "x".repeat(70_000));
    for (command, name) in [
        ("run", "long.toml"),
        ("sweep", "long.toml"),
        ("compare", "long.toml"),
        ("solve", "long.toml"),
        ("pack", "long.toml"),
    ] {
        refuses(inkwave(command, &folder.file(name, &long), &[]), &["line 1, column 700"]);
    }
    let wrong = format!("{STUDY}\n[paper]\nalbedo = 2 # {}\n", "x".repeat(70_000));
    refuses(inkwave("run", &folder.file("wrong.toml", &wrong), &[]), &["paper.albedo", "from 0 to 1"]);
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_an_error_and_a_closed_pipe_is_not() {
    let folder = Folder::new();
    let film = json!({ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] });
    let case = folder.file("case.json", &film.to_string());
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let done = inkwave("solve", &case, &[]).stdout(full).output().expect("the program starts");
    assert_eq!(done.status.code(), Some(1));
    assert!(message(&done).contains("cannot write to standard output"), "{}", message(&done));
    let mut child = inkwave("solve", &case, &[])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    drop(child.stdout.take());
    let done = child.wait_with_output().expect("it ends");
    assert!(!message(&done).contains("panicked"), "{}", message(&done));
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let done =
        inkwave("solve", &folder.file("none.json", "{"), &[]).stderr(full).output().expect("it starts");
    assert_eq!(done.status.code(), Some(1), "an error that cannot be printed is still an error");
}

#[cfg(target_os = "linux")]
#[test]
fn devices_and_pipes_are_no_input() {
    let folder = Folder::new();
    let pipe = folder.path("pipe.toml");
    let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
    assert!(made.success());
    for input in [Path::new("/dev/zero"), &pipe] {
        for command in ["run", "solve", "sweep", "compare", "pack"] {
            refuses(inkwave(command, input, &[]), &["not a regular file"]);
        }
        let text =
            STUDY.replace("{ n = 0.5, k = 7.0 }", &format!("{{ csv = {:?} }}", input.display().to_string()));
        refuses(
            inkwave("run", &folder.file("study.toml", &text), &[]),
            &["pigment[0].index.csv", "not a regular file"],
        );
        let paper = format!("{STUDY}\n[paper]\nalbedo = {{ csv = {:?} }}\n", input.display().to_string());
        refuses(
            inkwave("run", &folder.file("study.toml", &paper), &[]),
            &["paper.albedo.csv", "not a regular file"],
        );
    }
}

/// Every key has one name and one place.
#[test]
fn other_names_and_places_of_keys_are_unknown() {
    let folder = Folder::new();
    for (from, to, key) in [
        ("k = 7.0", "kappa = 7.0", "pigment[0].index.kappa"),
        ("binder.index = 1.558", "binder.index = 1.558\nindex_below = 1.3", "layer.index_below"),
        ("binder.index = 1.558", "binder.index = 1.558\nmethod = \"auto\"", "layer.method"),
    ] {
        assert!(STUDY.contains(from), "{from}");
        let study = folder.file("study.toml", &STUDY.replace(from, to));
        refuses(inkwave("run", &study, &[]), &[key, "unknown key"]);
    }
    let case = r#"{ "wavelength": 0.5, "n_below": 1.5, "from": "above",
        "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] }"#;
    refuses(inkwave("solve", &folder.file("case.json", case), &[]), &["n_below", "unknown key", "`above`"]);
}
