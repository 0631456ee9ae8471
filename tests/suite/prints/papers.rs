//! Papers of prints: measured ones, and some that would be taken for others.

use super::{DOTS, Place, ink_of_thickness, lab};
use crate::run_support::{TINY, results, study, succeed};
use serde_json::Value;
use std::path::Path;

/// What is read of a measured paper is what the study's bare paper reads, and the page says so.
#[test]
fn measured_paper_is_returned() {
    let scratch = tempfile::tempdir().unwrap();
    let rows: String =
        (0..=15).map(|k| format!("{},{}\n", 400 + 20 * k, 0.80 + 0.004 * f64::from(k))).collect();
    std::fs::write(scratch.path().join("paper.csv"), format!("wavelength_nm,reflectance\n{rows}")).unwrap();
    let text = TINY.replace("binder.index = 1.558", "binder.index = 1.5\nindex_out = 1.5");
    let paper =
        "[paper]\ncoupling = \"optical_contact\"\nmeasured = { csv = \"paper.csv\", unit = \"factor\" }\n";
    let output = scratch.path().join("out");
    let printed = succeed(&study(scratch.path(), &format!("{text}{DOTS}{paper}")), &output, &[]);
    assert!(printed.contains("behind the paper's surface the albedo is"), "{printed}");
    let results = results(&output);
    let bare = &results["prints"]["prints"][0];
    for (k, factor) in bare["factors"].as_array().unwrap().iter().enumerate() {
        let measured = 0.80 + 0.004 * 5.0 * k as f64;
        assert!((factor["value"].as_f64().unwrap() - measured).abs() < 1e-12, "{factor} {measured}");
    }
    assert!(results["study"]["paper"]["measured"]["geometry"] == "45:0");
    let page = std::fs::read_to_string(output.join("report.html")).unwrap();
    assert!(page.contains("paper as measured"), "the page says how the albedo was made");
}

/// A clear layer on measured paper returns what was measured where light is unpolarised. The scalar wave meets another
/// surface, and console, page and results say what it makes of this paper: as the run has it. *Planted*: p light for s; the
/// remark left out of each.
#[test]
fn the_scalar_wave_says_what_it_makes_of_measured_paper() {
    let scratch = tempfile::tempdir().unwrap();
    let rows: String = (0..=15).map(|k| format!("{},{}\n", 400 + 20 * k, 0.876)).collect();
    std::fs::write(scratch.path().join("paper.csv"), format!("wavelength_nm,reflectance\n{rows}")).unwrap();
    let run = |name: &str, wave: &str, paper: &str| {
        let clear = super::ink_of_thickness(1.0).replace("{ n = 1.5, k = 0.02 }", "1.5");
        let text =
            clear.replace("albedo = 0.93", paper).replace("[light]", &format!("[light]\nwave = \"{wave}\""));
        let output = scratch.path().join(name);
        let said = succeed(&study(scratch.path(), &text), &output, &[]);
        (said, results(&output), std::fs::read_to_string(output.join("report.html")).unwrap())
    };
    let measured = "measured = { csv = \"paper.csv\", geometry = \"45:0\", unit = \"factor\" }";
    let (said, plain, page) = run("plain", "unpolarised", measured);
    let lit = |results: &Value| results["spectra"][0]["lit_at_45"]["value"].as_f64().expect("a factor");
    assert!((lit(&plain) - 0.876).abs() < 1e-9, "{}", lit(&plain));
    assert!(plain["scalar_surface"].is_null() && !page.contains("the scalar wave crosses"), "{said}");
    let (said, scalar, page) = run("scalar", "scalar", measured);
    let told = &scalar["scalar_surface"];
    for (factor, of_run) in [("lit_at_45", "lit_at_45"), ("natural_light", "natural_light")] {
        let run = scalar["spectra"][0][of_run]["value"].as_f64().expect("a factor");
        let below = told["below_clear_layer"][factor].as_f64().expect("a factor");
        assert!((below - run).abs() < 1e-6, "{factor}: {below} {run}");
        let bare = told["bare_paper"][factor].as_f64().expect("a factor");
        let truth = plain["spectra"][0][of_run]["value"].as_f64().expect("a factor");
        assert!((bare - truth).abs() < 1e-6, "{factor}: {bare} {truth}");
    }
    assert!((lit(&scalar) - 0.876).abs() > 5e-3, "nothing to say: {}", lit(&scalar));
    let words = format!("this paper reads {:.3} at 45:0", lit(&scalar));
    assert!(said.contains(&words) && page.contains(&words), "{words:?}: {said}");
    // an albedo of the inside is no measurement, unless bare paper is beside dots
    let (said, typed, _) = run("typed", "scalar", "albedo = 0.93");
    assert!(typed["scalar_surface"].is_null() && !said.contains("scalar wave"), "{said}");
    let (_, dots, page) = run("dots", "scalar", &format!("albedo = 0.93\n{DOTS}"));
    let bare = dots["prints"]["prints"][0]["factors"][0]["value"].as_f64().expect("a factor");
    let told = dots["scalar_surface"]["bare_paper"]["lit_at_45"].as_f64().expect("a factor");
    assert!((told - bare).abs() < 1e-12 && page.contains("the scalar wave crosses"), "{told} {bare}");
}

