//! Composed layers as a user runs them: any thickness of one set of solves, resumed, swept, in either wave.

mod films;

use super::run_support::{COMPOSED, described_tables, results, study, succeed, value};
use inkwave::appearance::tristimulus::Colorimeter;
use num_complex::Complex64;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// No light is lost at any thickness, all of it comes back from a perfect white, T falls with the thickness.
fn is_sound(results: &Value) {
    let rows = results["spectra"].as_array().expect("rows");
    assert_eq!((rows.len(), results["status"].as_str()), (9, Some("complete")));
    for row in rows {
        for light in ["normal", "45", "diffuse"] {
            let sum = ["reflectance", "transmittance"].map(|lobe| value(row, &format!("{lobe}_{light}")));
            // rounding of some hundred products
            assert!((sum[0] + sum[1] - 1.0).abs() < 1e-7, "{light} {sum:?}");
        }
        assert!((value(row, "natural_light") - 1.0).abs() < 1e-6, "{row}");
    }
    // What leaves in single directions and in the beams is all that leaves. *Planted*: étendue without π.
    let leaves = results["distributions"].as_array().expect("directions");
    for row in rows {
        let same = |key: &str, other: &Value| other[key] == row[key];
        let here = |other: &&Value| {
            same("thickness_um", other) && same("wavelength_nm", other) && other["reflected"] == true
        };
        let part = |other: &Value| other["projected_sr"].as_f64().expect("sr") * value(other, "bdf_per_sr");
        let spread: f64 = leaves.iter().filter(here).map(part).sum();
        let whole = value(row, "reflectance_normal") - value(row, "mirrored");
        assert!((spread - whole).abs() < 0.02, "{spread} {whole}: all but what interference changes");
    }
    let through: Vec<f64> = rows.iter().step_by(3).map(|row| value(row, "transmittance_diffuse")).collect();
    assert!(through.windows(2).all(|t| t[1] < t[0]), "{through:?}");
}

#[test]
fn one_set_of_solves_answers_all_thicknesses_and_is_resumed() {
    let scratch = tempfile::tempdir().unwrap();
    let file = study(scratch.path(), COMPOSED);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let first = results(&output);
    is_sound(&first);
    // Three wavelengths make no colour, and without one there is no hiding: the reason is given.
    let no_hiding = first["no_hiding"].as_str().unwrap_or_default();
    assert!(no_hiding.contains("without a colour"), "{first}");
    for name in ["report.html", "spectra.csv", "medium.csv", "bdf.csv"] {
        assert!(output.join(name).exists(), "{name}");
    }
    assert_eq!(described_tables(&output), 3);
    // other thicknesses with the same slabs need no solve
    let other = study(scratch.path(), &COMPOSED.replace("[1, 2, 50]", "[1, 7]"));
    let said = succeed(&other, &output, &[]);
    assert!(
        said.contains("already stored") && !said.contains("per hour") && !said.contains("of 0 solves"),
        "{said}"
    );
    assert_eq!(results(&output)["spectra"][0], first["spectra"][0]);
    let refused = |more: &[&str], why: &str| {
        let done = export(&output, more);
        let said = String::from_utf8_lossy(&done.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!done.status.success() && said.contains(why), "{said}");
    };
    for format in ["vti", "positions", "labels", "viewer"] {
        refused(&["--to", format], &format!("{format} shows one packing"));
    }
    refused(&["--to", "cxf", "--thickness", "3"], "found 3 µm; allowed is 1, 7 µm");
}

fn export(folder: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inkwave")).arg("export").arg(folder).args(more).output().unwrap()
}

