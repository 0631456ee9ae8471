//! Colours of studies whose wavelengths do not cover the visible range, and what exported files say of theirs.

use crate::run_support::{TINY, study, succeed};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

fn results(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("results.json")).unwrap()).unwrap()
}

/// A colour at 45:0 with its error.
struct PrintColour {
    lab: [f64; 3],
    standard_error: [f64; 3],
    /// The part of the error that is due to light beyond the wavelengths.
    beyond_range: f64,
}

fn lit_at_45(results: &Value) -> PrintColour {
    let colour = &results["colours"][1];
    assert_eq!(colour["conditions"], "45:0");
    let three = |key: &str| std::array::from_fn(|i| colour[key][i].as_f64().unwrap());
    PrintColour {
        lab: three("lab"),
        standard_error: three("lab_standard_error"),
        beyond_range: colour["budget"]["beyond_range"].as_f64().unwrap_or(0.0),
    }
}

/// What a run leaves: its results, what it printed, and its page.
struct FinishedRun {
    results: Value,
    printed: String,
    page: String,
}

/// A colour of 440–700 nm is that of 400–700 nm within its bars, and says what it takes; one of 400–600 nm is none.
#[test]
fn a_colour_is_extrapolated_within_its_bars_or_not_published() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, from: &str, to: &str| {
        let text = TINY.replace("step_nm = 100", "step_nm = 20");
        let text = text.replace("from_nm = 400", from).replace("to_nm = 700", to);
        let out = folder.path().join(name);
        let printed = succeed(&study(folder.path(), &text), &out, &[]);
        let page = fs::read_to_string(out.join("report.html")).unwrap();
        FinishedRun { results: results(&out), printed, page }
    };
    let whole = run("whole", "from_nm = 400", "to_nm = 700");
    let truth = lit_at_45(&whole.results);
    assert_eq!(truth.beyond_range, 0.0);
    assert!(!whole.printed.contains("the spectra are continued by their values"), "{}", whole.printed);
    assert_eq!(whole.results["colours"][1]["budget"].get("beyond_range"), None);

    let cut = run("cut", "from_nm = 440", "to_nm = 700");
    let colour = lit_at_45(&cut.results);
    for i in 0..3 {
        let error = colour.standard_error[i].hypot(truth.standard_error[i]);
        let off = (colour.lab[i] - truth.lab[i]).abs();
        assert!(off <= 1.96 * error, "L*, a*, b* [{i}]: off by {off}, ± {error}");
    }
    assert!((0.1..10.0).contains(&colour.beyond_range), "{}", colour.beyond_range);
    assert!(cut.printed.contains("from 440 to 700 nm, and colours need 400 to 700 nm"), "{}", cut.printed);
    assert!(cut.page.contains("the rest is continued by the end values"));

    let short = run("short", "from_nm = 400", "to_nm = 600");
    assert_eq!(short.results["colours"].as_array().unwrap().len(), 0);
    let reason = short.results["no_colour"].as_str().unwrap();
    assert!(reason.contains("from 400 to 600 nm") && reason.contains("cover 400 to 700 nm"), "{reason}");
    assert!(short.page.contains("There is no colour") && short.results["ink_maker"].is_null());
    let rows = short.results["spectra"].as_array().unwrap();
    assert!(rows.len() == 22 && rows.iter().all(|row| row["transmittance"]["value"].is_number()));
}

/// A file whose Lab rounds otherwise than the page's says why, with the page's; interpolated spectra say so.
#[test]
fn exported_lab_is_the_pages_or_the_file_says_why_not() {
    let folder = tempfile::tempdir().unwrap();
    let fitted = TINY.replace("step_nm = 100\nsampling = \"listed\"", "step_nm = 30");
    for (text, name, spectra) in
        [(TINY, "listed", "interpolated to every 10 nm"), (&fitted, "fitted", "not interpolated")]
    {
        let out = folder.path().join(name);
        succeed(&study(folder.path(), text), &out, &[]);
        let done = Command::new(env!("CARGO_BIN_EXE_inkwave"))
            .arg("export")
            .arg(&out)
            .args(["--to", "cxf,cgats"])
            .output();
        assert!(done.unwrap().status.success());
        let lab = results(&out)["ink_maker"]["print"]["lab"].clone();
        let [l, a, b] = std::array::from_fn(|i| lab[i].as_f64().unwrap());
        for file in ["spectra.cgats", "spectra.sp", "spectra.cxf"] {
            let text = fs::read_to_string(out.join("export").join(file)).unwrap();
            assert!(text.contains(spectra), "{name} {file}");
            let own = if file == "spectra.cxf" { cxf_lab(&text) } else { cgats_lab(&text) };
            let same = own.iter().zip([l, a, b]).all(|(x, y)| (x - y).abs() < 0.005);
            let says = text.contains(&format!("L* {l:.2} a* {a:.2} b* {b:.2} (45:0)"));
            assert!(same || (says && text.contains("Lab is computed from")), "{name} {file}: {own:?} {lab}");
        }
    }
}

