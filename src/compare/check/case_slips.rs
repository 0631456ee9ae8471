//! Slips in what a program reads: right answers to another case.

use super::slips::{Slip, slip};
use serde_json::{Value, json};

/// A change of the case that is read.
pub(super) type CaseSlip = Slip<fn(&mut Value)>;

/// All of them; the first one that explains the answers is named.
pub(super) const CASE_SLIPS: [CaseSlip; 7] = [
    slip("degrees read as radians", "`sigma_deg` and `phi_deg` are in degrees", both_as_radians),
    slip("polar angle in degrees read as radians", "`sigma_deg` is in degrees", polar_as_radians),
    slip("azimuth in degrees read as radians", "`phi_deg` is in degrees", azimuth_as_radians),
    slip("azimuth ignored", "kx = k sin σ cos φ and ky = k sin σ sin φ", |case| {
        case["phi_deg"] = json!(0.0)
    }),
    slip("exit medium ignored", "`n_out` is the index beyond z = H", |case| case["n_out"] = json!(1.0)),
    slip("absorption ignored", "indices are [re, im], and Im η > 0 absorbs", without_absorption),
    slip("layer upside down", "z points from the side of the light into the layer", upside_down),
];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_default()
}

/// The direction of light whose angle is a number of radians; sines below 0 turn the azimuth.
fn polar_as_radians(case: &mut Value) {
    let sine = number(&case["sigma_deg"]).sin();
    let turned = if sine < 0.0 { 180.0 } else { 0.0 };
    case["phi_deg"] = json!(number(&case["phi_deg"]) + turned);
    case["sigma_deg"] = json!(sine.abs().asin().to_degrees());
}

/// The azimuth first: the sign of the sine turns what it is then.
fn both_as_radians(case: &mut Value) {
    azimuth_as_radians(case);
    polar_as_radians(case);
}

fn azimuth_as_radians(case: &mut Value) {
    case["phi_deg"] = json!(number(&case["phi_deg"]).to_degrees());
}

/// Sets every imaginary part to 0.
fn without_absorption(value: &mut Value) {
    match value {
        Value::Object(keys) => {
            for (key, inner) in keys {
                if key.starts_with("eta") { inner[1] = json!(0.0) } else { without_absorption(inner) }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(without_absorption),
        _ => {}
    }
}

/// Mirrors the layer between its half-spaces.
fn upside_down(case: &mut Value) {
    let height = number(&case["H"]);
    for key in ["layers_from_z0", "sublayers_from_z0"] {
        if let Some(layers) = case.get_mut(key).and_then(Value::as_array_mut) {
            layers.reverse();
        }
    }
    for sphere in case.get_mut("spheres").and_then(Value::as_array_mut).into_iter().flatten() {
        sphere["center"][2] = json!(height - number(&sphere["center"][2]));
    }
}