/// What the exports of a composed layer on a perfect white must hold.
fn exports_are_sound(output: &Path) {
    let done = export(output, &["--to", "mitsuba,cxf,cgats,npz,crate", "--thickness", "50"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let names = ["ink-rgb.bsdf", "spectra.cxf", "spectra.sp", "ro-crate-metadata.json", "bdf.csv"];
    for name in names.into_iter().chain(["far-fields-inner-slab.npz", "brdf-samples.csv"]) {
        assert!(output.join("export").join(name).exists(), "{name}");
    }
    let mut table = csv::Reader::from_path(output.join("export/specular.csv")).unwrap();
    for row in table.deserialize::<[f64; 5]>().map(|row| row.expect("numbers")) {
        let [nm, deg, mirrored, diffuse, of_brdf] = row;
        // the furnace from every side: what comes back is all; rounding of doubling, of which angles
        // between the nodes have more
        assert!((mirrored + diffuse - 1.0).abs() < 1e-4, "{nm} nm, {deg}°: {mirrored} {diffuse}");
        // Three directions carry the BRDF, at 60° within some 0.06 with the noise of two packings; the
        // mirrored light left in it, or étendue without π, would be more.
        assert!(deg > 60.0 || (of_brdf - diffuse).abs() < 0.1, "{nm} nm, {deg}°: {of_brdf} {diffuse}");
    }
    for name in ["picture.png", "picture-with-axes.png", "picture-50um.png"] {
        assert!(output.join(name).exists(), "{name}");
    }
}

#[test]
fn unpolarised_light_is_composed_from_s_and_p() {
    let scratch = tempfile::tempdir().unwrap();
    let text = COMPOSED
        .replace("[light]\n", "[light]\nwave = \"unpolarised\"\n")
        .replace("index = 2.0", "index = 1.8");
    let text = text.replace("450, 550, 650", "440, 530, 620");
    let file = study(scratch.path(), &text);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    is_sound(&results(&output));
    exports_are_sound(&output);
}

#[test]
fn a_sweep_of_composed_layers_has_a_table_and_a_page() {
    let scratch = tempfile::tempdir().unwrap();
    let base = COMPOSED.replace("title = \"Composed\"\n", "").replace("[1, 2, 50]", "1");
    let base = base.replace("[[pigment]]", "[[base.pigment]]");
    let tables = ["layer", "paper", "light", "run", "resolution"];
    let base = tables.iter().fold(base, |text, t| text.replace(&format!("[{t}]"), &format!("[base.{t}]")));
    let axis =
        "[[axis]]\nname = \"share\"\nfield = \"pigment.grains.volume_fraction\"\nvalues = [0.05, 0.15]\n";
    let file = scratch.path().join("sweep.toml");
    std::fs::write(&file, format!("title = \"Crowding\"\n{base}{axis}")).unwrap();
    let output = scratch.path().join("out");
    let done = Command::new(env!("CARGO_BIN_EXE_inkwave"))
        .arg("sweep")
        .arg(&file)
        .arg("--output")
        .arg(&output)
        .output();
    let done = done.unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let table = std::fs::read_to_string(output.join("composed.csv")).unwrap();
    assert_eq!(table.lines().count(), 7, "{table}");
    // sweep.csv, composed.csv, conclusions.csv, and three tables of each layer
    assert_eq!(described_tables(&output), 9);
    let page = std::fs::read_to_string(output.join("report.html")).unwrap();
    for shown in ["against share, with standard errors", "Curves and spectra of the layer", "Colours"] {
        assert!(page.contains(shown), "{shown}");
    }
}

/// A layer that is solved as a whole and one composed of slabs have one table: on a perfect white, both are as light as
/// it. *Planted*: variants of one kind alone are published.
#[test]
fn a_sweep_of_both_kinds_of_layers_has_one_table() {
    let scratch = tempfile::tempdir().unwrap();
    let base = COMPOSED.replace("[1, 2, 50]", "1").replace("composed = { slab_um = 0.5 }\n", "");
    let base = base.replace("[450, 550, 650]", "[400, 500, 600, 700]");
    std::fs::write(scratch.path().join("base.toml"), base).unwrap();
    let axis = "base = \"base.toml\"\n[[axis]]\nname = \"solved\"\n[[axis.case]]\nlabel = \"as a whole\"\n\
                [[axis.case]]\nlabel = \"in slabs\"\nset.\"layer.composed\" = { slab_um = 0.5 }\n";
    let file = scratch.path().join("sweep.toml");
    let output = scratch.path().join("out");
    std::fs::write(&file, axis).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    let done = command.arg("sweep").arg(&file).arg("--output").arg(&output).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut table = csv::Reader::from_path(output.join("sweep.csv")).unwrap();
    let lightness = table.headers().unwrap().iter().position(|name| name == "L").unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2, "{rows:?}");
    for row in rows {
        let l: f64 = row[lightness].parse().unwrap();
        // no light is lost but for the solver's residual
        assert!((l - 100.0).abs() < 0.1, "{row:?}");
    }
    assert!(output.join("composed.csv").exists() && output.join("contact-sheet.png").exists());
}

/// A layer that is no whole number of the slabs of its list is the layer cut into slabs of its own.
/// *Planted*: a polynomial over whole numbers of slabs through what has fringes.
#[test]
fn a_thickness_in_a_list_is_the_thickness_alone() {
    let scratch = tempfile::tempdir().unwrap();
    let text = r#"
title = "Fringes between whole slabs"
[layer]
thickness_um = [3, 4]
period_um = 0.8
binder.index = 1.558
composed = { slab_um = 1.5 }
[[pigment]]
diameter_nm = 250
volume_fraction = 0.1
index = { n = 1.4, k = 0.003 }
[paper]
albedo = 0.9
[light]
wavelengths_nm = [450, 550, 650]
[run]
realisations = 6
[resolution]
accuracy = 5e-2
"#;
    let run = |name: &str, text: &str| {
        let folder = scratch.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        let file = study(&folder, text);
        let output = folder.join("out");
        succeed(&file, &output, &[]);
        let rows = results(&output)["spectra"].as_array().expect("rows").clone();
        rows.into_iter().filter(|row| row["thickness_um"] == 4.0).collect::<Vec<_>>()
    };
    let listed = run("listed", text);
    let alone = run("alone", &text.replace("[3, 4]", "4"));
    let error = |row: &Value, name: &str| row[name]["standard_error"].as_f64().expect("an error");
    let mut worst: f64 = 0.0;
    for (a, b) in listed.iter().zip(&alone) {
        for name in
            ["reflectance_normal", "transmittance_normal", "reflectance_45", "transmittance_45", "lit_at_45"]
        {
            let z = (value(a, name) - value(b, name)) / error(a, name).hypot(error(b, name));
            assert!(z.abs() < 4.5, "{name}, {} nm: {} {}", a["wavelength_nm"], a[name], b[name]);
            assert!(error(a, name) < 0.04, "{name}: {}", a[name]);
            worst = worst.max(z.abs());
        }
    }
    assert!(worst > 0.1, "different slabs differ");
}
