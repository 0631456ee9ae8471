//! The grains of one cut of spheres in the layer's cell.

use super::contacts::{ContactRule, Contacts};
use super::{FIELD, OTHER_UNIT};
use crate::ink::{Grain, PackError, Packing, Sphere};
use crate::input::Fault;
use crate::input::positions::Positions;
use crate::numerics::vector::V3;
use std::collections::HashMap;

/// Grains of one cut, and the contacts between them.
pub(super) struct PlacedGrains {
    pub grains: Vec<Grain>,
    pub contacts: Contacts,
}

/// The grains of one cut in the cell, after all checks; `names` are those of the pigments with
/// grains.
///
/// # Errors
/// No spheres, lengths in another unit, an unknown pigment, spheres outside the layer or overlaps
/// that are no contacts.
pub(super) fn grains(
    cut: &Positions,
    names: &[String],
    cell_um: V3,
    rule: ContactRule,
) -> Result<PlacedGrains, Fault> {
    let refusal = |found: String, allowed: &str, remedy: &str| Fault::new(FIELD, found, allowed, remedy);
    if cut.spheres.is_empty() {
        let allowed = "at least one sphere per cut";
        return Err(refusal("no spheres".into(), allowed, "remove the file or the frame"));
    }
    if let Some(found) = out_of_scale(cut, cell_um) {
        let allowed = "positions and sizes on the scale of the layer";
        let remedy = "correct unit, or the units in the names of the columns (x_um, x_nm, x_mm, x_m)";
        return Err(refusal(found, allowed, remedy));
    }
    let grains = placed(cut, names, cell_um).map_err(|found| {
        let allowed = "for each grain one of the study's pigments: names, or numbers, from 0 in CSV and \
                       from 1 in other files";
        refusal(found, allowed, "name it in [[pigment]]; number grains through all pigments")
    })?;
    if let Some(found) = outside(&grains, cell_um, rule) {
        let allowed = "spheres within 0 … layer.thickness_um along z";
        return Err(refusal(found, allowed, "correct the layer, the axes or the units"));
    }
    let unsound = |error: PackError| refusal(error.to_string(), "sound grains", "correct the file");
    let (grains, contacts) = rule.resolve(grains, cell_um).map_err(unsound)?;
    if let Some(fault) = contacts.refused(rule) {
        return Err(fault);
    }
    let [lx, ly, thickness_um] = cell_um;
    let packing = Packing::from_grains([lx, ly], thickness_um, true, grains).map_err(unsound)?;
    Ok(PlacedGrains { grains: packing.into_grains(), contacts })
}

/// Grains thinner than this are none, µm: single molecules.
const LEAST_DIAMETER_UM: f64 = 1e-3;
/// Layers that are more than this many times as thick as their largest grain are none.
const MOST_GRAINS_ACROSS: f64 = 5000.0;
/// Positions more than this many cells away have lost their digits.
const MOST_CELLS_AWAY: f64 = 1e6;

/// What shows that the lengths of a file are in another unit than it says: all spheres in a corner
/// of the cell, far from it, or of no size. A box, which is compared with the layer, says that they
/// are where they should be.
fn out_of_scale(cut: &Positions, [lx, ly, h]: V3) -> Option<String> {
    let low = lowest_corner_um(cut);
    let reach = |s: &Sphere| {
        let along = |axis: usize| (s.center_um[axis] - low[axis]).abs() + s.radius_um;
        along(0).max(along(1)).max(along(2))
    };
    let largest = cut.spheres.iter().map(reach).fold(0.0, f64::max);
    let diameter = 2.0 * cut.spheres.iter().map(|s| s.radius_um).fold(0.0, f64::max);
    let cell = format!("a layer of {h} µm with a period of {lx} × {ly} µm");
    if cut.box_um.is_none() && largest * OTHER_UNIT < lx.min(ly).min(h) {
        return Some(format!(
            "largest coordinate {largest:.3e} µm, in {cell}: lengths in mm or m that the file calls smaller?"
        ));
    }
    if largest > MOST_CELLS_AWAY * lx.max(ly).max(h) {
        return Some(format!(
            "largest coordinate {largest:.3e} µm, in {cell}: lengths in nm that the file calls µm?"
        ));
    }
    if diameter < LEAST_DIAMETER_UM.max(h / MOST_GRAINS_ACROSS) {
        return Some(format!("largest sphere {diameter:.3e} µm across, in {cell}: sizes in another unit?"));
    }
    None
}

