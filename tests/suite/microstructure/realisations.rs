//! Fractal clusters, and a realisation as a packing, a light and a case.

use super::{LIGHT, study};
use inkwave::ink::{Packing, pack};
use std::path::Path;

/// Clusters in a packing have the dimension asked for: least squares of ln N over the logarithm of the mean radius of gyration.
#[test]
fn fractal_agglomerates_have_their_dimension_in_a_packing() {
    let gyration = |grains: usize| {
        let text = format!(
            "[layer]\nthickness_um = 5\nperiod_um = 10\ncell = 'fixed'\nbinder.index = 1.5\n[[pigment]]\nname = 'black'\n\
             diameter_nm = 60\nvolume_fraction = {}\nindex = 1.7\nagglomeration = {{ degree = 1, grains = {grains}, \
             fractal = {{ dimension = 1.78 }} }}\n{LIGHT}",
            12.0 * grains as f64 * std::f64::consts::PI / 6.0 * 0.06f64.powi(3) / 500.0
        );
        let study = study(Path::new("."), &text).unwrap_or_else(|e| panic!("{e}"));
        let packing = pack(&study.packing_request(0), &mut ()).expect("room");
        let clusters = packing.grains().iter().filter_map(|g| g.agglomerate).max().expect("clusters") + 1;
        (0..clusters).map(|k| gyration_um(&packing, k).ln()).sum::<f64>() / clusters as f64
    };
    let points: Vec<[f64; 2]> = [16, 48, 144].map(|n| [gyration(n), (n as f64).ln()]).to_vec();
    let dimension = (points[2][1] - points[0][1]) / (points[2][0] - points[0][0]);
    // promise: contacts within 1 % of the law's distance, and the scatter of a dozen clusters of each number
    assert!((dimension / 1.78 - 1.0).abs() < 0.06, "{dimension}: {points:?}");
}

/// Radius of gyration of the centres of an agglomerate's grains.
fn gyration_um(packing: &Packing, agglomerate: usize) -> f64 {
    let own = packing.grains().iter().filter(|g| g.agglomerate == Some(agglomerate));
    let centres: Vec<[f64; 3]> = own.map(inkwave::ink::Grain::centre_um).collect();
    let near = |c: &[f64; 3]| {
        let period = packing.period_um();
        let d: [f64; 3] = std::array::from_fn(|i| c[i] - centres[0][i]);
        [d[0] - period[0] * (d[0] / period[0]).round(), d[1] - period[1] * (d[1] / period[1]).round(), d[2]]
    };
    let centres: Vec<[f64; 3]> = centres.iter().map(near).collect();
    let count = centres.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|i| centres.iter().map(|c| c[i]).sum::<f64>() / count);
    let square = |c: &[f64; 3]| (0..3).map(|i| (c[i] - mean[i]).powi(2)).sum::<f64>();
    (centres.iter().map(square).sum::<f64>() / count).sqrt()
}

/// `solve --realisation` takes the azimuth of that realisation, which differs from cell to cell. *Planted*: that of the next one.
#[test]
fn a_realisation_is_lit_from_its_own_azimuth() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.toml");
    let text = "[layer]\nthickness_um = 0.4\nbinder.index = 1.5\n[[pigment]]\nname = 'a'\nindex = 1.7\nvolume_fraction = 0.1\n\
                diameter_nm = 250\n[light]\nwavelengths_nm = [600]\n[angles]\npolar_deg = [20]\n[run]\nrealisations = 3\n";
    std::fs::write(&path, text).expect("written");
    let study = inkwave::input::load::load(&path).expect("a study");
    let mut azimuths: Vec<f64> = Vec::new();
    for number in 1..=3 {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
        let number = number.to_string();
        let done = command
            .arg("solve")
            .arg(&path)
            .args(["--nxy", "12", "--nz", "6", "--realisation", &number])
            .output();
        let found: serde_json::Value =
            serde_json::from_slice(&done.expect("the program").stdout).expect("JSON");
        azimuths.push(found["azimuth_deg"].as_f64().expect("an azimuth"));
    }
    // identity: the same draw
    assert_eq!(azimuths, [0, 1, 2].map(|realisation| study.draw(realisation).azimuth_deg));
    assert!(azimuths[0] != azimuths[1] && azimuths[1] != azimuths[2], "{azimuths:?}");
}

/// `solve --realisation` of positions in a file against the case that holds the same spheres. *Planted*: the azimuth of another
/// realisation, or the index of another pigment.
#[test]
fn a_realisation_is_solved_as_the_case_of_its_grains() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
        folder.path().join(name)
    };
    write("cut.csv", "x_um,y_um,z_um,radius_um,pigment\n0.2,0.3,0.25,0.12,a\n0.6,0.5,0.4,0.1,b\n");
    let study = write(
        "study.toml",
        "title = 't'\n[layer]\nthickness_um = 0.6\nperiod_um = [0.8, 0.7]\nbinder.index = 1.5\n\
         microstructure = { spheres = 'cut.csv' }\n[[pigment]]\nname = 'a'\nindex = 1.9\n\
         [[pigment]]\nname = 'b'\nindex = { n = 1.7, k = 0.1 }\n[light]\nwavelengths_nm = [500, 600]\n",
    );
    let solve = |arguments: &[&str], path: &Path| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
        let done = command.arg("solve").arg(path).args(["--nxy", "12", "--nz", "6"]).args(arguments).output();
        let done = done.expect("the program");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        serde_json::from_slice::<serde_json::Value>(&done.stdout).expect("JSON")
    };
    let of_study = solve(&["--realisation", "1", "--wavelength-nm", "550", "--polar-deg", "20"], &study);
    let azimuth = inkwave::input::load::load(&study).expect("a study").draw(0).azimuth_deg;
    let case = write(
        "case.json",
        &serde_json::json!({
            "wavelength": 0.55, "sigma_deg": 20, "phi_deg": azimuth, "L": [0.8, 0.7], "H": 0.6, "eta_binder": [1.5, 0.0],
            "spheres": [
                { "center": [0.2, 0.3, 0.25], "radius": 0.12, "eta": [1.9, 0.0] },
                { "center": [0.6, 0.5, 0.4], "radius": 0.1, "eta": [1.7, 0.1] },
            ],
        })
        .to_string(),
    );
    let of_case = solve(&[], &case);
    let keys =
        ["orders", "R_total", "T_total", "A_total", "wave", "wavelength_nm", "polar_deg", "azimuth_deg"];
    for key in keys {
        assert_eq!(of_study[key], of_case[key], "{key}");
    }
    // the study's wave, unless another is asked for
    let text = std::fs::read_to_string(&study).expect("the study") + "wave = 'unpolarised'\n";
    let vector = write("vector.toml", &text);
    let one = ["--realisation", "1", "--wavelength-nm", "550", "--polar-deg", "20"];
    let waves = [&[][..], &["--wave", "scalar"]].map(|more| solve(&[&one, more].concat(), &vector));
    assert_eq!([&waves[0]["wave"], &waves[1]["wave"]], ["vector", "scalar"]);
    assert_eq!(waves[1]["orders"], of_case["orders"]);
}
