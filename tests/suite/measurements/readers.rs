//! Who reads measurements: comparisons with the program's own exports, papers and cards, fits and designs.

use super::{FIELDS, cgats, cxf};
use crate::run_support::{TINY, study, succeed};
use inkwave::appearance::colour::ciede2000;
use inkwave::input::fault::StudyError;
use inkwave::input::load::load;
use inkwave::input::measured::{MeasuredContent, MeasuredReading, MeasuredRequest};
use std::path::Path;
use std::process::Command;

/// What the program writes of a black print reads back as the print itself.
#[test]
fn exports_of_a_black_print_read_back_without_a_difference() {
    let folder = tempfile::tempdir().unwrap();
    let film = "[layer]\nthickness_um = 1.0\nbinder.index = 1.5\n[paper]\nalbedo = 0.01\n[light]\nfrom_nm = 400\n\
                to_nm = 700\nstep_nm = 20\n[resolution]\naccuracy = 3e-2\n";
    let out = folder.path().join("out");
    succeed(&study(folder.path(), film), &out, &[]);
    let done = Command::new(env!("CARGO_BIN_EXE_inkwave"))
        .arg("export")
        .arg(&out)
        .args(["--to", "cxf,cgats"])
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let largest = |name: &str| {
        let request = MeasuredRequest { used_nm: [400.0, 700.0], ..MeasuredRequest::default() };
        let read = MeasuredReading::new(&out.join("export").join(name), &request).unwrap();
        // other samples are bright enough to show the unit: it is declared all the same
        assert!(read.remarks.iter().all(|remark| !remark.contains("no unit")), "{:?}", read.remarks);
        let MeasuredContent::Spectrum(spectrum) = read.measured else { panic!("a spectrum") };
        (spectrum.rows.iter().map(|row| row[1]).fold(0.0, f64::max), spectrum.source)
    };
    for name in ["spectra.cgats", "spectra.sp", "spectra.cxf"] {
        // dark enough to pass for factors when it is in percent
        let (most, source) = largest(name);
        assert!(most < 0.01, "{name}: {most}");
        assert!(source.contains("45:0"), "{source}");
        let compared = format!("{film}[compare]\nmeasured = \"out/export/{name}\"\n");
        let again = folder.path().join("again");
        succeed(&study(folder.path(), &compared), &again, &[]);
        let results: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(again.join("results.json")).unwrap()).unwrap();
        let apart = results["ink_maker"]["measured"]["delta_e_2000"]["value"].as_f64().unwrap();
        // the files' decimals, and values between the study's wavelengths by two rules
        assert!(apart < 0.02, "{name}: {apart}");
        std::fs::remove_dir_all(&again).unwrap();
    }
}

fn faults(path: &Path) -> Vec<String> {
    match load(path) {
        Ok(_) => Vec::new(),
        Err(StudyError::Values { faults, .. }) => {
            faults.iter().map(|fault| format!("{fault}; {}", fault.remedy)).collect()
        }
        Err(other) => vec![other.to_string()],
    }
}

/// Paper and cards are measured as inks are.
#[test]
fn papers_are_read_from_files_of_measurements() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("paper.txt", &cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0));
    write(
        "paper.cxf",
        &cxf(
            "Spectrum_Reflectance",
            "<cc:SphereGeometry>Specular_Included</cc:SphereGeometry>",
            &["M0_Incandescent", "M2_UVExcluded"],
        ),
    );
    write("paper.csv", "wavelength_nm,albedo\n700,0.88\n550,0.84\n400,0.82\n");
    let with = |albedo: &str| study(folder.path(), &format!("{TINY}[paper]\nalbedo = {{ {albedo} }}\n"));
    let at_550 = |albedo: &str| {
        let study = load(&with(albedo)).unwrap_or_else(|error| panic!("{albedo}: {error}"));
        (study.paper.albedo.at(550.0).unwrap(), study.remarks)
    };
    assert!((at_550("csv = \"paper.txt\", patch = \"paper\"").0 - 0.84).abs() < 1e-12);
    assert_eq!(at_550("csv = \"paper.csv\"").0, 0.84);
    let (value, remarks) = at_550("csv = \"paper.cxf\", condition = \"M2\"");
    assert!(
        (value - 0.44).abs() < 1e-12
            && remarks.iter().any(|remark| remark.contains("specular light included")),
        "{remarks:?}"
    );
    for (albedo, words) in [
        ("csv = \"paper.txt\"", ["paper.albedo", "2 samples", "paper.albedo.patch"]),
        ("csv = \"paper.cxf\"", ["paper.albedo", "M0, M2", "paper.albedo.condition"]),
        ("csv = \"paper.txt\", patch = \"ink\"", ["paper.albedo", "no sample \"ink\"", "\"black\""]),
    ] {
        let found = faults(&with(albedo));
        assert!(found.len() == 1 && words.iter().all(|word| found[0].contains(word)), "{found:?}");
    }
}

