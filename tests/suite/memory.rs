//! The gate's bound against what the system measured: no solve takes more than was said before it was built, nor far less.
#![cfg(target_os = "linux")]

use inkwave::input::case::Case;
use inkwave::solve::Registry;
use inkwave::solve::Size;
use inkwave::wave::{Resolution, Scheme, Wave};
use serde_json::json;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Program, libraries and threads.
const PROGRAM: f64 = 60e6;

/// Largest bound over what is taken. A bound is for the most iterations that a strategy may store, of which a solve of this
/// size takes some, and the peak holds the program.
const MOST_TOO_MUCH: f64 = 8.0;

/// Largest resident memory of a program, looked at until it ends.
fn peak_bytes(mut command: Command) -> f64 {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    let mut peak = 0.0f64;
    while child.try_wait().expect("a child").is_none() {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|rest| rest.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
        peak = peak.max(1024.0 * kilobytes.unwrap_or(0.0));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(child.wait().expect("a child").success(), "{command:?}");
    peak
}

#[test]
fn no_solve_takes_more_than_its_bound() {
    let spheres: Vec<_> = (0..16)
        .map(|i| {
            json!({ "center": [0.25 + 0.5 * f64::from(i % 4), 0.25 + 0.5 * f64::from(i / 4), 0.4],
                         "radius": 0.2, "eta": [1.4, 0.0] })
        })
        .collect();
    let case = json!({ "wavelength": 0.5, "L": 2.0, "H": 0.8, "eta_binder": [1.558, 0], "spheres": spheres });
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.json");
    std::fs::write(&path, case.to_string()).expect("a writable folder");
    let case = Case::parse(&case.to_string(), false).expect("a case");
    let points = 40;
    let cells = 12;
    for name in ["krylov", "bicgstab", "idr", "born", "convergent_born", "relaxation"] {
        let mut solve = Command::new(env!("CARGO_BIN_EXE_inkwave"));
        solve.arg("solve").arg(&path).args([
            "--nxy",
            "40",
            "--nz",
            "12",
            "--tolerance",
            "1e-3",
            "--solver",
            name,
        ]);
        // One companion is finer along each axis at most: a fifth more cells, or points.
        let resolution = Resolution { nx: points, ny: points, cells, scheme: Scheme::Cubic };
        if name == "relaxation" {
            solve.arg("--real-mean");
        }
        let solver = Registry::default().build(name).expect("a name");
        let size = Size::new(Wave::Scalar, &case.scene, &case.media, 0.5, resolution);
        let bound = size.bytes(&*solver);
        let peak = peak_bytes(solve);
        let held = size.problem() + size.fields(2.0);
        println!("{name}: bound {:.0} MB, peak {:.0} MB", 1e-6 * bound, 1e-6 * peak);
        assert!(peak < bound + held + PROGRAM, "{name}: bound {bound:.2e}, peak {peak:.2e}");
        // *Planted*: a bound ten times too large, which refuses solves that would fit.
        assert!(bound < MOST_TOO_MUCH * peak, "{name}: bound {bound:.2e}, peak {peak:.2e}");
    }
}
