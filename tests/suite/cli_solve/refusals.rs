//! What `inkwave solve` refuses, and with which words.

use super::{Folder, good, inkwave, message, refuses, refuses_text, solved, with};
use serde_json::{Value, json};

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
            vec!["spheres[0].center", "2 entries", "a list of 3 in brackets"],
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
    refuses_text("case.json", &beside, &[], &["wavelength: found a key beside `inputs`", "move it"]);
    let study = "[layer]\nthickness_um = 1\n";
    refuses_text("study.toml", study, &[], &["is a study", "reads a case", "--realisation 1"]);
    let sweep = "base = \"study.toml\"\n[[axis]]\nfield = \"run.seed\"\nvalues = [1, 2]\n";
    refuses_text("sweep.toml", sweep, &[], &["is a sweep", "reads a case", "inkwave sweep"]);
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

/// A wavelength in µm under the key in nm, as studies refuse it.
#[test]
fn micrometres_under_the_key_in_nm_are_refused() {
    for (nm, words) in [
        (0.55, ["wavelength_nm: found 0.55", "from 100 to 20000 nm", "write wavelength = 0.55"]),
        (99.0, ["wavelength_nm: found 99", "from 100 to 20000 nm", "wavelength_um takes any"]),
        (3e4, ["wavelength_nm: found 30000", "from 100 to 20000 nm", "wavelength_um takes any"]),
    ] {
        let film = json!({ "wavelength_nm": nm, "layers_from_z0": [{ "thickness": 0.3, "eta": [1.5, 0] }] });
        refuses_text("case.json", &film.to_string(), &[], &words);
    }
}
