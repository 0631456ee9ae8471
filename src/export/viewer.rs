//! Interactive view of a packing in a browser: every sphere and convex body, and a cut that moves through the
//! layer. One file, no network.

use crate::ink::{Packing, Sphere};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// Parts per half turn of a round surface.
const STEPS: usize = 10;
const TEMPLATE: &str = include_str!("viewer.html");

/// The page; `materials` names the materials of the grains in their order, which the cut shows.
pub fn page(packing: &Packing, title: &str, materials: &[String]) -> String {
    let grains = packing.grains();
    let nested = || grains.iter().flat_map(|g| packing.nested(g));
    let round = nested().filter(|body| body.solid.is_none());
    let spheres: Vec<(usize, Sphere)> =
        round.flat_map(|body| body.spheres.into_iter().map(move |s| (body.material, s))).collect();
    let solids = || nested().filter_map(|body| Some((body.material, body.solid?)));
    let triangles = || solids().flat_map(|(kind, s)| s.triangles(STEPS).into_iter().map(move |t| (kind, t)));
    let corners = triangles().flat_map(|(_, t)| t.into_iter().flatten().map(|v| v as f32));
    let numbers = spheres.iter().flat_map(|(_, s)| {
        let [x, y, z] = s.center_um;
        [x, y, z, s.radius_um].map(|v| v as f32)
    });
    let [lx, ly] = packing.period_um();
    let data = json!({
        "title": title,
        "size_um": [lx, ly, packing.thickness_um()],
        "pigments": materials,
        "grains": grains.len(),
        "spheres": STANDARD.encode(numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()),
        "triangles": STANDARD.encode(corners.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()),
        "triangle_kinds": STANDARD.encode(triangles().map(|(kind, _)| kind as u8).collect::<Vec<u8>>()),
        "kinds": STANDARD.encode(spheres.iter().map(|(kind, _)| *kind as u8).collect::<Vec<u8>>()),
    });
    // "</script" would end the script element, "<!--<script>" hide its end
    TEMPLATE.replace("/*data*/null", &data.to_string().replace('<', "\\u003c"))
}
