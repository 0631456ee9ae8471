//! Errors stated in a table of indices reach every bar; faults in rows that no wavelength needs block no file.

use crate::run_support::{results, run, study, succeed};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Grains whose index is a table, in two packings on a given grid.
const GRAINS: &str = r#"
[layer]
period_um = 0.8
thickness_um = 0.5
binder.index = 1.5
[[pigment]]
name = "fitted"
diameter_nm = 200
volume_fraction = 0.2
index = { csv = "pigment.csv" }
[light]
from_nm = 400
to_nm = 700
step_nm = 50
sampling = "listed"
[angles]
count = 4
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 10
planes_per_um = 40
[solver]
tolerance = 1e-7
"#;

/// Rows of n, κ, their errors and the correlation of these.
const ROWS: [[f64; 6]; 3] = [
    [400.0, 1.72, 0.10, 0.10, 0.020, -0.97],
    [550.0, 1.70, 0.06, 0.08, 0.015, -0.90],
    [700.0, 1.65, 0.03, 0.05, 0.010, 0.40],
];

/// The results of a study with this table, in a folder that keeps the solves of other tables at hand.
fn with_table(folder: &Path, name: &str, text: &str, table: &str) -> (Value, String) {
    let home = folder.join(name);
    fs::create_dir_all(&home).unwrap();
    fs::write(home.join("pigment.csv"), table).unwrap();
    let out = folder.join("out");
    let said = succeed(&study(&home, text), &out, &[]);
    (results(&out), said)
}

/// The table moved by what `by` makes of each row's errors, without columns of errors.
fn moved(by: impl Fn([f64; 3]) -> [f64; 2]) -> String {
    let mut text = "wavelength_nm,n,kappa\n".to_owned();
    for [nm, n, kappa, n_error, kappa_error, correlation] in ROWS {
        let [dn, dk] = by([n_error, kappa_error, correlation]);
        text += &format!("{nm},{},{}\n", n + dn, kappa + dk);
    }
    text
}

/// The table with its errors.
fn with_errors() -> String {
    let mut text =
        "# n is not determined: two branches fit\nwavelength_nm,n,kappa,n_error,kappa_error,correlation\n"
            .to_owned();
    for row in ROWS {
        text += &row.map(|x| x.to_string()).join(",");
        text += "\n";
    }
    text
}

fn number(results: &Value, path: &str, part: &str) -> f64 {
    results
        .pointer(&format!("{path}/{part}"))
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("{path}/{part}"))
}

/// What two bars differ by, in squares.
fn added(with: &Value, without: &Value, path: &str) -> f64 {
    let error = |results| number(results, path, "standard_error").powi(2);
    (error(with) - error(without)).max(0.0).sqrt()
}

