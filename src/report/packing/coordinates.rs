//! Coordinates of the grains as CSV (one row per sphere) and JSON (with the account of the
//! packing).
//!
//! Spheres as VTK points with diameter, pigment and grain number, for ParaView's glyphs; convex
//! bodies as triangles.

use crate::draw::cell;
use crate::ink::{Grain, Packing, Relief};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::json;
use std::fmt::Write;

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
    let about = json!({
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
        "grains": [],
    });
    let text = PackingText { about, grains: packing.grains() };
    let mut bytes = serde_json::to_vec_pretty(&text).expect("numbers and names are JSON");
    bytes.push(b'\n');
    bytes
}

/// What a packing's file says, with its grains, which become JSON one after the other: all at once
/// they take kilobytes each.
struct PackingText<'a> {
    about: serde_json::Value,
    grains: &'a [Grain],
}

impl Serialize for PackingText<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        for (key, value) in self.about.as_object().into_iter().flatten() {
            match key.as_str() {
                "grains" => map.serialize_entry(key, &GrainsText(self.grains))?,
                _ => map.serialize_entry(key, value)?,
            }
        }
        map.end()
    }
}

struct GrainsText<'a>(&'a [Grain]);

impl Serialize for GrainsText<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        // keys in the order of all other ones
        to.collect_seq(self.0.iter().map(|grain| json!(grain)))
    }
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

/// Parts per half turn of a round surface.
const STEPS: usize = 12;

/// A point of the file: number of its grain, the grain, position and diameter.
type Glyph<'a> = (usize, &'a Grain, [f64; 3], f64);

/// XML PolyData in plain text (.vtp). In ParaView: Glyph, type Sphere, scale array `diameter_um`,
/// factor 1. Corners of triangles follow the spheres and have a diameter of 0.
///
/// Arrays: `diameter_um`, `grain`, `pigment`, `agglomerate` (−1 for none), `axis`.
pub fn spheres_vtp(packing: &Packing) -> String {
    let grains = || packing.grains().iter().enumerate();
    let spheres = grains().filter(|(_, g)| g.solid.is_none());
    let mut places: Vec<Glyph> = spheres
        .flat_map(|(k, g)| g.spheres.iter().map(move |s| (k, g, s.center_um, 2.0 * s.radius_um)))
        .collect();
    let n = places.len();
    for (k, grain) in grains() {
        let triangles = grain.solid.iter().flat_map(|solid| solid.triangles(STEPS));
        places.extend(triangles.flatten().map(|corner| (k, grain, corner, 0.0)));
    }
    let polys = (places.len() - n) / 3;
    let triple = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n",
    );
    let points = places.len();
    out +=
        &format!("<PolyData><Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" ");
    out += &format!("NumberOfStrips=\"0\" NumberOfPolys=\"{polys}\">\n<PointData Scalars=\"diameter_um\">\n");
    let all = || places.iter();
    array(&mut out, "Float64", "diameter_um", 1, all().map(|(_, _, _, d)| d.to_string()));
    array(&mut out, "Int32", "grain", 1, all().map(|(k, ..)| k.to_string()));
    array(&mut out, "Int32", "pigment", 1, all().map(|(_, g, ..)| g.pigment.to_string()));
    let agglomerate = all().map(|(_, g, ..)| g.agglomerate.map_or("-1".into(), |a| a.to_string()));
    array(&mut out, "Int32", "agglomerate", 1, agglomerate);
    array(&mut out, "Float64", "axis", 3, all().map(|(_, g, ..)| triple(g.axis)));
    out += "</PointData>\n<Points>\n";
    array(&mut out, "Float64", "points", 3, all().map(|(_, _, p, _)| triple(*p)));
    out += "</Points>\n<Verts>\n";
    array(&mut out, "Int32", "connectivity", 1, (0..n).map(|k| k.to_string()));
    array(&mut out, "Int32", "offsets", 1, (1..=n).map(|k| k.to_string()));
    out += "</Verts>\n<Polys>\n";
    array(&mut out, "Int32", "connectivity", 1, (n..points).map(|k| k.to_string()));
    array(&mut out, "Int32", "offsets", 1, (1..=polys).map(|k| (3 * k).to_string()));
    out += "</Polys>\n</Piece></PolyData>\n</VTKFile>\n";
    out
}

fn array(out: &mut String, kind: &str, name: &str, components: usize, values: impl Iterator<Item = String>) {
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    );
    values.for_each(|v| {
        let _ = writeln!(out, "{v}");
    });
    out.push_str("</DataArray>\n");
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
