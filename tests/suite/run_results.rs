//! What a finished run leaves behind.

use crate::run_support::{TINY, described_tables, results, study, succeed};
use serde_json::Value;
use std::path::Path;

#[test]
fn a_finished_run_leaves_numbers_tables_picture_and_page() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), TINY), &out, &[]);

    let results = results(&out);
    assert_eq!(results["status"], "complete");
    assert_eq!(results["solves"]["finished"], 24);
    // the discrete balance holds to ten times the solver's residual
    let certainty = &results["certainty"];
    let energy = certainty["largest_energy_error"].as_f64().unwrap();
    assert!(energy <= 10.0 * certainty["largest_residual"].as_f64().unwrap(), "{certainty}");
    assert!(certainty["amplitude_error_estimate"].as_f64().unwrap() > 0.0);
    assert!(results["colours"][0]["lab_standard_error"].is_array(), "two realisations give errors");
    assert_eq!(results["packings"].as_array().unwrap().len(), 2);

    let header = std::fs::read_to_string(out.join("spectra.csv")).unwrap();
    assert!(header.starts_with("wavelength_nm,polar_deg,reflectance,reflectance_standard_error"));
    assert_eq!(header.lines().count(), 1 + 2 * 4, "four wavelengths at 0° and at 45°");
    assert!(std::fs::read_to_string(out.join("bdf.csv")).unwrap().lines().count() > 24);
    assert!(std::fs::read(out.join("picture.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(!out.join("PARTIAL").exists());

    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<h1>Tiny yellow</h1>") && !page.contains("Partial results"));
    assert!(
        !page.contains("NaN") && !page.contains("http://") && !page.contains("src=\"/"),
        "self-contained"
    );
    assert!(page.contains("Only 4 wavelengths were solved") && page.contains("A thin air gap"), "{page}");
}

/// *Planted*: a column whose description is removed from the list.
#[test]
fn every_column_of_every_table_of_a_run_is_described() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::write(folder.path().join("print.csv"), "wavelength_nm,reflectance\n400,0.5\n700,0.6\n").unwrap();
    let text = TINY.replace("[output]", "[compare]\nmeasured = \"print.csv\"\n[output]");
    succeed(&study(folder.path(), &text), &out, &[]);
    // spectra, distributions, the measurement
    assert!(described_tables(&out) >= 3);
    let package = std::fs::read_to_string(out.join("datapackage.json")).unwrap();
    assert!(package.contains("layer alone") && package.contains("layer on its paper"), "{package}");
}

/// The list of columns gives a unit by its sign, and describes a column in words. *Planted*: the description as the unit.
#[test]
fn the_list_of_columns_gives_units() {
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"))
        .args(["schema", "columns"])
        .output()
        .unwrap();
    let list: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    let columns = list["columns"].as_array().expect("columns");
    let unit =
        |name: &str| columns.iter().find(|column| column["name"] == name).expect(name)["unit"].as_str();
    let units = ["wavelength_nm", "thickness_um", "polar_deg", "reflectance"].map(unit);
    assert_eq!(units, [Some("nm"), Some("µm"), Some("°"), None]);
}

/// ⟨|t|²⟩ holds the diffuse light of the cells' order, |⟨t⟩|² does not; of a clear film both are T.
#[test]
fn coherent_and_specular_transmittance_are_both_published() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |text: &str, name: &str| {
        let out = folder.path().join(name);
        succeed(&study(folder.path(), text), &out, &[]);
        results(&out)["spectra"].as_array().unwrap().clone()
    };
    let value = |row: &Value, key: &str| row[key]["value"].as_f64().unwrap();
    let start = TINY.find("[[pigment]]").unwrap();
    let clear = format!("{}{}", &TINY[..start], &TINY[TINY.find("[light]").unwrap()..]);
    for row in rows(&clear, "clear") {
        let [all, specular, coherent] =
            ["transmittance", "specular_transmittance", "coherent_transmittance"].map(|key| value(&row, key));
        // identity: all realisations are the same film, with rounding and the solver's residual
        assert!((specular - all).abs() < 1e-4 && (coherent - all).abs() < 1e-4, "{row}");
    }
    // grains that scatter strongly in small cells: much diffuse light goes straight on
    let strong =
        TINY.replace("{ built_in = \"yellow\" }", "2.4").replace("realisations = 2", "realisations = 8");
    let mut specular = 0.0;
    let mut coherent = 0.0;
    for row in rows(&strong, "strong") {
        let error = row["coherent_transmittance"]["standard_error"].as_f64().unwrap();
        assert!(
            value(&row, "coherent_transmittance") < value(&row, "specular_transmittance") + 3.0 * error,
            "{row}"
        );
        specular += value(&row, "specular_transmittance");
        coherent += value(&row, "coherent_transmittance");
    }
    assert!(coherent < 0.97 * specular, "{coherent} {specular}");
}

