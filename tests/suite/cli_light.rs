//! `inkwave solve` with a lit square and with light along the lattice.

use super::cli_solve::{Folder, good, inkwave, message, solved};
use super::run_support::TINY;
use serde_json::{Value, json};

#[test]
fn a_lit_square_adds_its_lobes_and_their_totals() {
    let options = ["--nxy", "12", "--nz", "10", "--illuminated-um", "4", "--illuminated-step-deg", "7.5"];
    let result = solved(&good().to_string(), "case.json", &options);
    let area = &result["finite_area"];
    let number = |value: &Value| value.as_f64().expect("a number");
    let length = |value: &Value| value.as_array().expect("a list").len();
    assert_eq!(number(&area["side_um"]), 4.0);
    assert_eq!((length(&area["polar_deg"]), length(&area["azimuth_deg"])), (13, 48));
    for (side, total, efficiency) in [("reflected", "R_total", "eff_R"), ("transmitted", "T_total", "eff_T")]
    {
        let lobes = &area[side];
        for table in ["per_sr", "diffuse_per_sr"] {
            assert_eq!((length(&lobes[table]), length(&lobes[table][12])), (13, 48), "{side}.{table}");
        }
        assert!(number(&lobes["first_zero_deg"]) > 7.5);
        // Order: (0, 0) and (-1, 0), at sin 20° − 1.1, propagate; each lobe lacks 2/(κ₀ l) of its |α|², and what they share.
        let lacks = 1.0 - number(&lobes["total"]) / number(&result[total]);
        assert!((0.0..0.15).contains(&lacks), "{side} lacks {lacks}");
        let orders = result["orders"].as_array().expect("orders");
        let diffuse: f64 =
            orders.iter().filter(|o| o["m"] != 0 || o["n"] != 0).map(|o| number(&o[efficiency])).sum();
        assert!((number(&lobes["diffuse_total"]) / diffuse - 1.0).abs() < 0.1, "{side}");
    }
    // The brightest of these directions is the one nearest to the specular ones: 20° at azimuth 0.
    let row = |polar: usize| number(&area["transmitted"]["per_sr"][polar][0]);
    assert!((0..13).all(|i| row(i) <= row(3)), "22.5° is nearest to 20°");
}

#[test]
fn what_a_lit_square_cannot_show_is_said() {
    let absorber = json!({ "wavelength": 0.5, "n_out": [1.5, 0.1],
                           "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0] }] });
    let folder = Folder::new();
    let path = folder.file("case.json", &absorber.to_string());
    for (side, remedy) in [("200", "try a smaller square"), ("20", "try --illuminated-step-deg 1")] {
        let output = inkwave(&path, &["--illuminated-um", side]);
        assert!(output.status.success(), "{}", message(&output));
        let told = message(&output);
        assert!(told.matches("5° apart").count() == 1 && told.contains(remedy), "{told}");
    }
    let output = inkwave(&path, &["--illuminated-um", "20"]);
    let result: Value = serde_json::from_slice(&output.stdout).expect("standard output is JSON");
    assert!(result["finite_area"]["transmitted"].is_null() && result["finite_area"]["reflected"].is_object());
}

#[test]
fn snapped_light_is_solved_along_the_lattice_and_says_so() {
    let case = |sigma: f64, phi: f64| {
        json!({ "wavelength": 0.5, "L": 2, "sigma_deg": sigma, "phi_deg": phi,
                "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] })
        .to_string()
    };
    // Directions lie 0.25 apart: (1, 1) is the nearest to 20° at 30°.
    let polar = 0.125f64.sqrt().asin().to_degrees();
    let number = |value: &Value| value.as_f64().expect("a number");
    for (wave, total) in [("scalar", "/R_total"), ("vector", "/R_total/unpolarised")] {
        let options = ["--nz", "8", "--wave", wave];
        let snapped = solved(&case(20.0, 30.0), "case.json", &[&options[..], &["--snap"]].concat());
        assert!((number(&snapped["snapped"]["polar_deg"]) - polar).abs() < 1e-12);
        assert!((number(&snapped["snapped"]["azimuth_deg"]) - 45.0).abs() < 1e-12);
        assert_eq!(snapped["snapped"]["vector"], json!([1, 1]));
        assert_eq!(snapped["snapped"]["asked"], json!({ "polar_deg": 20.0, "azimuth_deg": 30.0 }));
        assert_eq!(snapped["polar_deg"], snapped["snapped"]["polar_deg"], "the light solved");
        let direct = solved(&case(polar, 45.0), "case.json", &options);
        assert!(direct["snapped"].is_null());
        let found = number(snapped.pointer(total).expect("a total"));
        let expected = number(direct.pointer(total).expect("a total"));
        assert!((found - expected).abs() < 1e-12, "{wave}: the direction said is the one solved");
    }
}

/// A realisation of a study is lit from its own azimuth, as its run is. *Planted*: that of the next realisation.
#[test]
fn a_realisation_is_lit_from_its_own_azimuth() {
    let folder = Folder::new();
    let path = folder.file("study.toml", TINY);
    let study = inkwave::input::load::load(&path).expect("a study");
    let azimuth = |realisation: usize| study.points(realisation)[0].incidence.azimuth_deg;
    assert!((azimuth(0) - azimuth(1)).abs() > 1.0, "the check is empty");
    for (number, realisation) in [("1", 0), ("2", 1)] {
        let output = inkwave(&path, &["--realisation", number, "--nxy", "12", "--nz", "6"]);
        assert!(output.status.success(), "{}", message(&output));
        let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(result["azimuth_deg"].as_f64(), Some(azimuth(realisation)), "realisation {number}");
    }
}

/// A realisation of a study is solved in the study's wave equation unless the command names one. *Planted*: the study's
/// wave not asked.
#[test]
fn a_realisation_is_solved_in_the_wave_of_its_study() {
    let folder = Folder::new();
    let vector = TINY.replace("[light]\n", "[light]\nwave = \"s\"\n");
    assert_ne!(vector, TINY, "the check is empty");
    let path = folder.file("study.toml", &vector);
    for (named, expected) in [(&[][..], "vector"), (&["--wave", "scalar"], "scalar")] {
        let options = [&["--realisation", "1", "--nxy", "12", "--nz", "6"], named].concat();
        let output = inkwave(&path, &options);
        assert!(output.status.success(), "{}", message(&output));
        let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(result["wave"], expected, "{named:?}");
    }
}
