//! Plans answer soon, whatever is planned.

use crate::run_support::{TINY, command, run, study, succeed};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Ten seconds are promised on an idle machine, three times as long on a busy one, which tests share.
const SOON: Duration = Duration::from_secs(40);

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
    let plans = [plan(&needles), plan(&rutile())];
    for plan in &plans {
        let has = |key: &str| plan.lines().any(|line| line.starts_with(key));
        assert!(has("time") && has("memory"), "{plan}");
    }
    assert!(plans[1].contains("no trial finished in time"), "{}", plans[1]);
}

#[test]
fn the_plan_and_a_run_say_what_is_out_of_reach() {
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

/// Core seconds that a plan forecasts, with the range that it states.
fn forecast(file: &Path, folder: &Path) -> [f64; 3] {
    let done = run(file, folder, &["--plan", "--json", "--jobs", "1"]);
    let plan: serde_json::Value = serde_json::from_slice(&done.stdout).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let range = &plan["core_seconds_range"];
    [number(&plan["core_seconds"]), number(&range[0]), number(&range[1])]
}

/// Processor seconds that a run says it has taken, with one solve at a time.
fn taken(file: &Path, output: &Path) -> f64 {
    succeed(file, output, &["--jobs", "1"]);
    let results = std::fs::read(output.join("results.json")).unwrap();
    let results: serde_json::Value = serde_json::from_slice(&results).unwrap();
    results["process_seconds"].as_f64().expect("seconds of the process")
}

/// What a run takes lies in the range that its plan states, on a loaded machine too: both count the processor's time.
/// *Planted*: seconds by the clock on the wall while other programs work; a forecast 100 times too long or too short.
#[test]
fn a_forecast_is_neither_far_too_long_nor_far_too_short() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("realisations = 2", "realisations = 24").replace("step_nm = 100", "step_nm = 50");
    let file = study(folder.path(), &text);
    let output = folder.path().join("out");
    let [seconds, least, most] = forecast(&file, &output);
    assert!(least < seconds && seconds < most && most / least < 10.0, "{least} {seconds} {most}");
    let taken = taken(&file, &output);
    // 504 solves: enough for reading, packing and drawing to be small beside them
    assert!((least..most).contains(&taken), "{taken} s of {least} to {most}");
}