/// Packings that are too few to end early miss no target by it, and are no pairs.
#[test]
fn a_target_is_missed_where_an_interval_is_wider() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (target, missed) in [("100", false), ("0.001", true)] {
        let text = TINY.replace("seed = 7", &format!("seed = 7\ntarget_delta_e = {target}"));
        // closer wavelengths: what lies between those 100 nm apart would be most of the interval
        let text = text.replace("step_nm = 100", "step_nm = 20");
        let said = succeed(&study(folder.path(), &text), &out, &[]);
        assert_eq!(said.contains("still wider than run.target_delta_e"), missed, "{said}");
    }
    // wavelengths far apart, which no number of packings helps
    let text = TINY.replace("seed = 7", "seed = 7\ntarget_delta_e = 0.001");
    let said = succeed(&study(folder.path(), &text), &folder.path().join("listed"), &[]);
    assert!(said.contains("make it narrower: wavelengths that are closer"), "{said}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("(jackknife over realisations)") && !page.contains("two packings share"), "{page}");
}

/// A spectrum through one wavelength per packing has no colour, and no page speaks of a picture.
#[test]
fn one_wavelength_of_a_range_has_no_colour() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let text = TINY.replace("step_nm = 100\nsampling = \"listed\"", "step_nm = 300");
    succeed(&study(folder.path(), &text), &out, &[]);
    let results = results(&out);
    let reason = results["no_colour"].as_str().unwrap();
    assert!(reason.contains("1 wavelength per realisation") && reason.contains("step_nm = 20"), "{reason}");
    assert!(!std::fs::read_to_string(out.join("report.html")).unwrap().contains("picture.png"));
}

#[test]
fn threads_and_jobs_do_not_change_a_bit() {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), TINY);
    let run_with = |name: &str, threads: &str, jobs: &str| {
        let out = folder.path().join(name);
        let mut command = crate::run_support::command(&study, &out, &["--jobs", jobs]);
        assert!(command.env("RAYON_NUM_THREADS", threads).output().unwrap().status.success());
        ["spectra.csv", "bdf.csv", "picture.png", "picture-with-axes.png"]
            .map(|file| std::fs::read(out.join(file)).unwrap())
    };
    let one = run_with("one", "1", "1");
    assert!(one == run_with("three", "3", "3"), "three solves at a time");
    assert!(one == run_with("wide", "3", "1"), "three threads in one solve");
}

#[test]
fn a_clear_layer_needs_no_packing_and_obeys_fresnel() {
    let folder = tempfile::tempdir().unwrap();
    let pigment = TINY.find("[[pigment]]").unwrap()..TINY.find("[light]").unwrap();
    let clear = TINY.replace(&TINY[pigment], "");
    let out = folder.path().join("out");
    succeed(&study(folder.path(), &clear), &out, &[]);
    let results = results(&out);
    assert_eq!(results["realisations"]["asked"], 1);
    for row in results["spectra"].as_array().unwrap().iter().filter(|row| row["polar_deg"] == 0.0) {
        let n: f64 = 1.558;
        let thickness: f64 = 0.5;
        let nm = row["wavelength_nm"].as_f64().unwrap();
        let phase = std::f64::consts::TAU * n * thickness / (1e-3 * nm);
        // Airy's formula for a film in air at normal incidence
        let f = (n * n - 1.0).powi(2) / (4.0 * n * n) * phase.sin().powi(2);
        let reflectance = row["reflectance"]["value"].as_f64().unwrap();
        assert!((reflectance - f / (1.0 + f)).abs() < 1e-11, "{nm} nm: {reflectance}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("The binder alone in a layer 0.5 µm thick") && page.contains("without grains all"));
}

/// The examples are sound studies, and the first one, made coarse, is a yellow ink.
#[test]
fn the_examples_are_sound_and_the_first_is_yellow() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    for name in ["yellow.toml", "yellow-full.toml", "production.toml"] {
        inkwave::input::load::load(&examples.join(name)).unwrap();
    }
    let coarse = std::fs::read_to_string(examples.join("yellow.toml")).unwrap();
    let coarse = coarse.replace("step_nm = 20", "step_nm = 50").replace("count = 5", "count = 4");
    let coarse = coarse.replace("realisations = 12", "realisations = 2");
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), &coarse), &out, &[]);
    let results = results(&out);
    // six strata of wavelengths between seven outputs
    assert_eq!(results["solves"]["asked"], 2 * 6 * 4);
    // *Planted*: the strata of one realisation were counted, and twelve wavelengths called fewer than eight.
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("wavelengths were solved") && page.contains("A thin air gap"), "{page}");
    let colour = &results["colours"][0];
    let (chroma, hue) =
        (colour["chroma"]["value"].as_f64().unwrap(), colour["hue_deg"]["value"].as_f64().unwrap());
    assert!(chroma > 50.0 && (80.0..115.0).contains(&hue), "chroma {chroma}, hue {hue}");
}

/// Every table that pages of studies write is removed when another study begins in the folder: an earlier study's numbers must
/// not lie beside the new one's. *Planted*: a table added to `src/report` alone.
#[test]
fn every_table_of_a_study_goes_when_another_begins() {
    let mut named = Vec::new();
    let mut folders = vec![std::path::PathBuf::from("src/report")];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() && !path.ends_with("packing") {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let tables = text.split("(\"").skip(1).filter_map(|rest| rest.split('"').next());
                named.extend(tables.filter(|name| name.ends_with(".csv")).map(str::to_owned));
            }
        }
    }
    assert!(named.len() > 8 && named.iter().any(|name| name == "numbers.csv"), "{named:?}");
    // read by the program, not written
    named.retain(|name| name != "scalar_error.csv" && !name.contains('/'));
    for name in named {
        assert!(inkwave::store::folder::RESULTS.contains(&name.as_str()), "{name}");
    }
}
