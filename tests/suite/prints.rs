//! Prints as a user runs them: dots, measured and brightened paper, of layers that are solved as a whole and of composed ones.

mod areas;
mod brightened;
mod characterisation;
mod papers;

use super::run_support::{TINY, described_tables, results, succeed};
use serde_json::Value;
use std::path::PathBuf;

const DOTS: &str =
    "[dots]\nruling_per_cm = 60\nspread_um = 40\nphysical_gain = 0.05\n[[area]]\ncoverage = [0.25, 0.5]\n";
const BANDS: &str =
    "excitation = [[300, 0.2], [360, 0.8], [420, 0]], emission = [[410, 0], [440, 1], [500, 0]]";
const COMPOSED: &str = r#"
[layer]
period_um = 0.8
thickness_um = [1, 2]
binder.index = 1.5
composed = { slab_um = 0.5 }
[[pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.15
index = { n = 2.0, k = 0.02 }
[light]
wavelengths_nm = [300, 360, 400, 450, 500, 550, 600, 650, 700]
[run]
realisations = 2
seed = 7
[resolution]
points_per_um = 12
planes_per_um = 36
"#;
/// A layer that absorbs a little and needs no grains.
const CLEAR_INK: &str = r#"
[layer]
thickness_um = THICKNESS
binder.index = { n = 1.5, k = 0.02 }
index_out = 1.5
[paper]
coupling = "optical_contact"
albedo = 0.93
[light]
from_nm = 400
to_nm = 700
step_nm = 20
"#;

/// A folder of studies whose results lie beside them.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    /// Where the results of this name are.
    fn output(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The results of a study under this name. Another study of the same name has the solves of the first at hand.
    fn run(&self, name: &str, text: &str) -> Value {
        let file = self.0.path().join(format!("{name}.toml"));
        std::fs::write(&file, text).expect("written");
        let output = self.output(name);
        succeed(&file, &output, &[]);
        results(&output)
    }
}

fn lab(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value["lab"][i]["value"].as_f64().expect("a number"))
}

fn ink_of_thickness(um: f64) -> String {
    CLEAR_INK.replace("THICKNESS", &um.to_string())
}

/// The solid in dots is the solid; tints lie between it and the paper, darker than Murray and Davies say; tables are
/// described. *Planted*: the spread of a solid's light left out.
#[test]
fn tints_lie_between_paper_and_solid() {
    // an ink that absorbs: of a clear one the layer sends back more of what the paper returns than it takes
    let absorbing = TINY.replace("{ built_in = \"yellow\" }", "{ n = 1.5, k = 0.3 }");
    let place = Place::new();
    let results = place.run("out", &format!("{absorbing}{DOTS}"));
    let prints = results["prints"]["prints"].as_array().expect("prints");
    assert_eq!(prints.len(), 4);
    let factors = prints[3]["factors"].as_array().expect("factors");
    let lit: Vec<&Value> =
        results["spectra"].as_array().unwrap().iter().filter(|row| row["polar_deg"] == 0.0).collect();
    for (factor, row) in factors.iter().zip(lit) {
        let solid = factor["value"].as_f64().unwrap();
        let lit = row["lit_at_45"]["value"].as_f64().unwrap();
        // an identity: rounding
        assert!((solid - lit).abs() < 1e-14, "{solid} {lit}");
    }
    let lightness: Vec<f64> = prints.iter().map(|print| lab(print)[0]).collect();
    assert!(lightness.windows(2).all(|pair| pair[0] > pair[1]), "{lightness:?}");
    let gain = prints[2]["optical_gain"]["value"].as_f64().expect("a gain");
    assert!(
        gain > 0.0 && (prints[2]["physical_gain"].as_f64().unwrap() - 0.05).abs() < 1e-12,
        "{}",
        prints[2]
    );
    assert!(prints[2]["yule_nielsen"].as_f64().unwrap() > 1.1);
    assert!(prints[2]["lab"][0]["standard_error"].as_f64().unwrap() > 0.0);
    assert!(described_tables(&place.output("out")) >= 4);
    let page = std::fs::read_to_string(place.output("out/report.html")).unwrap();
    assert!(page.contains("<h2>Prints</h2>") && page.contains("Clapper"), "no prints on the page");
}

/// Composed layers: dots of full coverage are the solid, and a brightener without yield changes no number.
#[test]
fn composed_layers_are_printed_as_well() {
    let paper = |quantum_yield: f64| {
        format!(
            "{COMPOSED}{DOTS}[paper]\nalbedo = 0.9\nfluorescence = {{ {BANDS}, yield = {quantum_yield} }}\n"
        )
    };
    let place = Place::new();
    let dark = place.run("out", &paper(0.0));
    let bright = place.run("out", &paper(0.7));
    let number = |row: &Value, key: &str| row[key]["value"].as_f64().expect("a number");
    let rows = |results: &Value| results["spectra"].as_array().expect("rows").clone();
    let prints = |results: &Value| results["prints"]["prints"].as_array().expect("prints").clone();
    assert_eq!(prints(&bright).len(), 2 * 3 * 4);
    for (plain, lit) in rows(&dark).iter().zip(rows(&bright)) {
        let nm = plain["wavelength_nm"].as_f64().unwrap();
        for key in ["lit_at_45", "natural_light"] {
            let emitted = number(&lit, key) - number(plain, key);
            match nm {
                450.0 => assert!(emitted > 0.01, "{key} at {nm} nm: {emitted}"),
                // emission ends at 500 nm
                500.0.. => assert!(emitted.abs() < 1e-12, "{key} at {nm} nm: {emitted}"),
                _ => {}
            }
        }
    }
    // without ultraviolet light there is no more light than without a brightener
    for (plain, lit) in prints(&dark).iter().zip(prints(&bright)) {
        if plain["condition"] == "M2" {
            assert_eq!(lab(plain), lab(&lit));
        } else {
            let difference: f64 = lab(plain)[2] - lab(&lit)[2];
            assert!(difference > 0.0, "bluer by what is emitted: {difference}");
        }
    }
    // the solid at 45:0 without emission
    for (print, um) in [(prints(&dark)[3].clone(), 1.0), (prints(&dark)[15].clone(), 2.0)] {
        assert_eq!(print["thickness_um"], um);
        let rows = rows(&dark);
        let of_thickness = rows.iter().filter(|row| row["thickness_um"] == um);
        for (factor, row) in print["factors"].as_array().unwrap().iter().zip(of_thickness) {
            assert!((factor["value"].as_f64().unwrap() - number(row, "lit_at_45")).abs() < 1e-12);
        }
    }
}
