//! Coordinates of the grains as CSV (one row per sphere) and JSON (with the account of the
//! packing).

use crate::ink::{Packing, Relief};
use crate::report::cell;
use serde_json::json;

const COLUMNS: [&str; 10] =
    ["grain", "pigment", "agglomerate", "x_um", "y_um", "z_um", "radius_um", "axis_x", "axis_y", "axis_z"];

/// One row per sphere: grain, pigment, agglomerate (empty if none), centre, radius, axis of the
/// grain. A convex body has the sphere around it; its form and rotation are in the JSON file.
pub fn grains_csv(packing: &Packing) -> csv::Result<Vec<u8>> {
    let spheres = packing.grains().iter().enumerate().flat_map(|(number, grain)| {
        let kind = (number, grain.pigment, grain.agglomerate);
        grain.spheres.iter().map(move |sphere| (kind, sphere.center_um, sphere.radius_um, grain.axis))
    });
    cell::table(COLUMNS, spheres)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{Grain, Sphere};

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