fn cgats_lab(text: &str) -> Vec<f64> {
    let row = text.lines().find(|line| line.starts_with("1 \"45:0\"")).unwrap();
    row.rsplit('"').next().unwrap().split_whitespace().take(3).map(|x| x.parse().unwrap()).collect()
}

fn cxf_lab(text: &str) -> Vec<f64> {
    let of = |c: &str| {
        text.split(&format!("<cc:{c}>")).nth(1).unwrap().split('<').next().unwrap().parse().unwrap()
    };
    ["L", "A", "B"].map(of).to_vec()
}

/// A dissolved dye, exactly solved at listed wavelengths of some step.
fn dye(light: &str) -> String {
    format!(
        "[layer]\nthickness_um = 1.0\nbinder.index = 1.5\n[[pigment]]\nname = \"dye\"\ndiameter_nm = \"molecular\"\n\
         volume_fraction = 0.22\nindex = {{ built_in = \"yellow\" }}\n[light]\n{light}\nsampling = \"listed\"\n\
         [run]\nrealisations = 6\n[resolution]\naccuracy = 3e-2\n"
    )
}

/// Colours of listed wavelengths hold in their bars what lies between these, and not much more. *Planted*: the film between the
/// wavelengths left out of the bars.
#[test]
fn bars_of_listed_wavelengths_hold_what_lies_between_them() {
    let folder = tempfile::tempdir().unwrap();
    let run = |step: f64| {
        let home = folder.path().join(step.to_string());
        fs::create_dir_all(&home).unwrap();
        let light = format!("from_nm = 400\nto_nm = 680\nstep_nm = {step}");
        succeed(&study(&home, &dye(&light)), &home.join("out"), &[]);
        let print = results(&home.join("out"))["ink_maker"]["print"].clone();
        let three =
            |key: &str| -> [f64; 3] { std::array::from_fn(|i| print[key][i].as_f64().unwrap_or(0.0)) };
        (three("lab"), three("lab_standard_error"))
    };
    let (truth, _) = run(2.0);
    for step in [20.0, 28.0, 35.0, 40.0, 56.0, 70.0] {
        let (lab, error) = run(step);
        for i in 0..3 {
            let off = (lab[i] - truth[i]).abs();
            // 0.1: the film every 5 nm, and the range of the bars' own colours
            assert!(off <= 2.0 * error[i] + 0.1, "{step} nm, {i}: {lab:?} ± {error:?}, {truth:?}");
            assert!(error[i] <= 5.0 * off + 1.0, "{step} nm, {i}: {lab:?} ± {error:?}, {truth:?}");
        }
    }
}

/// Wavelengths beyond those of eyes are solved and published, and colours take the others.
#[test]
fn colours_take_what_eyes_see_of_a_wider_range() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, light: &str| {
        let home = folder.path().join(name);
        fs::create_dir_all(&home).unwrap();
        let text = dye(light).replace("index = { built_in = \"yellow\" }", "index = { n = 1.6, k = 0.1 }");
        let said = succeed(&study(&home, &text), &home.join("out"), &[]);
        (results(&home.join("out")), said)
    };
    let (wide, said) = run("wide", "from_nm = 340\nto_nm = 700\nstep_nm = 20");
    let (own, _) = run("own", "from_nm = 380\nto_nm = 700\nstep_nm = 20");
    assert!(said.contains("colours take the wavelengths from 380 to 780 nm"), "{said}");
    for path in ["/colours/0/lab", "/colours/1/lab", "/ink_maker/print/lab"] {
        for i in 0..3 {
            let at = |results: &Value| results.pointer(&format!("{path}/{i}")).unwrap().as_f64().unwrap();
            // rounding: the same sums of the same spectra
            assert!((at(&wide) - at(&own)).abs() < 1e-9, "{path}/{i}: {} {}", at(&wide), at(&own));
        }
    }
    assert_eq!(wide["spectra"][0]["wavelength_nm"], 340.0);
}