/// The grains of one cut in the cell, or what is wrong with a pigment.
fn placed(cut: &Positions, names: &[String], cell_um: V3) -> Result<Vec<Grain>, String> {
    let corner_um = lowest_corner_um(cut);
    let mut grains: Vec<Grain> = Vec::new();
    for rows in rows_of_grains(cut) {
        let mut spheres = Vec::new();
        for &i in &rows {
            let center_um = [0, 1, 2].map(|axis| cut.spheres[i].center_um[axis] - corner_um[axis]);
            spheres.push(near(Sphere { center_um, ..cut.spheres[i] }, spheres.first(), cell_um));
        }
        grains.push(Grain::new(spheres, pigment(cut, names, &rows)?));
    }
    Ok(grains)
}

/// The corner of the box of a cut, µm; the origin if its file has no box.
fn lowest_corner_um(cut: &Positions) -> V3 {
    cut.box_um.map_or([0.0; 3], |ranges| ranges.map(|[low, _]| low))
}

/// Rows of every grain, in the order of their first ones: programs in parallel mix them.
fn rows_of_grains(cut: &Positions) -> Vec<Vec<usize>> {
    let mut rows: Vec<Vec<usize>> = Vec::new();
    let mut places = HashMap::new();
    for i in 0..cut.spheres.len() {
        let next = rows.len();
        let place = cut.grains.get(i).map_or(next, |grain| *places.entry(grain).or_insert(next));
        rows.resize_with(next.max(place + 1), Vec::new);
        rows[place].push(i);
    }
    rows
}

/// A sphere in the cell, or next to the first one of its grain.
fn near(sphere: Sphere, first: Option<&Sphere>, cell_um: V3) -> Sphere {
    let mut center_um = sphere.center_um;
    for axis in 0..2 {
        let turns = match first {
            Some(first) => ((center_um[axis] - first.center_um[axis]) / cell_um[axis]).round(),
            None => (center_um[axis] / cell_um[axis]).floor(),
        };
        center_um[axis] -= turns * cell_um[axis];
    }
    Sphere { center_um, ..sphere }
}

/// The pigment of a grain's rows, by name or number; the first where the file names none.
fn pigment(cut: &Positions, names: &[String], rows: &[usize]) -> Result<usize, String> {
    let Some(called) = cut.pigments.get(rows[0]) else { return Ok(0) };
    if rows.iter().any(|&i| cut.pigments.get(i) != Some(called)) {
        return Err(format!("grain {} of several pigments", cut.grains[rows[0]]));
    }
    let named = names.iter().position(|name| name == called);
    let numbered = || called.parse::<usize>().ok()?.checked_sub(cut.counted_from);
    let known = named.or_else(|| numbered().filter(|&k| k < names.len()));
    known.ok_or_else(|| format!("pigment {called:?}"))
}

/// Which spheres leave the layer, and what else their file may mean.
fn outside(grains: &[Grain], [lx, ly, h]: V3, rule: ContactRule) -> Option<String> {
    let slack = 1e-9 * h;
    let spheres = || grains.iter().flat_map(|g| &g.spheres);
    let is_outside = |s: &&Sphere| {
        let z = s.center_um[2];
        let contact = slack.max(rule.limit_um(s.radius_um));
        z - s.radius_um < -contact || z + s.radius_um > h + contact
    };
    let first = spheres().find(is_outside)?;
    let lowest = |axis: usize| spheres().map(|s| s.center_um[axis] - s.radius_um).fold(f64::MAX, f64::min);
    let highest = |axis: usize| spheres().map(|s| s.center_um[axis] + s.radius_um).fold(f64::MIN, f64::max);
    let fits = |axis: usize| lowest(axis) > -slack && highest(axis) < h + slack;
    let largest = highest(2).max(-lowest(2));
    let hint = if highest(2) > OTHER_UNIT * lx.max(ly).max(h) {
        "; lengths in nm that the file calls µm?"
    } else if fits(0) || fits(1) {
        "; is z, from the lit face down, in another column?"
    } else {
        ""
    };
    let [x, y, z] = first.center_um;
    let count = spheres().filter(is_outside).count();
    Some(format!(
        "{count} spheres outside the layer of {h} µm, largest coordinate along z {largest} µm, first one of radius {} at \
         ({x}, {y}, {z}) µm{hint}",
        first.radius_um
    ))
}
