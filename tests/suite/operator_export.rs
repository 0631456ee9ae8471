//! `inkwave solve --export-operator`, and the script that applies the operator without inkwave.

use std::path::Path;
use std::process::{Command, Output};

const CASE: &str = r#"{ "wavelength": 0.55, "sigma_deg": 25, "phi_deg": 30, "L": [0.5, 0.6], "H": 0.4, "n_out": 1.5,
    "eta_binder": [1.558, 0], "spheres": [{ "center": [0.2, 0.3, 0.2], "radius": 0.15, "eta": [1.8, 0.1] }] }"#;

fn solve(folder: &Path, options: &[&str]) -> Output {
    std::fs::write(folder.join("case.json"), CASE).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.current_dir(folder).args(["solve", "case.json", "--export-operator", "operator.npz"]);
    command.args(options).output().expect("started")
}

fn python(arguments: &[&Path]) -> Output {
    Command::new("python3").args(arguments).output().expect("python3")
}

/// Identity: the script's residual is the solver's, to the rounding of both (1e-12 of the wave), for the exact elements of
/// every degree, folded terms included, and for second differences.
#[test]
fn a_script_without_inkwave_reproduces_the_residual() {
    let folder = tempfile::tempdir().expect("a folder");
    if !Command::new("python3").args(["-c", "import numpy"]).output().is_ok_and(|done| done.status.success())
    {
        eprintln!("skipped: python3 has no numpy");
        return;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/apply_operator.py");
    for scheme in ["tents", "quadratic", "cubic", "quartic", "second-difference"] {
        let grid = ["--nxy", "9", "--nz", "5", "--tolerance", "1e-5", "--scheme", scheme];
        let done = solve(folder.path(), &grid);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let applied = python(&[&script, &folder.path().join("operator.npz")]);
        let text = String::from_utf8_lossy(&applied.stdout).into_owned();
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [script, solver] = numbers[..] else { panic!("{scheme}: {applied:?}") };
        assert!((script - solver).abs() < 1e-12 && solver > 1e-9, "{scheme}: {script:e} and {solver:e}");
    }
}

#[test]
fn the_operator_is_written_for_the_scalar_wave_only() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = solve(folder.path(), &["--wave", "vector"]);
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && told.contains("--export-operator"), "{told}");
    let written = solve(folder.path(), &["--accuracy", "1e-2"]);
    assert!(written.status.success());
    let bytes = std::fs::read(folder.path().join("operator.npz")).expect("written");
    let mut npz = ndarray_npy::NpzReader::new(std::io::Cursor::new(bytes)).expect("an archive");
    let names = npz.names().expect("names");
    for name in ["nodes_um", "mean_k2", "contrasts", "moments", "source", "solution", "residual"] {
        assert!(names.iter().any(|n| n.trim_end_matches(".npy") == name), "{name} of {names:?}");
    }
}
