//! `inkwave solve` from outside: what a good run prints, and how bad input is refused.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("a writable folder");
        path
    }
}

pub fn inkwave(path: &Path, options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    command.arg("solve").arg(path).args(options).output().expect("the program starts")
}

/// Standard error without the frame that the terminal report draws around it.
pub fn message(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).replace(['│', '×', '╰', '─', '▶'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A good case: one absorbing sphere in a binder.
pub fn good() -> Value {
    json!({
        "wavelength": 0.55, "sigma_deg": 20, "L": 0.5, "H": 0.6, "eta_binder": [1.558, 0],
        "spheres": [{ "center": [0.2, 0.2, 0.3], "radius": 0.15, "eta": [1.4, 0.1] }]
    })
}

/// The good case with one value changed (at a JSON pointer) or added (a key at the top).
fn with(pointer: &str, value: Value) -> String {
    let mut case = good();
    match case.pointer_mut(pointer) {
        Some(place) => *place = value,
        None => case[&pointer[1..]] = value,
    }
    case.to_string()
}

/// The program refuses the text, and its message holds every word.
fn refuses_text(name: &str, text: &str, options: &[&str], words: &[&str]) {
    let folder = Folder::new();
    refuses(&folder.file(name, text), options, words);
}

fn refuses(path: &Path, options: &[&str], words: &[&str]) {
    let output = inkwave(path, options);
    let message = message(&output);
    assert!(!output.status.success(), "accepted, but {words:?} was expected: {message}");
    assert!(output.stdout.is_empty(), "a refusal prints no result");
    for word in words {
        assert!(message.contains(word), "“{word}” is missing in: {message}");
    }
}

#[test]
fn numbers_out_of_range_name_field_value_range_and_remedy() {
    let sphere = |x: f64, z: f64, r: f64| json!({ "center": [x, 0.2, z], "radius": r, "eta": [1.4, 0.1] });
    for (pointer, value, words) in [
        ("/wavelength", json!(0), ["wavelength: found 0", "from 0.1 to 20 µm", "give it in µm"]),
        ("/wavelength", json!(-0.5), ["wavelength: found -0.5", "from 0.1 to 20 µm", "give it in µm"]),
        ("/wavelength", json!(550), ["found 550", "from 0.1 to 20 µm", "write 0.55, or wavelength_nm = 550"]),
        (
            "/wavelength_nm",
            json!(550),
            ["wavelength: found wavelength and wavelength_nm", "one of", "give one"],
        ),
        ("/sigma_deg", json!(90), ["sigma_deg: found 90", "from 0 to below 90°", "use 89 or less"]),
        ("/L", json!(0), ["L: found 0", "greater than 0", "give it in µm"]),
        ("/H", json!(-1), ["H: found -1", "greater than 0", "give it in µm"]),
        ("/spheres/0/radius", json!(-0.1), ["spheres[0].radius: found -0.1", "greater than 0", "µm"]),
        (
            "/spheres/0/eta",
            json!([1.4, -0.1]),
            ["spheres[0].eta (absorption): found -0.1", "from 0", "change the sign"],
        ),
        ("/eta_binder", json!([0, 0]), ["eta_binder: found 0", "other than 0", "[real part, absorption]"]),
        ("/n_in", json!(-1), ["n_in (real part): found -1", "from 0", "positive"]),
        ("/spheres/0", sphere(0.2, 0.1, 0.15), ["spheres[0]", "from z = -0.05", "0 … 0.6 µm, the layer"]),
        ("/spheres/0", sphere(0.2, 0.3, 0.28), ["own periodic image", "6.000e-2", "period L larger"]),
        (
            "/spheres",
            json!([sphere(0.1, 0.3, 0.1), sphere(0.2, 0.3, 0.1)]),
            ["spheres[0] and spheres[1]", "1.000e-1", "apart"],
        ),
        ("/eta_in", json!([1, 0]), ["n_in", "and eta_in", "one of them"]),
    ] {
        let mut text = with(pointer, value);
        if pointer == "/eta_in" {
            text = text.replacen('{', "{\"n_in\": 1.0, ", 1);
        }
        refuses_text("case.json", &text, &[], &words);
    }
}

#[test]
fn numbers_that_are_none_are_refused_in_json_and_toml() {
    let text = good().to_string().replace("0.15", "NaN");
    refuses_text("case.json", &text, &[], &["NaN nor Infinity", "finite numbers"]);
    let twice = good().to_string().replacen("\"H\":0.6", "\"H\":0.6,\"H\":0.7", 1);
    refuses_text("case.json", &twice, &[], &["the key \"H\" occurs twice", "remove one of them"]);
    let toml = "wavelength = 0.55\nL = 0.5\nH = 0.6\neta_binder = [1.558, 0.0]\n\n[[spheres]]\n";
    let sphere = "center = [0.2, 0.2, 0.3]\nradius = nan\neta = [1.4, 0.1]\n";
    refuses_text(
        "case.toml",
        &format!("{toml}{sphere}"),
        &[],
        &["spheres[0].radius: found NaN", "finite and greater than 0"],
    );
    let center = sphere.replace("nan", "0.1").replace("[0.2,", "[inf,");
    refuses_text(
        "case.toml",
        &format!("{toml}{center}"),
        &[],
        &["spheres[0].center[0]: found inf", "finite"],
    );
}

/// The same film by three keys; a film of 300 nm typed as µm is solved, and said. *Planted*: nm taken for µm.
#[test]
fn lengths_say_their_unit_or_are_remarked_on() {
    let solve = |light: Value, thickness: f64| -> (Value, String) {
        let mut case = json!({ "layers_from_z0": [{ "thickness": thickness, "eta": [1.5, 0] }] });
        let own = case.as_object_mut().expect("an object");
        own.extend(light.as_object().expect("an object").clone());
        let folder = Folder::new();
        let output = inkwave(&folder.file("case.json", &case.to_string()), &[]);
        (serde_json::from_slice(&output.stdout).unwrap_or_default(), message(&output))
    };
    let (usual, said) = solve(json!({ "wavelength": 0.55 }), 0.3);
    assert!(usual["remarks"].is_null() && !said.contains("warning"), "{said}");
    for light in [json!({ "wavelength_nm": 550 }), json!({ "wavelength_um": 0.55 })] {
        let (own, _) = solve(light, 0.3);
        let apart = own["R_total"].as_f64().expect("R") - usual["R_total"].as_f64().expect("R");
        // rounding of nm to µm
        assert!(apart.abs() < 1e-13, "{own}");
    }
    let (long, said) = solve(json!({ "wavelength": 0.55 }), 300.0);
    let remark = "layers_from_z0[0].thickness is 300 µm: lengths are in µm; if it is in nm, write 0.3";
    assert!(long["remarks"][0] == remark && said.contains(remark), "{said}");
    // radio waves, on purpose
    let (radio, _) = solve(json!({ "wavelength_um": 5500 }), 3000.0);
    assert!((radio["R_total"].as_f64().expect("R") - 0.0).abs() < 1.0);
}

/// Which key is which polarisation: the power of s light that leaves, as s and as p, is the efficiency of incident s
/// light; with a tilted body the cross-polarised parts differ. *Planted*: rows and columns exchanged.
#[test]
fn polarised_amplitudes_are_by_incident_then_by_outgoing_polarisation() {
    let case = json!({
        "wavelength": 0.55, "sigma_deg": 30, "phi_deg": 20, "L": 0.5, "H": 0.5, "eta_binder": [1.5, 0],
        "bodies": [{ "shape": { "kind": "box", "edges": [0.1, 0.3, 0.15] }, "center": [0.25, 0.25, 0.25],
                     "axis": [0.3, 0.2, 1.0], "eta": [2.2, 0.1] }]
    });
    let folder = Folder::new();
    let path = folder.file("case.json", &case.to_string());
    let output = inkwave(&path, &["--wave", "vector", "--nxy", "10", "--nz", "6"]);
    let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(result["polarisations"].as_str().is_some_and(|words| words.contains("R.s.p")), "{result}");
    let orders = result["orders"].as_array().expect("orders");
    let specular = orders.iter().find(|order| order["m"] == 0 && order["n"] == 0).expect("order (0, 0)");
    let power = |incident: &str, outgoing: &str| -> f64 {
        let pair = specular["R"][incident][outgoing].as_array().expect("[re, im]");
        pair.iter().map(|x| x.as_f64().expect("a number").powi(2)).sum()
    };
    for light in ["s", "p"] {
        let efficiency = specular["eff_R"][light].as_f64().expect("a number");
        let sum = power(light, "s") + power(light, "p");
        // identity: the specular order leaves at the angle of incidence
        assert!((sum - efficiency).abs() < 1e-12, "{light}: {sum} {efficiency}");
    }
    let apart = (power("s", "p") - power("p", "s")).abs();
    assert!(apart > 1e-3 * power("s", "p"), "the check is empty: {apart}");
}

#[test]
fn entries_that_do_not_fit_are_named_with_their_place() {
    for (text, words) in [
        (with("/colour", json!("red")), vec!["colour: found an unknown key", "`wavelength`", "remove it"]),
        (
            with("/spheres/0/radius", json!(null)),
            vec!["spheres[0].radius: found null", "a number", "in that form"],
        ),
        (with("/spheres/0/radius", json!("big")), vec!["spheres[0].radius", "\"big\"", "in that form"]),
        (
            with("/spheres/0/center", json!([1, 2])),
            vec!["spheres[0].center", "2 entries", "array of length 3"],
        ),
        (with("/layers_from_z0", json!([])), vec!["eta_binder", "layers_from_z0", "in one way"]),
        (json!({ "wavelength": 0.5 }).to_string(), vec!["eta_binder", "layers_from_z0", "in one way"]),
        (
            json!({ "L": 0.5 }).to_string(),
            vec!["wavelength: found nothing", "`wavelength_um` and `wavelength_nm`"],
        ),
        (
            json!({ "wavelength": 0.5, "eta_binder": [1.5, 0] }).to_string(),
            vec!["H: found nothing", "thickness in µm"],
        ),
        ("{ \"wavelength\": ".into(), vec!["is not a case", "EOF", "correct the JSON"]),
        (String::new(), vec!["is not a case", "correct the JSON"]),
    ] {
        refuses_text("case.json", &text, &[], &words);
    }
}

/// Grains repeat with a period that only the file knows; films have none.
#[test]
fn a_period_is_asked_for_where_grains_repeat_with_it() {
    let mut case = good();
    case.as_object_mut().unwrap().remove("L");
    refuses_text(
        "case.json",
        &case.to_string(),
        &[],
        &["L: found nothing", "period of the grains or bars in µm"],
    );
    let bars = json!({
        "wavelength": 0.55,
        "sublayers_from_z0": [{ "thickness": 0.3, "eta_background": [1.5, 0], "bars": [{ "x0": 0, "x1": 0.2, "eta": [1.7, 0] }] }]
    });
    refuses_text("case.json", &bars.to_string(), &[], &["L: found nothing"]);
    let film = json!({ "wavelength": 0.55, "layers_from_z0": [{ "thickness": 0.3, "eta": [1.5, 0] }] });
    let [plain, wide] = [film.to_string(), film.to_string().replacen('{', "{\"L\": 3,", 1)];
    let totals = [plain, wide].map(|text| solved(&text, "film.json", &[])["R_total"].as_f64().unwrap());
    // an identity; rounding of one order
    assert!((totals[0] - totals[1]).abs() < 1e-12, "{totals:?}");
}

#[test]
fn both_a_binder_and_layers_are_one_too_many() {
    let text = with("/layers_from_z0", json!([{ "thickness": 0.6, "eta": [1.5, 0] }]));
    refuses_text("case.json", &text, &[], &["exactly one of `eta_binder`, `layers_from_z0`", "in one way"]);
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = Folder::new();
    let absent = folder.0.path().join("absent.json");
    refuses(&absent, &[], &["cannot read", "absent.json", "check the path"]);
    refuses(folder.0.path(), &[], &["cannot read", "check the path"]);
}

#[test]
fn options_out_of_range_are_told_what_to_try() {
    let text = good().to_string();
    for (options, words) in [
        (&["--accuracy", "0"][..], &["accuracy is 0", "1e-9 … 0.5"][..]),
        (&["--accuracy", "-1"], &["accuracy is -1", "1e-9 … 0.5"]),
        (&["--accuracy", "nan"], &["accuracy is NaN", "1e-9 … 0.5"]),
        (&["--accuracy", "1e-3", "--nz", "9"], &["--accuracy", "cannot be used with", "--nz"]),
        (&["--tolerance", "0"], &["--tolerance is 0", "try 1e-6"]),
        (&["--tolerance", "-1"], &["--tolerance is -1", "try 1e-6"]),
        (&["--memory-gb", "0"], &["--memory-gb is 0", "try 4"]),
        (&["--solver", "magic"], &["magic", "--solver", "krylov, bicgstab", "direct"]),
        (&["--nxy", "12"], &["--nz"]),
        (&["--nz", "12"], &["--nxy is missing", "--accuracy 1e-3"]),
        (&["--nxy", "0", "--nz", "9"], &["nx is 0", "1 … 100000"]),
        (&["--nxy", "12", "--nz", "0"], &["nz (cells) is 0", "1 … 100000"]),
        (&["--nxy", "12", "--nz", "2"], &["phase", "use at least 4 cells"]),
        (&["--nxy", "1", "--nz", "9"], &["too coarse", "use at least 3 points"]),
        (&["--scheme", "magic"], &["magic", "second-difference"]),
        (&["--illuminated-um", "0"], &["illuminated_um", "is 0", "0.5 … 550 µm", "ten periods, 5 µm"]),
        (&["--illuminated-um", "-3"], &["illuminated_um", "is -3", "0.5 … 550 µm"]),
        (&["--illuminated-um", "nan"], &["illuminated_um", "is NaN", "0.5 … 550 µm"]),
        (&["--illuminated-um", "0.4"], &["illuminated_um", "is 0.4", "one period"]),
        (&["--illuminated-um", "5", "--illuminated-step-deg", "0"], &["step-deg is 0", "0.5 … 45", "try 5"]),
        (&["--illuminated-step-deg", "5"], &["--illuminated-um"]),
        (
            &["--illuminated-um", "5", "--wave", "vector"],
            &["--illuminated-um", "scalar wave", "leave it out"],
        ),
        (&["--export-operator", "x.npz", "--wave", "vector"], &["--export-operator", "--wave scalar"]),
        (&["--realisation", "1"], &["is a case", "reads a study", "inkwave solve"]),
        (
            &["--accuracy", "1e-8", "--memory-gb", "0.01"],
            &["is not reached", "10.0 MB", "ask for less accuracy"],
        ),
    ] {
        refuses_text("case.json", &text, options, words);
    }
}

/// Keys of a case beside its `inputs` would have no effect; a study is not a case.
#[test]
fn what_is_no_case_is_refused_with_a_remedy() {
    let beside = json!({ "kind": "spheres3d", "inputs": good(), "wavelength": 0.6 }).to_string();
    refuses_text("case.json", &beside, &[], &["wavelength: found given beside `inputs`", "move it"]);
    let study = "[layer]\nthickness_um = 1\n";
    refuses_text("study.toml", study, &[], &["is a study", "reads a case", "--realisation 1"]);
}

#[test]
fn a_diverging_series_says_what_to_use_instead() {
    let strong = with("/spheres/0/eta", json!([4.0, 0]));
    refuses_text(
        "case.json",
        &strong,
        &["--solver", "born", "--nxy", "12", "--nz", "12"],
        &["born diverges", "krylov"],
    );
}

pub fn solved(text: &str, name: &str, options: &[&str]) -> Value {
    let folder = Folder::new();
    let output = inkwave(&folder.file(name, text), options);
    assert!(output.status.success(), "{}", message(&output));
    assert!(output.stderr.is_empty(), "nothing but the result without a terminal: {}", message(&output));
    serde_json::from_slice(&output.stdout).expect("standard output is JSON")
}

const KEYS: [&str; 23] = [
    "wave",
    "wavelength_nm",
    "polar_deg",
    "azimuth_deg",
    "orders",
    "R_total",
    "T_total",
    "A_total",
    "error_estimate",
    "error_estimate_parts",
    "energy_error",
    "solver",
    "residual",
    "steps",
    "operator_applications",
    "seconds",
    "seconds_setup",
    "seconds_estimate",
    "unknowns",
    "bytes",
    "resolution",
    "version",
    "polarisations",
];

#[test]
fn a_good_run_prints_every_documented_key() {
    let result = solved(&good().to_string(), "case.json", &["--accuracy", "1e-2"]);
    for key in KEYS {
        assert!(!result[key].is_null(), "{key} is missing");
    }
    let light = ["wavelength_nm", "polar_deg", "azimuth_deg"].map(|key| result[key].as_f64());
    assert_eq!(light, [Some(550.0), Some(20.0), Some(0.0)]);
    let number = |value: &Value| value.as_f64().expect("a number");
    // Identity: the printed totals balance to ten residuals.
    let total: f64 = ["R_total", "T_total", "A_total"].iter().map(|k| number(&result[*k])).sum();
    assert!((total - 1.0).abs() <= 10.0 * number(&result["residual"]), "{total}");
    assert!(number(&result["error_estimate"]) <= 1e-2);
    let orders = result["orders"].as_array().expect("a list of orders");
    for order in orders {
        for key in ["m", "n", "propagating", "R", "T", "eff_R", "eff_T"] {
            assert!(!order[key].is_null(), "{key} is missing in {order}");
        }
        assert_eq!(order["R"].as_array().map(Vec::len), Some(2), "amplitudes are [re, im]");
    }
    let sum = |key: &str| orders.iter().map(|o| number(&o[key])).sum::<f64>();
    assert!((sum("eff_R") - number(&result["R_total"])).abs() < 1e-14, "totals are sums over orders");
    for key in ["nx", "ny", "cells", "planes", "scheme", "points_per_um", "planes_per_um"] {
        assert!(!result["resolution"][key].is_null(), "{key} is missing in the resolution");
    }
}

/// A list of directions from both sides prints for each what a single case prints on the same grid,
/// digit for digit. *Planted*: the case's side for all.
#[test]
fn listed_directions_print_what_single_cases_print() {
    let directions = json!([
        { "sigma_deg": 0 }, { "phi_deg": 70 }, { "sigma_deg": 55, "phi_deg": 10, "from": "exit" }, { "from": "exit" }
    ]);
    for wave in ["scalar", "vector"] {
        let mut listed = good();
        listed["directions"] = directions.clone();
        let options = ["--wave", wave, "--nxy", "10", "--nz", "8"];
        let all = solved(&listed.to_string(), "case.json", &options);
        assert_eq!(all["compared"], json!([0, 1, 2, 3]), "the steepest and the flattest of both sides");
        let solves = all["solves"].as_array().expect("a list");
        assert_eq!(solves.len(), 4);
        let mut largest = json!({ "plane": 0.0, "z": 0.0 });
        let sum = |parts: &Value| ["plane", "z"].iter().filter_map(|key| parts[key].as_f64()).sum::<f64>();
        for (solve, direction) in solves.iter().zip(directions.as_array().expect("a list")) {
            let mut single = good();
            let keys = single.as_object_mut().expect("an object");
            keys.extend(direction.as_object().expect("an object").clone());
            let single = solved(&single.to_string(), "case.json", &options);
            for key in [
                "orders",
                "R_total",
                "T_total",
                "A_total",
                "polar_deg",
                "azimuth_deg",
                "residual",
                "resolution",
            ] {
                assert_eq!(solve[key], single[key], "{wave}, {direction}: {key}");
            }
            let parts = &single["error_estimate_parts"];
            largest = if sum(parts) > sum(&largest) { parts.clone() } else { largest };
            assert!(solve["version"].is_null() && all["version"].is_string(), "said once");
        }
        assert!(solves.iter().all(|solve| solve["error_estimate_parts"] == largest), "that of all");
    }
}

/// On a searched grid, every direction reaches the accuracy, and options apply to each.
#[test]
fn options_apply_to_every_direction() {
    let mut listed = good();
    listed["directions"] =
        json!([{ "sigma_deg": 5 }, { "sigma_deg": 33, "phi_deg": 40 }, { "sigma_deg": 60 }]);
    let text = listed.to_string();
    let all =
        solved(&text, "case.json", &["--accuracy", "1e-2", "--snap", "--gradient", "--illuminated-um", "2"]);
    let solves = all["solves"].as_array().expect("a list");
    for (solve, polar) in solves.iter().zip([5.0, 33.0, 60.0]) {
        assert!(solve["error_estimate"].as_f64().expect("a number") <= 1e-2, "{solve}");
        assert_eq!(solve["snapped"]["asked"]["polar_deg"], polar);
        assert_eq!(solve["polar_deg"], solve["snapped"]["polar_deg"]);
        assert!(solve["gradients"].is_array() && solve["finite_area"]["reflected"].is_object());
    }
    refuses_text("case.json", &text, &["--export-operator", "x.npz"], &["--export-operator", "`directions`"]);
    for (value, words) in [
        (json!([]), ["directions: found 0 entries", "1 to 4096 entries", "sigma_deg = 45"]),
        (
            json!([{ "sigma_deg": 90 }]),
            ["directions[0].sigma_deg: found 90", "from 0 to below 90°", "use 89"],
        ),
        (json!([{}, { "polar_deg": 3 }]), ["directions[1].polar_deg", "an unknown key", "`sigma_deg`"]),
        (json!([45]), ["directions[0]: found integer `45`", "a table", "in that form"]),
    ] {
        refuses_text("case.json", &with("/directions", value), &[], &words);
    }
}

/// Programs that read one wave's results read the other's: keys are the same, values of the vector wave are by polarisation.
#[test]
fn both_waves_print_the_same_keys() {
    let of_wave = |wave: &str| {
        let options = ["--wave", wave, "--nxy", "9", "--nz", "8"];
        solved(&good().to_string(), "case.json", &options)
    };
    let scalar = of_wave("scalar");
    let vector = of_wave("vector");
    let keys = |value: &Value| value.as_object().expect("an object").keys().cloned().collect::<Vec<_>>();
    for pointer in ["", "/orders/0", "/resolution", "/error_estimate_parts"] {
        let part = |result: &Value| keys(result.pointer(pointer).expect("a part of a result"));
        assert_eq!(part(&scalar), part(&vector), "{pointer}");
    }
    assert_eq!([&scalar["wave"], &vector["wave"]], ["scalar", "vector"]);
    for total in ["R_total", "T_total", "A_total", "energy_error", "steps"] {
        assert!(scalar[total].is_number() && vector[total]["s"].is_number(), "{total}");
    }
}

#[test]
fn whole_cases_and_toml_are_accepted_and_give_the_same() {
    let options = ["--nxy", "12", "--nz", "10"];
    let whole = json!({ "id": "x", "kind": "spheres3d", "inputs": good(), "outputs": { "orders": [] } });
    let toml = "wavelength = 0.55\nsigma_deg = 20.0\nL = 0.5\nH = 0.6\neta_binder = [1.558, 0.0]\n\n[[spheres]]\n\
                center = [0.2, 0.2, 0.3]\nradius = 0.15\neta = [1.4, 0.1]\n";
    let plain = solved(&good().to_string(), "case.json", &options);
    assert_eq!(plain["resolution"]["nx"], 12);
    assert_eq!(plain["orders"], solved(&whole.to_string(), "case.json", &options)["orders"]);
    assert_eq!(plain["orders"], solved(toml, "case.toml", &options)["orders"]);
}

#[test]
fn light_from_below_sees_less_of_an_asymmetric_layer() {
    let case = |from: &str| {
        json!({ "wavelength": 0.55, "from": from, "layers_from_z0":
                [{ "thickness": 0.2, "eta": [1.5, 0] }, { "thickness": 0.2, "eta": [1.5, 0.3] }] })
    };
    let above = solved(&case("incident").to_string(), "case.json", &[]);
    let below = solved(&case("exit").to_string(), "case.json", &[]);
    let number = |value: &Value| value.as_f64().expect("a number");
    // Reciprocity makes the transmittance the same; absorption makes the reflectance differ.
    assert!((number(&above["T_total"]) - number(&below["T_total"])).abs() < 1e-13);
    assert!((number(&above["R_total"]) - number(&below["R_total"])).abs() > 1e-3);
}
