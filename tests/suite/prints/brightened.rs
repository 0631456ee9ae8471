//! Papers of prints with a brightener, and the light of the instrument that a measured print was seen in.

use super::papers::checked;
use super::{BANDS, COMPOSED, Place};
use crate::run_support::TINY;
use serde_json::Value;

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
