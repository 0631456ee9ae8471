//! Papers of prints: measured, brightened, and some that would be taken for others.

use super::{BANDS, COMPOSED, DOTS, Place};
use crate::run_support::{TINY, results, study, succeed};
use serde_json::Value;
use std::path::Path;

/// A brightener without yield and without excitation changes no digit of a study; one with both makes the print bluer, and
/// its bare paper reads what was measured.
#[test]
fn brightened_paper_is_bluer_and_a_dark_brightener_changes_nothing() {
    let base = TINY
        .replace("from_nm = 400", "from_nm = 300")
        .replace("step_nm = 100", "step_nm = 50")
        .replace("index = { built_in = \"yellow\" }", "index = { n = 1.7, k = 0.05 }");
    let paper = |fluorescence: &str| format!("{base}[paper]\nalbedo = 0.9\n{fluorescence}\n");
    let place = Place::new();
    let plain = place.run("out", &paper(""));
    let dark = place.run("out", &paper(
        "fluorescence = { excitation = [[300, 0], [420, 0]], emission = [[410, 0], [440, 1], [500, 0]], yield = 0 }",
    ));
    assert_eq!(plain["spectra"], dark["spectra"]);
    assert_eq!(plain["colours"], dark["colours"]);
    let bright = place.run("out", &paper(&format!("fluorescence = {{ {BANDS}, yield = 0.6 }}")));
    let b = |results: &Value| results["colours"][1]["lab"][2].as_f64().expect("b*");
    assert!(b(&plain) - b(&bright) > 1.0, "{} {}", b(&plain), b(&bright));
}

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
fn checked(folder: &Path, text: &str) -> Result<Vec<String>, String> {
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

/// A file that states another condition is no M1 and no M2: M0 holds a part of what M1 holds. One that states none is taken
/// as what it is given for. *Planted*: the file's condition passed over.
#[test]
fn a_pair_of_measurements_is_of_m1_and_m2() {
    let scratch = tempfile::tempdir().unwrap();
    let bands: String = (380..=740).step_by(10).map(|nm| format!(" SPEC_{nm}")).collect();
    let write = |name: &str, source: &str, blue: f64| {
        let value = |nm: f64| 0.85 + blue * (-((nm - 445.0) / 25.0).powi(2)).exp();
        let values: String =
            (380..=740).step_by(10).map(|nm| format!(" {:.5}", value(f64::from(nm)))).collect();
        let text = format!(
            "CGATS.17\n{source}BEGIN_DATA_FORMAT\nSAMPLE_ID{bands}\nEND_DATA_FORMAT\nNUMBER_OF_SETS 1\nBEGIN_DATA\n1{values}\nEND_DATA\n"
        );
        std::fs::write(scratch.path().join(name), text).unwrap();
    };
    let stated = |name: &str| format!("MEASUREMENT_SOURCE \"MeasurementCondition={name} Filter=no\"\n");
    write("none.cgats", "", 0.15);
    write("m0.cgats", &stated("M0"), 0.10);
    write("m1.cgats", &stated("M1"), 0.15);
    write("m2.cgats", &stated("M2"), 0.0);
    let pair = |m1: &str, m2: &str| {
        let words = format!(
            "coupling = \"optical_contact\"\nfluorescence = {{ m1_csv = \"{m1}.cgats\", m2_csv = \"{m2}.cgats\", unit = \"factor\" }}"
        );
        let ink = super::ink_of_thickness(1.0).replace("from_nm = 400", "from_nm = 300");
        checked(scratch.path(), &ink.replace("coupling = \"optical_contact\"\nalbedo = 0.93", &words))
    };
    for m1 in ["m1", "none"] {
        pair(m1, "m2").unwrap_or_else(|fault| panic!("{m1}: {fault}"));
    }
    for (m1, m2, words) in
        [("m0", "m2", "m0.cgats, which states M0"), ("m1", "m0", "m0.cgats, which states M0")]
    {
        let told = pair(m1, m2).expect_err(words);
        assert!(told.contains(words) && told.contains("or one that states none"), "{told}");
    }
}

/// A clear ink on brightened paper, in light from 300 nm.
fn brightened_ink(paper: &str) -> String {
    let ink = super::ink_of_thickness(1.0).replace("from_nm = 400", "from_nm = 300");
    ink.replace("albedo = 0.93", paper)
}

/// Factors of one print under one condition of a run.
fn printed(results: &Value, condition: &str, nominal: f64) -> Vec<f64> {
    let prints = results["prints"]["prints"].as_array().expect("prints");
    let is_own = |print: &&Value| print["condition"] == condition && print["nominal"] == nominal;
    let factors = &prints.iter().find(is_own).expect("a print")["factors"];
    factors
        .as_array()
        .expect("factors")
        .iter()
        .map(|factor| factor["value"].as_f64().expect("a factor"))
        .collect()
}

fn wavelengths() -> impl Iterator<Item = f64> {
    (0..=20).map(|k| 300.0 + 20.0 * f64::from(k))
}

/// A measured spectrum as a table that states its condition.
fn table(condition: &str, rows: impl Iterator<Item = (f64, f64)>) -> String {
    let rows: String = rows.map(|(nm, value)| format!("{nm},{value}\n")).collect();
    format!("# MeasurementCondition={condition}\nwavelength_nm,reflectance\n{rows}")
}

/// A print on brightened paper is compared in the light of the instrument that its file names. *Planted*: that of the
/// illuminant for every file.
#[test]
fn a_print_is_compared_in_the_light_of_its_instrument() {
    let place = Place::new();
    let text = brightened_ink(&format!("albedo = 0.93\nfluorescence = {{ {BANDS}, yield = 0.6 }}"));
    let results = place.run("ink", &text);
    let mut seen = Vec::new();
    for condition in ["M0", "M1", "M2"] {
        let factors = printed(&results, condition, 1.0);
        let from = if condition == "M2" { 420.0 } else { 300.0 };
        let rows = wavelengths().zip(factors).filter(|(nm, _)| *nm >= from);
        let name = format!("{condition}.csv");
        std::fs::write(place.0.path().join(&name), table(condition, rows)).unwrap();
        let compared =
            place.run("ink", &format!("{text}[compare]\nmeasured = \"{name}\"\nunit = \"factor\"\n"));
        let maker = &compared["ink_maker"];
        let rms = maker["measured"]["rms"].as_f64().expect("a distance");
        // one series: rounding
        assert!(rms < 1e-9, "{condition}: {rms}");
        assert!(maker["conditions"].as_str().is_some_and(|said| said.contains(condition)), "{maker}");
        seen.push(lab_of(maker));
    }
    assert!((seen[1] - seen[2]).abs() > 1.0, "{seen:?}: nothing to tell apart");
}

/// b* of the print of an ink maker.
fn lab_of(maker: &Value) -> f64 {
    maker["print"]["colour"]["lab"][2].as_f64().or(maker["print"]["lab"][2].as_f64()).expect("b*")
}

/// Paper measured without ultraviolet light is returned under M2, with a brightener beside it: what this takes is missing
/// in the measurement already. Measured with it, its emission would count twice. *Planted*: the albedo reduced once more.
#[test]
fn measured_paper_with_a_brightener_is_returned_without_ultraviolet_light() {
    let place = Place::new();
    let write = |name: &str, condition: &str| {
        let rows = wavelengths().filter(|nm| *nm >= 420.0).map(|nm| (nm, 0.7 + 0.0003 * (nm - 360.0)));
        std::fs::write(place.0.path().join(name), table(condition, rows)).unwrap();
    };
    let paper = |name: &str, brightener: &str| {
        let measured = format!("measured = {{ csv = \"{name}\", unit = \"factor\" }}");
        brightened_ink(&format!("{measured}\nfluorescence = {{ {brightener} }}"))
    };
    write("plain.csv", "M2");
    // one that takes light of 420 to 480 nm, too, and sends none back
    let dark = "excitation = [[300, 0.2], [360, 0.8], [480, 0]], emission = [[490, 0], [520, 1], [560, 0]], yield = 0";
    let results = place.run("ink", &paper("plain.csv", dark));
    for (nm, factor) in wavelengths().zip(printed(&results, "M2", 0.0)).filter(|(nm, _)| *nm >= 420.0) {
        let measured = 0.7 + 0.0003 * (nm - 360.0);
        assert!((factor - measured).abs() < 1e-9, "{nm}: {factor} for {measured}");
    }
    write("bright.csv", "M1");
    let told = checked(place.0.path(), &paper("bright.csv", &format!("{BANDS}, yield = 0.6")))
        .expect_err("its emission would count twice");
    for words in ["paper.measured.condition", "M1", "M2, without ultraviolet", "m1_csv"] {
        assert!(told.contains(words), "{words:?} is missing: {told}");
    }
}

/// Without ultraviolet light nothing is read below 420 nm: there the paper is what M1 reads. *Planted*: the first value of M2
/// gone on with.
#[test]
fn a_pair_returns_what_was_read_with_ultraviolet_light_below_420_nm() {
    let place = Place::new();
    let rises = |nm: f64| 0.1 + 0.78 / (1.0 + f64::exp(-(nm - 395.0) / 10.0));
    let emitted = |nm: f64| if nm < 420.0 { 0.0 } else { 0.15 * f64::exp(-((nm - 445.0) / 25.0).powi(2)) };
    let m1 = table("M1", wavelengths().map(|nm| (nm, rises(nm) + emitted(nm))));
    let m2 = table("M2", wavelengths().filter(|nm| *nm >= 420.0).map(|nm| (nm, rises(nm))));
    std::fs::write(place.0.path().join("m1.csv"), m1).unwrap();
    std::fs::write(place.0.path().join("m2.csv"), m2).unwrap();
    let text =
        brightened_ink("fluorescence = { m1_csv = \"m1.csv\", m2_csv = \"m2.csv\", unit = \"factor\" }");
    let results = place.run("ink", &text);
    for (nm, factor) in wavelengths().zip(printed(&results, "M1", 0.0)) {
        let measured = rises(nm) + emitted(nm);
        assert!((factor - measured).abs() < 2e-3, "{nm}: {factor} for {measured}");
    }
}

/// A design aims at a print in the light in which that was measured: the thickness of every print under M0, M1 and M2 is found
/// again, from files that begin above the light of the base too. *Planted*: the light of the illuminant for all files.
#[test]
fn a_design_aims_at_a_print_in_the_light_of_its_instrument() {
    let place = Place::new();
    let text = brightened_ink(&format!("albedo = 0.93\nfluorescence = {{ {BANDS}, yield = 0.6 }}"));
    let text = text.replace("step_nm = 20", "step_nm = 20\nsampling = \"listed\"");
    let results = place.run("ink", &text);
    let base = text.replace("[layer]", "[base.layer]").replace("[paper]", "[base.paper]");
    let base = base.replace("[light]", "[base.light]");
    let designed = |measured: String| {
        std::fs::write(place.0.path().join("print.csv"), measured).unwrap();
        let vary = "[[vary]]\nfield = 'layer.thickness_um'\nfrom = 0.5\nto = 2.0\n";
        let target = "[target]\nfile = 'print.csv'\nunit = 'factor'\n";
        let file = place.0.path().join("design.toml");
        std::fs::write(&file, format!("{target}{vary}{base}")).unwrap();
        inkwave::design::recipe::load(&file).expect("a design")
    };
    for (condition, from) in [("M0", 300.0), ("M1", 380.0), ("M2", 420.0)] {
        let rows = wavelengths().zip(printed(&results, condition, 1.0)).filter(|(nm, _)| *nm >= from);
        let rows: Vec<(f64, f64)> = rows.collect();
        let longer = (76..84).map(|k| (5.0 * f64::from(k), rows[0].1)).chain(rows.iter().copied());
        let task = designed(table(condition, rows.iter().copied()));
        let study = task.study(&[1.0 / 3.0]).expect("the print's thickness");
        assert_eq!(study.judgement.condition.map(|light| light.name()), Some(condition));
        let begins_late = task.remarks.iter().any(|remark| remark.contains("ASTM E308"));
        assert_eq!(begins_late, condition == "M2", "{:?}", task.remarks);
        let lab = task.lab.expect("a colour");
        if condition == "M2" {
            // end values stand for what is missing
            assert_eq!(designed(table(condition, longer)).lab, Some(lab));
            continue;
        }
        let own = place.run("own", &format!("{text}[compare]\nmeasured = 'print.csv'\nunit = 'factor'\n"));
        let print = &own["ink_maker"]["print"]["lab"];
        let away = (0..3).map(|i| (lab[i] - print[i].as_f64().expect("Lab")).powi(2)).sum::<f64>().sqrt();
        // rounding
        assert!(away < 1e-6, "{condition}: {lab:?} {print}");
    }
}

/// A base in slabs names no measurement: its recipes take the light of the target's file. *Planted*: that of the illuminant.
#[test]
fn a_design_of_slabs_aims_in_the_light_of_the_file() {
    let place = Place::new();
    let base = COMPOSED.replace("[1, 2]", "1").replace("[layer]", "[base.layer]");
    let base = base.replace("[[pigment]]", "[[base.pigment]]").replace("[light]", "[base.light]");
    let base = base.replace("[run]", "[base.run]").replace("[resolution]", "[base.resolution]");
    let paper = format!("[base.paper]\nalbedo = 0.9\nfluorescence = {{ {BANDS}, yield = 0.6 }}\n");
    let target = "[target]\nfile = 'print.csv'\nunit = 'factor'\n[[vary]]\nfield = 'layer.thickness_um'\nfrom = 1.0\nto = 2.0\n";
    for condition in ["M0", "M1", "M2"] {
        let measured = table(condition, wavelengths().map(|nm| (nm, 0.5)));
        std::fs::write(place.0.path().join("print.csv"), measured).unwrap();
        let file = place.0.path().join("design.toml");
        std::fs::write(&file, format!("{target}{base}{paper}")).unwrap();
        let task = inkwave::design::recipe::load(&file).expect("a design");
        let study = task.study(&[0.5]).expect("a recipe");
        assert_eq!(study.judgement.condition.map(|light| light.name()), Some(condition));
    }
}
