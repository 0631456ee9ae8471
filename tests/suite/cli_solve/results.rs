//! What a good run of `inkwave solve` prints.

use super::{Folder, good, inkwave, refuses_text, solved, with};
use serde_json::{Value, json};

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
