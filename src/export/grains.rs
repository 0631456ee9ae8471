//! Positions of the grains' spheres in formats that `layer.microstructure` reads back: LAMMPS dumps
//! and extended XYZ, lengths in µm. Pigments count from 1, and spheres of one grain share a number.
//!
//! Interactive view of a packing in a browser: every sphere and convex body, and a cut that moves
//! through the layer. One file, no network.

use crate::ink::{Packing, Sphere};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use std::fmt::Write;

/// Grain, pigment and sphere of every row, numbers from 1.
fn rows(packing: &Packing) -> impl Iterator<Item = (usize, usize, &Sphere)> {
    let grains = packing.grains().iter().enumerate();
    grains.flat_map(|(k, grain)| grain.spheres.iter().map(move |s| (k + 1, grain.pigment + 1, s)))
}

/// A LAMMPS dump of one frame with radii.
pub fn dump(packing: &Packing) -> String {
    let [lx, ly] = packing.period_um();
    let h = packing.thickness_um();
    let count = rows(packing).count();
    let mut out = format!("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS pp pp ff\n");
    let _ = write!(out, "0 {lx}\n0 {ly}\n0 {h}\nITEM: ATOMS id mol type x y z radius\n");
    for (i, (grain, pigment, Sphere { center_um: [x, y, z], radius_um })) in rows(packing).enumerate() {
        let _ = writeln!(out, "{} {grain} {pigment} {x} {y} {z} {radius_um}", i + 1);
    }
    out
}

/// Extended XYZ of one frame with radii, as OVITO and ASE read it.
pub fn xyz(packing: &Packing) -> String {
    let [lx, ly] = packing.period_um();
    let h = packing.thickness_um();
    let count = rows(packing).count();
    let properties = "species:S:1:pos:R:3:radius:R:1:grain:I:1";
    let mut out =
        format!("{count}\nLattice=\"{lx} 0 0 0 {ly} 0 0 0 {h}\" Properties={properties} pbc=\"T T F\"\n");
    for (grain, pigment, Sphere { center_um: [x, y, z], radius_um }) in rows(packing) {
        let _ = writeln!(out, "{pigment} {x} {y} {z} {radius_um} {grain}");
    }
    out
}

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
