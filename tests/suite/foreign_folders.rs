//! Folders from elsewhere: names that lead out of them, links, changed digits; and folders that others work in.

use crate::sweep_support::{Place, TINY, inkwave, said, succeed};
use std::path::Path;

/// Changes one file of the sweep, sees that it is reported with `words`, and puts it back.
fn seen(place: &Place, file: &str, (from, to): (&str, &str), words: &str) {
    let path = place.path(&format!("out/{file}"));
    let whole = std::fs::read_to_string(&path).unwrap();
    assert!(whole.contains(from), "{file} without {from}: {whole}");
    std::fs::write(&path, whole.replacen(from, to, 1)).unwrap();
    let out = place.path("out");
    let merged = place.path("merged");
    let report: &[&str] = &["report", &out];
    for command in [report, &["merge", &out, "--output", &merged]] {
        let output = inkwave(command).output().unwrap();
        let told = said(&output).replace(['│', '\n'], " ").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(output.status.code() == Some(1) && told.contains(words), "{file}, {to}: {told}");
    }
    std::fs::write(&path, whole).unwrap();
}

#[test]
fn changed_thresholds_studies_names_and_numbers_of_a_sweep_are_seen() {
    let place = Place::swept("out");
    let outline = "sweep.json";
    seen(&place, outline, ("\"at_least\": 5.0", "\"at_least\": 50.0"), "was changed since it was written");
    let study = "variants/10-200-0.5/study.toml";
    seen(&place, study, ("albedo = 0.5", "albedo = 0.6"), "was changed since it was written");
    seen(&place, outline, ("\"seal\": \"", "\"other\": \""), "was changed since it was written");
    seen(&place, outline, ("\"reference\": 0", "\"reference\": 9"), "reference: found 9");
    for name in ["../../x", "/absolute/x", "..", "."] {
        let name = format!("\"name\": \"{name}\"");
        seen(&place, outline, ("\"name\": \"10-molecular-0.9\"", &name), "variants[0].name: found");
    }
    assert!(!Path::new(&place.path("x")).exists());
    succeed(&["report", &place.path("out")]);
}

#[test]
fn labels_that_name_no_folder_are_refused() {
    for label in ["..", "."] {
        let text = TINY.replace("[\"10 %\", \"15 %\"]", &format!("[\"{label}\", \"15 %\"]"));
        let (axes, _) = text.split_once("[[axis]]\nname = \"size\"").unwrap();
        let place = Place::new(axes);
        let output =
            inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out")]).output().unwrap();
        assert!(!output.status.success() && said(&output).contains("variant's folder"), "{}", said(&output));
        assert!(!Path::new(&place.path("out")).exists());
    }
}

#[test]
fn exports_and_new_packings_leave_no_foreign_or_older_file_in_doubt() {
    let place = Place::swept("out");
    std::fs::create_dir(place.path("thesis")).unwrap();
    std::fs::write(place.path("thesis/spectra.cxf"), "words").unwrap();
    let variant = place.path("out/variants/10-200-0.9");
    let command =
        |output: &str| inkwave(&["export", &variant, "--to", "cxf", "--output", &place.path(output)]);
    let export = |output: &str| command(output).output().unwrap();
    let refused = export("thesis");
    assert!(!refused.status.success() && said(&refused).contains("holds other files"), "{}", said(&refused));
    assert_eq!(std::fs::read_to_string(place.path("thesis/spectra.cxf")).unwrap(), "words");
    assert!(export("exports").status.success() && export("exports").status.success());

    let study = format!("{variant}/study.toml");
    let pack = |count: &str| succeed(&["pack", &study, "--output", &place.path("packings"), "-r", count]);
    pack("3");
    assert!(Path::new(&place.path("packings/grains_002.csv")).exists());
    pack("1");
    for old in ["grains_001.csv", "packing_002.json", "spheres_002.vtp", "PARTIAL"] {
        assert!(!Path::new(&place.path("packings")).join(old).exists(), "{old} is left");
    }
    assert!(Path::new(&place.path("packings/grains_000.csv")).exists());
}

#[cfg(unix)]
#[test]
fn a_killed_comparison_marks_what_an_earlier_one_left() {
    let place = Place::new(TINY);
    let (base, _) = TINY.split_once("[[axis]]").unwrap();
    let file = place.path("compare.toml");
    std::fs::write(&file, base.replace("base.", "").replace("step_nm = 100", "step_nm = 300")).unwrap();
    let out = place.path("comparison");
    let mark = Path::new(&out).join("PARTIAL");
    let mut child = inkwave(&["compare", &file, "--output", &out]);
    let mut child =
        child.stderr(std::process::Stdio::null()).stdout(std::process::Stdio::null()).spawn().unwrap();
    let begun = std::time::Instant::now();
    while !mark.exists() && begun.elapsed().as_secs() < 60 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let marked = mark.exists();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(marked, "no mark while the comparison is computed");
}

#[cfg(unix)]
#[test]
fn what_links_point_to_stays() {
    let place = Place::swept("out");
    std::fs::write(place.path("thesis.tex"), "words").unwrap();
    let lock = place.path("out/records/1.lock");
    std::fs::remove_file(&lock).unwrap();
    std::os::unix::fs::symlink(place.path("thesis.tex"), &lock).unwrap();
    let output =
        inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out")]).output().unwrap();
    assert!(!output.status.success() && said(&output).contains("is a link"), "{}", said(&output));
    assert_eq!(std::fs::read_to_string(place.path("thesis.tex")).unwrap(), "words");
}
