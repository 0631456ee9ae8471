//! Coordinates of the grains as CSV (one row per sphere) and JSON (with the account of the
//! packing).

use crate::draw::OutputError;
use crate::ink::{Grain, Packing, Relief};
use serde::Deserialize;
use serde_json::json;

const COLUMNS: [&str; 10] =
    ["grain", "pigment", "agglomerate", "x_um", "y_um", "z_um", "radius_um", "axis_x", "axis_y", "axis_z"];

/// One row per sphere: grain, pigment, agglomerate (empty if none), centre, radius, axis of the
/// grain. A convex body has the sphere around it; its form and rotation are in the JSON file.
pub fn grains_csv(packing: &Packing) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS)?;
    for (number, grain) in packing.grains().iter().enumerate() {
        for sphere in &grain.spheres {
            let kind = (number, grain.pigment, grain.agglomerate);
            writer.serialize((kind, sphere.center_um, sphere.radius_um, grain.axis))?;
        }
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// Cell, conventions, account, shares, relief and all grains; numbers have every digit of the f64.
pub fn packing_json(packing: &Packing) -> Vec<u8> {
    let value = json!({
        "conventions": {
            "length": "µm",
            "z": "0 at the free face, H at the paper",
            "size": "an effective diameter is that of the sphere of equal union volume",
            "fraction": "union volume over the volume of the layer; with relief over the dry volume",
        },
        "period_um": packing.period_um(),
        "thickness_um": packing.thickness_um(),
        "walls": packing.walls(),
        "account": packing.account(),
        "shares": packing.shares(),
        "relief": packing.relief().map(relief_json),
        "shells_um": packing.shells_um(),
        "grains": packing.grains(),
    });
    format!("{value:#}\n").into_bytes()
}

fn relief_json(relief: &Relief) -> serde_json::Value {
    json!({
        "rule": relief.rule,
        "face": relief.face,
        "dry_height_um": relief.dry_height_um,
        "mean_height_um": relief.mean_height_um(),
        "rms_height_um": relief.rms_height_um(),
        "rms_surface_um": relief.rms_surface_um(),
        "protruding_share": relief.protruding_share,
        "fraction_below": relief.fraction_below,
        "balance_error": relief.balance_error,
    })
}

#[derive(Deserialize)]
struct Read {
    period_um: [f64; 2],
    thickness_um: f64,
    walls: bool,
    #[serde(default)]
    shells_um: Vec<Vec<f64>>,
    grains: Vec<Grain>,
}

/// Reads the grains of a JSON file and checks again that they do not overlap (the account and the
/// relief are not read back).
pub fn read_packing_json(path: &std::path::Path) -> Result<Packing, OutputError> {
    let fail = |reason: String| OutputError::Read { path: path.into(), reason };
    let text = std::fs::read(path).map_err(|e| fail(e.to_string()))?;
    let read: Read = serde_json::from_slice(&text).map_err(|e| fail(e.to_string()))?;
    let packing = Packing::from_grains(read.period_um, read.thickness_um, read.walls, read.grains);
    let layered = packing.and_then(|packing| packing.with_shells(read.shells_um));
    layered.map_err(|e| fail(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Sphere;

    /// Two spheres side by side along x.
    #[test]
    fn axes_are_written_in_their_columns() {
        let spheres = [0.5, 0.7].map(|x| Sphere { center_um: [x, 0.5, 0.5], radius_um: 0.2 });
        let grain = Grain::new(Vec::from(spheres), 0);
        let packing = Packing::from_grains([2.0; 2], 1.0, true, vec![grain]).unwrap();
        let csv = String::from_utf8(grains_csv(&packing).unwrap()).unwrap();
        let axis: Vec<f64> =
            csv.lines().nth(1).unwrap().split(',').skip(7).map(|x| x.parse().unwrap()).collect();
        assert!((axis[0] - 1.0).abs() < 1e-12 && axis[1..] == [0.0, 0.0], "{axis:?}");
    }
}