/// A perfect white behind a face is lighter than a perfect white where it is lit at 45°, above all in p light: the face lets
/// more of that light in than of diffuse light. That is no error, and under a uniform sky it reads 1. *Planted*: colours at
/// 45:0 held to white.
#[test]
fn a_white_behind_a_face_may_be_lighter_than_white_at_45() {
    let scratch = tempfile::tempdir().unwrap();
    let angle = 45.0_f64.to_radians();
    let [rs, rp] = {
        let inner = (1.5_f64 * 1.5 - angle.sin().powi(2)).sqrt();
        let s = (angle.cos() - inner) / (angle.cos() + inner);
        let p = (1.5 * 1.5 * angle.cos() - inner) / (1.5 * 1.5 * angle.cos() + inner);
        [s * s, p * p]
    };
    for (wave, passed) in [("unpolarised", 1.0 - 0.5 * (rs + rp)), ("p", 1.0 - rp), ("s", 1.0 - rs)] {
        let clear = super::ink_of_thickness(1.0).replace("{ n = 1.5, k = 0.02 }", "1.5");
        let text = clear
            .replace("albedo = 0.93", "albedo = 1")
            .replace("[light]", &format!("[light]\nwave = \"{wave}\""));
        let output = scratch.path().join(wave);
        succeed(&study(scratch.path(), &text), &output, &[]);
        let results = results(&output);
        assert!(results["withheld"].is_null(), "{wave}: {}", results["withheld"]);
        // T̄ of a face of 1.5 is 0.9082
        let truth = passed * 0.96 / 0.9082;
        let lit = results["spectra"][0]["lit_at_45"]["value"].as_f64().expect("a factor");
        assert!((lit - truth).abs() < 2e-4, "{wave}: {lit} {truth}");
        let lightness = results["colours"][1]["lab"][0].as_f64().expect("L*");
        assert!((lightness - (116.0 * truth.cbrt() - 16.0)).abs() < 0.02, "{wave}: {lightness}");
        let sky = results["spectra"][0]["natural_light"]["value"].as_f64().expect("a factor");
        assert!((sky - 1.0).abs() < 1e-9, "{wave}: {sky}");
    }
}

/// The refusal of a study, or its remarks.
pub fn checked(folder: &Path, text: &str) -> Result<Vec<String>, String> {
    let file = folder.join("study.toml");
    std::fs::write(&file, text).unwrap();
    match inkwave::input::load::load(&file) {
        Ok(study) => Ok(study.remarks),
        Err(inkwave::input::fault::StudyError::Values { faults, .. }) => {
            Err(faults.iter().map(|f| format!("{f}; {}", f.remedy)).collect::<Vec<_>>().join("\n"))
        }
        Err(other) => Err(other.to_string()),
    }
}

