//! Grains in given places and fractal clusters: what a packing writes, a study reads back, and wrong files are refused with place and count.

use inkwave::export::grains::{dump, xyz};
use inkwave::ink::{Packing, pack};
use inkwave::input::Study;
use inkwave::input::check::check;
use inkwave::input::file::StudyFile;
use inkwave::report::packing::grains_csv;
use inkwave::wave::Scene;
use std::path::Path;

const PIGMENTS: &str = "[[pigment]]\nname = 'a'\nindex = 1.9\nshell = [{ thickness_nm = 15, index = 1.3 }]\n\
    [[pigment]]\nname = 'b'\nindex = 1.7\n";
const LIGHT: &str = "[light]\nwavelengths_nm = [500]\n";

fn study(folder: &Path, text: &str) -> Result<Study, String> {
    let file: StudyFile = toml::from_str(text).map_err(|e| e.to_string())?;
    let told = |faults: Vec<_>| faults.iter().map(ToString::to_string).collect::<Vec<String>>().join("; ");
    check(&file, folder, "test").map_err(told)
}

/// A packing of coated spheres and rods, of two pigments.
fn packed() -> Packing {
    let text = format!(
        "[layer]\nthickness_um = 0.8\nperiod_um = [1.0, 1.2]\ncell = 'fixed'\nbinder.index = 1.5\n{PIGMENTS}{LIGHT}"
    );
    let text = text
        .replace("name = 'a'", "name = 'a'\nvolume_fraction = 0.1\ndiameter_nm = 150")
        .replace("name = 'b'", "name = 'b'\nvolume_fraction = 0.1\ndiameter_nm = 180\nshape = 'cylinder'");
    pack(&study(Path::new("."), &text).expect("a study").packing_request(0), &mut ()).expect("room")
}

fn given(folder: &Path, microstructure: &str, period: &str) -> Result<Study, String> {
    let layer = format!(
        "[layer]\nthickness_um = 0.8\nbinder.index = 1.5\n{period}\nmicrostructure = {microstructure}\n"
    );
    study(folder, &format!("{layer}{PIGMENTS}{LIGHT}"))
}

#[test]
fn what_is_written_is_read_back() {
    let (packing, folder) = (packed(), tempfile::tempdir().expect("a folder"));
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    write("g.csv", &grains_csv(&packing).expect("a table"));
    write("g.dump", dump(&packing).as_bytes());
    write("g.xyz", xyz(&packing).as_bytes());
    let stated = "unit = 'um', size = 'radius'";
    for (table, period) in [
        ("{ spheres = 'g.csv' }".to_owned(), "period_um = [1.0, 1.2]"),
        (format!("{{ spheres = 'g.dump', {stated} }}"), ""),
        (format!("{{ spheres = 'g.xyz', {stated} }}"), ""),
    ] {
        let study = given(folder.path(), &table, period).unwrap_or_else(|e| panic!("{table}: {e}"));
        let back = pack(&study.packing_request(0), &mut ()).expect("the given grains");
        assert_eq!(Scene::from_packing(&back), Scene::from_packing(&packing), "{table}");
        for k in [0, 1] {
            // identity: volumes of the same spheres, summed in another order
            assert!((back.achieved_fraction(k) - packing.achieved_fraction(k)).abs() < 1e-12, "{table}");
        }
        assert_eq!((study.realisations, study.layer.period_um), (1, [1.0, 1.2]));
    }
    write("h.csv", &grains_csv(&packing).expect("a table"));
    let two = "{ spheres = ['g.csv', 'h.csv'] }";
    assert_eq!(given(folder.path(), two, "period_um = [1.0, 1.2]").expect("two cuts").realisations, 2);
}

