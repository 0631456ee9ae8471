//! Positions of the grains' spheres in formats that `layer.microstructure` reads back: LAMMPS dumps
//! and extended XYZ, lengths in µm. Pigments count from 1, and spheres of one grain share a number.

use crate::ink::{Packing, Sphere};
use std::fmt::Write;

/// Grain, pigment and sphere of every row, numbers from 1.
fn rows(packing: &Packing) -> impl Iterator<Item = (usize, usize, &Sphere)> {
    let grains = packing.grains().iter().enumerate();
    grains.flat_map(|(k, grain)| grain.spheres.iter().map(move |s| (k + 1, grain.pigment + 1, s)))
}

/// A LAMMPS dump of one frame with radii.
pub fn dump(packing: &Packing) -> String {
    let ([lx, ly], h) = (packing.period_um(), packing.thickness_um());
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
    let ([lx, ly], h) = (packing.period_um(), packing.thickness_um());
    let count = rows(packing).count();
    let properties = "species:S:1:pos:R:3:radius:R:1:grain:I:1";
    let mut out =
        format!("{count}\nLattice=\"{lx} 0 0 0 {ly} 0 0 0 {h}\" Properties={properties} pbc=\"T T F\"\n");
    for (grain, pigment, Sphere { center_um: [x, y, z], radius_um }) in rows(packing) {
        let _ = writeln!(out, "{pigment} {x} {y} {z} {radius_um} {grain}");
    }
    out
}