/// Bars with the errors of n and κ are those without, plus in squares what runs with the table moved by one error on both
/// sides change: along the error of n with what κ changes along, and by the rest of κ's.
#[test]
fn error_bars_include_what_runs_with_a_moved_table_change() {
    let folder = tempfile::tempdir().unwrap();
    let (with, said) = with_table(folder.path(), "with", GRAINS, &with_errors());
    assert!(said.contains("n is not determined: two branches fit"), "{said}");
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("n is not determined: two branches fit"));
    assert!(page.contains("states errors of n and κ"));
    let (own, _) = with_table(folder.path(), "own", GRAINS, &moved(|_| [0.0; 2]));
    assert!(own["colours"][0]["budget"].get("inputs").is_none());
    let mut others = Vec::new();
    for side in [1.0, -1.0] {
        let along = moved(|[n, kappa, correlation]| [side * n, side * correlation * kappa]);
        let rest =
            moved(|[_, kappa, correlation]| [0.0, side * (1.0 - correlation * correlation).sqrt() * kappa]);
        for (axis, table) in [("along", along), ("rest", rest)] {
            others.push(with_table(folder.path(), &format!("{axis}{side}"), GRAINS, &table).0);
        }
    }
    let change = |path: &str, part: &str| {
        let here = number(&own, path, part);
        let square = others.iter().map(|other| 0.5 * (number(other, path, part) - here).powi(2)).sum::<f64>();
        square.sqrt()
    };
    let mut seen = 0;
    for row in 0..14 {
        for quantity in ["reflectance", "transmittance", "absorptance", "natural_light", "lit_at_45"] {
            let path = format!("/spectra/{row}/{quantity}");
            if with.pointer(&path).is_none_or(Value::is_null) {
                continue;
            }
            let have = added(&with, &own, &path);
            let want = change(&path, "value");
            // identity: the same solves; what is left is the rounding of differences of squares
            assert!((have - want).abs() < 1e-6 + 1e-4 * want, "{path}: {have} {want}");
            assert_eq!(number(&with, &path, "value"), number(&own, &path, "value"));
            seen += usize::from(want > 1e-3);
        }
    }
    assert!(seen > 20, "{seen} bars that errors widen");
    for colour in 0..2 {
        let path = format!("/colours/{colour}");
        let want = (0..3).map(|i| change(&path, &format!("lab/{i}")).powi(2)).sum::<f64>().sqrt();
        let part = number(&with, &path, "budget/inputs");
        // the colour's sums are linear, and L*, a*, b* of sums are computed in both ways
        assert!((part - want).abs() < 1e-3 * want && want > 0.5, "{path}: {part} {want}");
        for i in 0..3 {
            let error = |results| number(results, &path, &format!("lab_standard_error/{i}")).powi(2);
            let have = (error(&with) - error(&own)).max(0.0).sqrt();
            let want = change(&path, &format!("lab/{i}"));
            assert!((have - want).abs() < 2e-3 * want + 1e-3, "{path} {i}: {have} {want}");
        }
    }
    let want = change("/ink_maker/contrast_ratio", "value");
    let have = added(&with, &own, "/ink_maker/contrast_ratio");
    assert!((have - want).abs() < 2e-3 * want + 1e-6, "contrast ratio: {have} {want}");
}

/// Errors of zero change nothing, to the last digit.
#[test]
fn errors_of_zero_are_no_errors() {
    let folder = tempfile::tempdir().unwrap();
    let zero =
        "wavelength_nm,n,kappa,n_error,kappa_error,correlation\n400,1.7,0.1,0,0,0.5\n700,1.7,0.1,0,0,0\n";
    let none = "wavelength_nm,n,kappa\n400,1.7,0.1\n700,1.7,0.1\n";
    let numbers = |mut results: Value| {
        for timed in ["solve_seconds", "process_seconds"] {
            results.as_object_mut().unwrap().remove(timed);
        }
        results.to_string()
    };
    let [with, without] = [("zero", zero), ("none", none)]
        .map(|(name, table)| numbers(with_table(folder.path(), name, GRAINS, table).0));
    assert_eq!(with, without);
}

/// A film of one index file, at 550 nm.
fn index_at_550(folder: &Path, key: &str, file: &str, text: &str) -> Result<[f64; 2], String> {
    fs::write(folder.join(file), text).unwrap();
    let text = format!(
        "[layer]\nthickness_um = 0.1\nbinder.index = {{ {key} = \"{file}\" }}\n[light]\nwavelengths_nm = [550]\n\
         [angles]\npolar_deg = [0]\n[resolution]\npoints_per_um = 4\nplanes_per_um = 40\n"
    );
    let out = folder.join("out").join(file);
    let done = run(&study(folder, &text), &out, &[]);
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    if !done.status.success() {
        return Err(said);
    }
    let index = results(&out)["study"]["layer"]["binder"]["index"][0].clone();
    Ok([0, 1].map(|i| index[i].as_f64().unwrap()))
}