/// Rows in any order, as programs in parallel write them, and a pigment that has no name of its own.
#[test]
fn spheres_of_a_grain_need_no_neighbouring_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let [one, two] = ["0.2,0.2,0.2,0.1,a,1\n", "0.3,0.2,0.2,0.1,a,1\n"];
    let other = "0.7,0.7,0.2,0.1,pigment 2,2\n";
    let scene = |rows: &[&str]| {
        let text = format!("x_um,y_um,z_um,radius_um,pigment,grain\n{}", rows.concat());
        std::fs::write(folder.path().join("cut.csv"), text).expect("written");
        let pigments = PIGMENTS.replace("name = 'b'\n", "");
        let layer = "[layer]\nthickness_um = 0.8\nbinder.index = 1.5\nperiod_um = 1\nmicrostructure.spheres = 'cut.csv'\n";
        let study = study(folder.path(), &format!("{layer}{pigments}{LIGHT}")).expect("sound");
        Scene::from_packing(&pack(&study.packing_request(0), &mut ()).expect("the given grains"))
    };
    assert_eq!(scene(&[one, other, two]), scene(&[one, two, other]));
}

#[test]
fn files_that_cannot_be_read_are_the_only_fault() {
    let folder = tempfile::tempdir().expect("a folder");
    let layer = "[layer]\nthickness_um = 0.8\ncell = 'fixed'\nbinder.index = 1.5\nmicrostructure.spheres = 'absent.csv'\n";
    let error =
        study(folder.path(), &format!("{layer}{PIGMENTS}{LIGHT}[run]\nrealisations = 3\n")).unwrap_err();
    assert!(error.contains("absent.csv") && error.matches("allowed:").count() == 1, "{error}");
}

#[test]
fn wrong_files_are_refused_with_place_and_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = |rows: &str| format!("x_um,y_um,z_um,radius_um,pigment\n{rows}");
    let b = "0.5,0.5,0.5,0.05,b\n";
    for (name, text, says) in [
        ("empty", rows(""), "no spheres"),
        ("other", rows("0.1,0.1,0.2,0.05,c\n"), "pigment \"c\""),
        ("one", rows("0.1,0.1,0.2,0.05,a\n"), "pigment[1]"),
        (
            "mixed",
            rows("0.1,0.1,0.2,0.05,a,7\n0.1,0.1,0.25,0.05,b,7\n").replace("t\n", "t,grain\n"),
            "grain 7 of several",
        ),
        (
            "overlap",
            rows(&format!("0.1,0.1,0.2,0.05,a\n0.12,0.1,0.2,0.05,a\n0.98,0.1,0.2,0.08,b\n{b}")),
            "2 pairs",
        ),
        ("high", rows(&format!("0.1,0.1,0.9,0.05,a\n0.1,0.5,0.78,0.05,a\n{b}")), "2 spheres outside"),
        ("nm", rows("100,100,200,50,a\n500,500,500,50,b\n"), "in nm"),
        ("axes", rows("0.1,0.2,1.4,0.05,a\n0.6,0.9,0.3,0.05,b\n"), "another column"),
        ("bare", "x,y,z,r\n1,1,1,1\n".to_owned(), "x_um or x_nm"),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
        let error =
            given(folder.path(), &format!("{{ spheres = '{name}' }}"), "period_um = [1.0, 1.2]").unwrap_err();
        assert!(error.contains(says) && error.contains("microstructure") || name == "one", "{name}: {error}");
        assert!(error.contains(says), "{name}: {error}");
    }
    for (files, says) in [("['one', 'one']", "one twice"), ("[]", "no file")] {
        let error = given(folder.path(), &format!("{{ spheres = {files} }}"), "period_um = 1").unwrap_err();
        assert!(error.contains(says), "{error}");
    }
    let error = given(folder.path(), "{ spheres = 'one' }", "").unwrap_err();
    assert!(error.contains("layer.period_um") && error.contains("no box"), "{error}");
    let shared =
        format!("[layer]\nthickness_um = 0.8\nmicrostructure = {{ spheres = 'one' }}\n{PIGMENTS}{LIGHT}");
    let error = study(folder.path(), &shared.replace("index = 1.7", "index = 1.7\nvolume_fraction = 0.2"))
        .unwrap_err();
    assert!(error.contains("pigment[1].volume_fraction") && error.contains("grains are placed"), "{error}");
}

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
