//! Files that are refused, with place and count.

use super::{LIGHT, PIGMENTS, given, study};

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