const FIT: &str = "base = \"ink.toml\"\n[[measured]]\nfile = \"FILE\"\nbacking = 0.8\n";
const DESIGN: &str = "base = \"ink.toml\"\n[target]\nfile = \"FILE\"\n[[vary]]\nfield = \"pigment[0].volume_fraction\"\nfrom = 0.1\nto = 0.2\n";

/// Of a file with several samples `fit` and `design` take none without its name, and a fit takes the geometry that its file states.
#[test]
fn fits_and_designs_ask_which_sample_is_meant_and_believe_the_geometry() {
    use inkwave::fit::file::FitGeometry;
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let ink = TINY.replace("realisations = 2", "realisations = 6");
    write("ink.toml", &ink);
    write("two.txt", &cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0));
    for (name, specular) in
        [("sci.cxf", "Specular_Included"), ("sce.cxf", "Specular_Excluded"), ("sphere.cxf", "Diffuse")]
    {
        let geometry = format!("<cc:SphereGeometry>{specular}</cc:SphereGeometry>");
        write(name, &cxf("Spectrum_Reflectance", &geometry, &["M0_Incandescent"]));
    }
    let path = folder.path().join("inverse.toml");
    let fit = |text: &str| {
        std::fs::write(&path, text).unwrap();
        inkwave::fit::load::load(&path).map_err(|error| error.to_string())
    };
    let design = |text: &str| {
        std::fs::write(&path, text).unwrap();
        inkwave::design::recipe::load(&path).map_err(|error| error.to_string())
    };
    let with = |text: &str, file: &str, more: &str| {
        let from = format!("file = \"{file}\"");
        let to = format!("file = \"{file}\"\n{more}");
        text.replace("FILE", file).replace(&from, &to)
    };
    let error = fit(&with(FIT, "two.txt", "")).unwrap_err();
    assert!(error.contains("2 samples") && error.contains("measured[0].patch"), "{error}");
    let error = design(&with(DESIGN, "two.txt", "")).unwrap_err();
    assert!(error.contains("2 samples") && error.contains("target"), "{error}");
    let named = fit(&with(FIT, "two.txt", "patch = \"black\"")).unwrap();
    assert!((named.measured[0].measured(0) - 0.0052).abs() < 1e-9);
    let black = design(&with(DESIGN, "two.txt", "patch = \"black\"")).unwrap();
    assert!(black.lab.is_some_and(|lab| lab[0] < 8.0), "{:?}", black.lab);
    // a declared sphere
    let sci = fit(&with(FIT, "sci.cxf", "")).unwrap();
    assert_eq!(sci.measured[0].geometry, FitGeometry::Sphere);
    assert!(
        sci.remarks.iter().any(|remark| remark.contains("measured[0].geometry") && remark.contains("d:8")),
        "{:?}",
        sci.remarks
    );
    for (file, key, says) in [
        ("sci.cxf", "geometry = \"45:0\"", "specular light included"),
        ("sce.cxf", "geometry = \"d:8\"", "specular light excluded"),
        ("sphere.cxf", "", "d:8"),
    ] {
        let error = fit(&with(FIT, file, key)).unwrap_err();
        assert!(error.contains("measured[0].file") && error.contains(says), "{file} {key}: {error}");
    }
    assert!(fit(&with(FIT, "sphere.cxf", "geometry = \"d:8\"")).is_ok());
    let sce = fit(&with(FIT, "sce.cxf", "")).unwrap();
    assert_eq!(sce.measured[0].geometry, FitGeometry::SphereExcluded);
    let error = design(&with(DESIGN, "sci.cxf", "")).unwrap_err();
    assert!(error.contains("d:8"), "{error}");
}

/// A target is a colour of its own rows: the base's steps do not change it.
#[test]
fn the_colour_of_a_target_does_not_depend_on_the_steps_of_the_base() {
    let folder = tempfile::tempdir().unwrap();
    let edge = |nm: f64| 0.04 + 0.8 / (1.0 + (-(nm - 505.0) / 7.0).exp());
    let rows: String =
        (0..=35).map(|i| 380.0 + 10.0 * f64::from(i)).map(|nm| format!("{nm},{}\n", edge(nm))).collect();
    std::fs::write(folder.path().join("steep.csv"), format!("nm,reflectance_factor\n{rows}")).unwrap();
    let lab = |light: &str| {
        let ink = TINY.replace("from_nm = 400\nto_nm = 700\nstep_nm = 100\nsampling = \"listed\"", light);
        assert!(ink.contains(light), "{ink}");
        std::fs::write(folder.path().join("ink.toml"), ink).unwrap();
        let path = folder.path().join("design.toml");
        std::fs::write(&path, DESIGN.replace("FILE", "steep.csv")).unwrap();
        inkwave::design::recipe::load(&path).unwrap_or_else(|error| panic!("{error}")).lab.expect("a colour")
    };
    let coarse = lab("from_nm = 400\nto_nm = 700\nstep_nm = 60\nsampling = \"listed\"");
    let fine = lab("from_nm = 400\nto_nm = 700\nstep_nm = 20\nsampling = \"listed\"");
    assert!(ciede2000(coarse, fine) < 1e-9, "{coarse:?} {fine:?}");
}
