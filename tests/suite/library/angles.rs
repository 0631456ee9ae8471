//! The strip of colours over the viewing angle on a library's page.

use super::{PLATES, carried_out};
use crate::run_support::{study, succeed};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// The page's engine: factors of a composition by viewing angle and wavelength, as JSON.
const SCRIPT: &str =
    "const { Library } = require('./src/library/compose.js'), [file, composition] = process.argv.slice(1);
const library = new Library(JSON.parse(require('fs').readFileSync(file, 'utf8')));
console.log(JSON.stringify(library.overAngles(JSON.parse(composition))));";

/// What the strip of a page shows at an angle of the factor of a uniform sky's light, by wavelength.
fn seen(strip: &Value, deg: f64) -> &Vec<Value> {
    let angles = strip.as_array().expect("angles");
    let own = angles.iter().find(|own| own[0] == deg).expect("an angle");
    own[1].as_array().expect("factors")
}

/// The run's stack at the angles of its material for renderers, mirrored light and all other, is what the page shows, if there
/// is Node.js. *Planted*: what interference changes left out; the paper's light passed as along the normal.
#[test]
fn a_strip_is_the_run_at_its_angles() {
    if !Command::new("node").arg("--version").output().is_ok_and(|done| done.status.success()) {
        eprintln!("skipped: no node");
        return;
    }
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    succeed(&study(folder, &PLATES.replace("[1, 2.3]", "1.3")), &folder.join("out"), &[]);
    carried_out(&["library", "out", "--output", "library.json"], folder);
    carried_out(&["export", "out", "--to", "mitsuba"], folder);
    let layers = json!([{ "plate": "red" }, { "plate": "white", "thickness_um": 1.3 }]);
    let composition = json!({ "layers": layers, "paper": { "albedo": 0.8 } }).to_string();
    let library = folder.join("library.json");
    let done = Command::new("node")
        .args(["-e", SCRIPT, library.to_str().expect("UTF-8"), &composition])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let strip: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    for (place, row) in rows(&folder.join("out/export/specular.csv")).iter().enumerate() {
        let [deg, mirrored, other] = *row;
        if deg % 15.0 == 0.0 && deg <= 60.0 {
            let own = seen(&strip, deg)[place % 4].as_f64().expect("a number");
            // the error of both means over the hemisphere, which have pieces of other widths: the noise of two packings has kinks
            assert!((own - mirrored - other).abs() < 3e-6, "{deg}°: {own} for {mirrored} + {other}");
        }
    }
}

/// Angle, mirrored light and all other of the table, four wavelengths for each angle.
fn rows(path: &Path) -> Vec<[f64; 3]> {
    let mut table = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).expect("a table");
    let headers = table.headers().expect("columns").clone();
    let place = |name: &str| headers.iter().position(|own| own == name).expect("a column");
    let places = ["polar_deg", "specular_reflectance", "albedo_without_specular"].map(place);
    let number = |row: &csv::StringRecord, place: usize| row[place].parse().expect("a number");
    table
        .records()
        .map(|row| row.expect("a row"))
        .map(|row| places.map(|place| number(&row, place)))
        .collect()
}