#[test]
fn rows_that_are_not_used_do_not_block_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let rows = "        0.50 1.52 0.012\n        0.60 1.54 0.012\n";
    let record = |rows: &str| format!("DATA:\n  - type: tabulated nk\n    data: |\n{rows}");
    for (i, fault) in [
        "4.9 1.6 0.1\n        4.9 1.7 0.1",
        "5 1.6 0.1\n        4 1.6 0.1",
        "4.9 1.6 -0.1",
        "4.9 1.6",
        "x 1.6 0.1",
    ]
    .into_iter()
    .enumerate()
    {
        let text = record(&format!("{rows}        3.0 1.5 0.01\n        {fault}\n        9.9 1.5 0.01\n"));
        let [n, k] = index_at_550(folder.path(), "yaml", &format!("{i}.yml"), &text).unwrap();
        assert!((n - 1.53).abs() < 1e-9 && (k - 0.012).abs() < 1e-9, "{fault}: {n} {k}");
    }
    let needed = record(
        &rows.replace("0.60 1.54 0.012", "0.54 1.5 0.1\n        0.54 1.6 0.1\n        0.60 1.54 0.012"),
    );
    let said = index_at_550(folder.path(), "yaml", "needed.yml", &needed).unwrap_err();
    assert!(said.contains("two rows at 540 nm") && said.contains("550"), "{said}");
    let site = "wl,n\n0.5,1.52\n0.6,1.54\n\nwl,k\n0.5,0.01\n0.6,0.014\n";
    let [n, k] = index_at_550(folder.path(), "csv", "site.csv", site).unwrap();
    assert!((n - 1.53).abs() < 1e-9 && (k - 0.012).abs() < 1e-9, "{n} {k}");
    let half =
        "DATA:\n  - type: formula 2\n    wavelength_range: 0.4 0.8\n    coefficients: 0 1.2 0.01 0.3\n";
    let said = index_at_550(folder.path(), "yaml", "half.yml", half).unwrap_err();
    assert!(said.contains("formula 2 has 4 coefficients"), "{said}");
}

/// A composed layer of grains whose index is a table, in two packings.
const COMPOSED: &str = r#"
[layer]
period_um = 0.8
thickness_um = [1.2, 2.4]
binder.index = 1.5
composed = { slab_um = 0.6 }
[[pigment]]
name = "fitted"
diameter_nm = 200
volume_fraction = 0.2
index = { csv = "pigment.csv" }
[light]
wavelengths_nm = [450, 550, 650]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 10
planes_per_um = 40
[solver]
tolerance = 1e-5
"#;

/// Bars of a composed layer hold what the errors of its table do: the change of its numbers between runs with the table moved
/// by one error to either side. *Planted*: the move of one side left out.
#[test]
fn error_bars_of_composed_layers_include_what_a_moved_table_changes() {
    let folder = tempfile::tempdir().unwrap();
    let (with, said) = with_table(folder.path(), "with", COMPOSED, &with_errors());
    assert!(!said.contains("not in the error bars"), "{said}");
    let (own, _) = with_table(folder.path(), "own", COMPOSED, &moved(|_| [0.0; 2]));
    let mut others = Vec::new();
    for side in [1.0, -1.0] {
        let along = moved(|[n, kappa, correlation]| [side * n, side * correlation * kappa]);
        let rest =
            moved(|[_, kappa, correlation]| [0.0, side * (1.0 - correlation * correlation).sqrt() * kappa]);
        for (axis, table) in [("along", along), ("rest", rest)] {
            others.push(with_table(folder.path(), &format!("{axis}{side}"), COMPOSED, &table).0);
        }
    }
    let mut seen = 0;
    for row in 0..6 {
        for quantity in ["reflectance_normal", "transmittance_diffuse", "over_white", "over_black"] {
            let path = format!("/spectra/{row}/{quantity}");
            let here = number(&own, &path, "value");
            let squares = others.iter().map(|other| 0.5 * (number(other, &path, "value") - here).powi(2));
            let want = squares.sum::<f64>().sqrt();
            let have = number(&with, &path, "inputs");
            // identity: the same solves
            assert!((have - want).abs() < 1e-6 + 1e-3 * want, "{path}: {have} {want}");
            assert_eq!(number(&with, &path, "value"), here);
            let parts = number(&with, &path, "chance").hypot(number(&with, &path, "model"));
            assert!(number(&with, &path, "standard_error") > 0.999 * parts.hypot(want), "{path}");
            seen += usize::from(want > 1e-3);
        }
    }
    assert!(seen > 10, "{seen} bars that errors widen");
    assert!(own.pointer("/spectra/0/reflectance_normal/inputs").is_none());
}
