//! Plans answer soon, whatever is planned.

use crate::run_support::{TINY, command, run, study};
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Ten seconds are promised; tests share the machine.
const SOON: Duration = Duration::from_secs(20);

/// What the plan of a study says, in time.
fn plan(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let clock = Instant::now();
    let done = run(&study(folder.path(), text), &folder.path().join("out"), &["--plan"]);
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(clock.elapsed() < SOON, "{:?}: {said}", clock.elapsed());
    said
}

/// 20 µm of rutile: no trial ends in time.
fn rutile() -> String {
    let grid = "points_per_um = 20\nplanes_per_um = 40";
    let thick = TINY.replace("thickness_um = 0.5", "thickness_um = 20").replace("period_um = 0.8\n", "");
    thick.replace("{ built_in = \"yellow\" }", "2.6").replace(grid, "accuracy = 1e-2")
}

#[test]
fn needles_and_thick_layers_are_estimated_in_time() {
    let shape = "shape = { kind = \"cylinder\", length_in_radii = 8, spheres = 9 }\n\
                 size = { kind = \"constant\", value_nm = 2000, of = \"length\" }";
    let needles = TINY.replace("period_um = 0.8\nthickness_um = 0.5", "thickness_um = 2");
    let needles = needles.replace("diameter_nm = 200", shape);
    for text in [needles, rutile()] {
        let said = plan(&text);
        let value = |key: &str| said.lines().find(|line| line.starts_with(key)).map(str::to_owned);
        assert!(value("time").is_some() && value("memory").is_some(), "{said}");
    }
    assert!(plan(&rutile()).contains("no trial finished in time"));
}

#[test]
fn what_is_out_of_reach_is_told_by_the_plan_and_before_a_run() {
    let far = rutile().replace("thickness_um = 20", "thickness_um = 20\nperiod_um = 60");
    assert!(plan(&far).contains("out of reach: estimated"));
    let folder = tempfile::tempdir().unwrap();
    let mut started = command(&study(folder.path(), &far), &folder.path().join("out"), &[]);
    let mut child = started.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let told = lines.map_while(Result::ok).take(20).any(|line| line.contains("out of reach: estimated"));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(told, "before anything is packed");
}