/// Factors above 1 of a brightened paper need no unit, as no paper is as dark as a percent; a table with rows and columns
/// exchanged would emit nothing, and a file from a sphere is no measurement at 45:0. *Planted*: the table's lower half taken
/// for nothing; the geometry beside the file believed, whatever the file says.
#[test]
fn papers_that_would_be_taken_for_others_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(scratch.path().join(name), text).unwrap();
    let waves = || (380..=740).step_by(10);
    let gauss = |nm: f64, at: f64, width: f64| (-((nm - at) / width).powi(2)).exp();
    let factors = |extra: f64| -> String {
        let row = |nm: i32| format!("{nm},{:.5}\n", 0.85 + extra * gauss(f64::from(nm), 445.0, 25.0));
        format!("wavelength_nm,factor\n{}", waves().map(row).collect::<String>())
    };
    write("m1.csv", factors(0.18));
    write("m2.csv", factors(0.0));
    let base = TINY.replace("binder.index = 1.558", "binder.index = 1.5\nindex_out = 1.5");
    let base = base.replace("from_nm = 400", "from_nm = 300").replace("step_nm = 100", "step_nm = 50");
    let base = base.replace("index = { built_in = \"yellow\" }", "index = { n = 1.7, k = 0.05 }");
    let paper = |words: &str| format!("{base}[paper]\ncoupling = \"optical_contact\"\n{words}\n");
    let told = checked(scratch.path(), &paper("fluorescence = { m1_csv = \"m1.csv\", m2_csv = \"m2.csv\" }"));
    let told = told.expect("a paper").join("\n");
    for words in ["m1.csv states no unit", "factors of a perfect white", "45:0, that of M0 to M2"] {
        assert!(told.contains(words), "{words:?} is missing: {told}");
    }
    // emission at 440 nm of light at 365 nm, and the same table with rows and columns exchanged
    let nm = || (300..=700).step_by(20).map(f64::from);
    let table = |factor: &dyn Fn(f64, f64) -> f64| -> String {
        let head: String = nm().map(|from| format!(",{from}")).collect();
        let row = |at: f64| -> String {
            let cells: String = nm().map(|from| format!(",{:.6}", factor(at, from))).collect();
            format!("{at}{cells}\n")
        };
        format!("emission_nm{head}\n{}", nm().map(row).collect::<String>())
    };
    let emits = |at: f64, from: f64| 0.002 * gauss(at, 440.0, 25.0) * gauss(from, 365.0, 25.0);
    let later = |at: f64, from: f64| if at > from { emits(at, from) } else { 0.0 };
    write("right.csv", table(&later));
    write("exchanged.csv", table(&|at, from| later(from, at)));
    let donaldson =
        |name: &str| paper(&format!("albedo = 0.9\nfluorescence = {{ donaldson_csv = \"{name}\" }}"));
    checked(scratch.path(), &donaldson("right.csv")).expect("a table");
    let told = checked(scratch.path(), &donaldson("exchanged.csv")).expect_err("nothing would be emitted");
    assert!(
        told.contains("paper.fluorescence.donaldson_csv") && told.contains("exchange rows and columns"),
        "{told}"
    );
    let bands: String = waves().map(|nm| format!(" SPEC_{nm}")).collect();
    let values: String = waves().map(|_| " 0.85").collect();
    write(
        "sphere.cgats",
        format!(
            "CGATS.17\nMEASUREMENT_GEOMETRY \"d/8\"\nBEGIN_DATA_FORMAT\nSAMPLE_ID{bands}\nEND_DATA_FORMAT\n\
             NUMBER_OF_SETS 1\nBEGIN_DATA\n1{values}\nEND_DATA\n"
        ),
    );
    let visible = |geometry: &str| {
        paper(&format!("measured = {{ csv = \"sphere.cgats\", geometry = \"{geometry}\" }}"))
            .replace("from_nm = 300", "from_nm = 400")
    };
    for geometry in ["d:8", "d:8 excluded"] {
        checked(scratch.path(), &visible(geometry)).expect("which of both it is");
    }
    let told = checked(scratch.path(), &visible("45:0")).expect_err("a contradiction");
    assert!(told.contains("paper.measured.geometry") && told.contains("where the file states"), "{told}");
}

/// Paper that varies between the wavelengths of a study: the solid of a table of prints is the print of the page, which sums the paper
/// as it is given. *Planted*: prints summed at the study's wavelengths (a* 0 for 8).
#[test]
fn prints_take_the_paper_between_the_wavelengths() {
    let place = Place::new();
    let dip = "albedo = [[400, 0.9], [540, 0.9], [550, 0.3], [560, 0.9], [700, 0.9]]";
    let text = ink_of_thickness(0.5).replace("albedo = 0.93", dip);
    let results = place.run("dip", &format!("{text}{DOTS}"));
    let page = results["colours"].as_array().unwrap().iter().find(|colour| colour["conditions"] == "45:0");
    let page: Vec<f64> =
        page.unwrap()["lab"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let prints = results["prints"]["prints"].as_array().unwrap();
    let solid = lab(prints.iter().find(|print| print["nominal"] == 1.0).unwrap());
    assert!(page[1] > 5.0, "the paper is seen: {page:?}");
    // both take steps of 5 nm, one the film and one its interpolation
    assert!(page.iter().zip(solid).all(|(page, solid)| (page - solid).abs() < 0.01), "{page:?} {solid:?}");
}
