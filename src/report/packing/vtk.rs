//! Spheres as VTK points with diameter, pigment and grain number, for ParaView's glyphs.

use crate::ink::Packing;
use std::fmt::Write;

/// XML PolyData in plain text (.vtp). In ParaView: Glyph, type Sphere, scale array `diameter_um`,
/// factor 1.
///
/// Arrays: `diameter_um`, `grain`, `pigment`, `agglomerate` (−1 for none), `axis`.
pub fn spheres_vtp(packing: &Packing) -> String {
    let spheres =
        || packing.grains().iter().enumerate().flat_map(|(k, g)| g.spheres.iter().map(move |s| (k, g, s)));
    let n = spheres().count();
    let triple = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n",
    );
    out += &format!("<PolyData><Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" ");
    out += "NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData Scalars=\"diameter_um\">\n";
    array(&mut out, "Float64", "diameter_um", 1, spheres().map(|(_, _, s)| (2.0 * s.radius_um).to_string()));
    array(&mut out, "Int32", "grain", 1, spheres().map(|(k, _, _)| k.to_string()));
    array(&mut out, "Int32", "pigment", 1, spheres().map(|(_, g, _)| g.pigment.to_string()));
    let agglomerate = spheres().map(|(_, g, _)| g.agglomerate.map_or("-1".into(), |a| a.to_string()));
    array(&mut out, "Int32", "agglomerate", 1, agglomerate);
    array(&mut out, "Float64", "axis", 3, spheres().map(|(_, g, _)| triple(g.axis)));
    out += "</PointData>\n<Points>\n";
    array(&mut out, "Float64", "points", 3, spheres().map(|(_, _, s)| triple(s.center_um)));
    out += "</Points>\n<Verts>\n";
    array(&mut out, "Int32", "connectivity", 1, (0..n).map(|k| k.to_string()));
    array(&mut out, "Int32", "offsets", 1, (1..=n).map(|k| k.to_string()));
    out += "</Verts>\n</Piece></PolyData>\n</VTKFile>\n";
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
