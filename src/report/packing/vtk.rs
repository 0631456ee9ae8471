//! Spheres as VTK points with diameter, pigment and grain number, for ParaView's glyphs; convex
//! bodies as triangles.

use crate::ink::{Grain, Packing};
use std::fmt::Write;

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
