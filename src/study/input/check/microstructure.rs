//! Grains in given places: the study file as if its pigments had been asked for, and the cuts.

mod contacts;
mod voxels;

use super::grains::{is_molecular, packed};
use super::pigments::packed_names;
use crate::ink::{Grain, Measure, PackError, Packing, Shape, SizeDistribution, Sphere, VoxelCut};
use crate::input::file::{FileNames, MicrostructureTable, StudyFile};
use crate::input::forms::Pair;
use crate::input::positions::{Positions, read_positions};
use crate::input::{CellRule, Fault, Faults, keys_in_words, limits};
use crate::numerics::vector::V3;
use contacts::{ContactRule, Contacts};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

pub(super) const FIELD: &str = "layer.microstructure";
/// A box this much larger or smaller than the layer is in another unit.
const OTHER_UNIT: f64 = 30.0;

/// What the study says of files of grains, and their names.
type GrainFiles<'a> = (&'a MicrostructureTable, &'a FileNames);

/// What files say of the layer.
pub(super) struct Given {
    /// Periods and thickness, µm.
    pub cell_um: [f64; 3],
    /// Grains of every realisation.
    pub grains: Vec<Vec<Grain>>,
    /// Labelled voxels instead, one cut per realisation.
    pub voxels: Vec<VoxelCut>,
    /// Share and sizes of every pigment with grains; `None` if no grain is of it.
    pub pigments: Vec<Option<(f64, SizeDistribution)>>,
    /// What the user should know of how the files were read.
    pub remarks: Vec<String>,
}

/// What is allowed, and what to do, where cuts are equal.
const DIFFERENT: &str = "different cuts, in one or more different files";
const NO_REPEATS: &str = "list every cut once: equal cuts say nothing of the scatter";

/// The study with the cell, the shares and the sizes of the grains that its files hold, and the
/// grains of every realisation; `None` without files, and after an error.
pub(super) fn given(file: &StudyFile, folder: &Path, faults: &mut Faults) -> Option<(StudyFile, Given)> {
    let table = file.layer.microstructure.as_ref()?;
    let before = faults.0.len();
    beside(file, table, faults);
    let names = match (&table.spheres, &table.voxels) {
        (Some(names), None) | (None, Some(names)) => names,
        _ => {
            let found = keys_in_words(table, &["spheres", "voxels"]);
            faults.add(FIELD, found, "either spheres or voxels", "write voxels = \"cut.npy\"");
            return None;
        }
    };
    if let Some(found) = repeated(names.all(), folder) {
        faults.add(FIELD, found, DIFFERENT, NO_REPEATS);
        return None;
    }
    let read = if table.spheres.is_some() { spheres } else { voxels::voxels };
    let given = read(file, folder, (table, names), faults)?;
    let mut absent = packed(file).zip(&given.pigments).filter(|(_, found)| found.is_none());
    if let Some(((i, _), _)) = absent.next().filter(|_| faults.0.len() == before) {
        let allowed =
            "at least one grain of every pigment; a file without a column pigment has the first only";
        faults.add(format!("pigment[{i}]"), "no grain", allowed, "remove this pigment");
    }
    let cuts = given.grains.len() + given.voxels.len();
    let asked = file.run.realisations.unwrap_or(cuts);
    if asked > cuts {
        let allowed = format!("at most {cuts}, one per cut in the files");
        faults.add("run.realisations", asked, allowed, "leave it out, or add files");
    }
    (faults.0.len() == before).then(|| (filled(file, &given, cuts), given))
}

/// Which file is named twice, perhaps by different paths; or that there is none.
fn repeated(files: &[String], folder: &Path) -> Option<String> {
    if files.is_empty() {
        return Some("no file".into());
    }
    let mut known: HashMap<PathBuf, &String> = HashMap::new();
    for name in files {
        let path = folder.join(name);
        // a file that cannot be found is reported where it is read
        let path = path.canonicalize().unwrap_or(path);
        match known.insert(path, name) {
            Some(other) if other == name => return Some(format!("{name} twice")),
            Some(other) => return Some(format!("{other} and {name}, which are one file")),
            None => {}
        }
    }
    None
}

/// Which cut has the same spheres as another one.
fn equal_cuts(cuts: &[(String, Positions)]) -> Option<String> {
    let mut known: HashMap<u64, &String> = HashMap::new();
    for (path, cut) in cuts {
        let mut content = DefaultHasher::new();
        for Sphere { center_um: [x, y, z], radius_um } in &cut.spheres {
            [x, y, z, radius_um].map(|number| number.to_bits()).hash(&mut content);
        }
        (&cut.pigments, &cut.grains).hash(&mut content);
        match known.insert(content.finish(), path) {
            Some(other) if other == path => return Some(format!("{path} with the same frame twice")),
            Some(other) => return Some(format!("{other} and {path} with the same spheres")),
            None => {}
        }
    }
    None
}

/// Grains of all files of spheres.
fn spheres(
    file: &StudyFile,
    folder: &Path,
    (table, names): GrainFiles,
    faults: &mut Faults,
) -> Option<Given> {
    let (mut cuts, before) = (Vec::new(), faults.0.len());
    for path in names.all() {
        match read_positions(&folder.join(path), table) {
            Ok(read) => cuts.extend(read.into_iter().map(|positions| (path.clone(), positions))),
            Err(reason) => faults.add(FIELD, path, format!("positions of spheres: {reason}"), FORMATS),
        }
    }
    if faults.0.len() > before {
        return None;
    }
    if let Some(found) = equal_cuts(&cuts) {
        faults.add(FIELD, found, DIFFERENT, NO_REPEATS);
        return None;
    }
    let rule = ContactRule { overlap_um: table.overlap_um };
    if let Some(overlap) = table.overlap_um {
        let remedy = "0.001 allows contacts of a nanometre; leave it out for a thousandth of a diameter";
        faults.number("layer.microstructure.overlap_um", overlap, limits::OVERLAP_UM, remedy);
    }
    let period_um = period(file, &cuts, faults)?;
    let cell_um = [period_um[0], period_um[1], file.layer.thickness_um.mean()];
    let (mut all, mut contacts) = (Vec::new(), Contacts::default());
    for cut in &cuts {
        match grains(file, cut, cell_um, rule) {
            Ok((grains, own)) => {
                contacts = contacts.and(own);
                all.push(grains);
            }
            Err(fault) => faults.push(Fault { found: format!("{}: {}", cut.0, fault.found), ..fault }),
        }
    }
    let pigments = (0..packed(file).count()).map(|k| sizes(&all, k, cell_um)).collect();
    let remarks = contacts.in_words().into_iter().collect();
    Some(Given { cell_um, grains: all, voxels: Vec::new(), pigments, remarks })
}

const FORMATS: &str = "give CSV with x_um, y_um, z_um and radius_um or diameter_um (or _nm), optionally pigment and grain, a LAMMPS \
                       dump, or extended XYZ";

/// What has no meaning beside given grains.
fn beside(file: &StudyFile, own: &MicrostructureTable, faults: &mut Faults) {
    let voxels = own.voxels.is_some();
    let mut found = vec![
        (voxels && own.unit.is_some(), format!("{FIELD}.unit")),
        (voxels && own.size.is_some(), format!("{FIELD}.size")),
        (voxels && own.overlap_um.is_some(), format!("{FIELD}.overlap_um")),
        (!voxels && own.voxel_nm.is_some(), format!("{FIELD}.voxel_nm")),
        (!voxels && own.labels.is_some(), format!("{FIELD}.labels")),
        (!voxels && own.continuation.is_some(), format!("{FIELD}.continuation")),
        (!voxels && own.cuts.is_some(), format!("{FIELD}.cuts")),
        (file.layer.composed.is_some(), "layer.composed".to_owned()),
        (file.layer.relief.is_some(), "layer.relief".to_owned()),
        (file.layer.thickness_um.std() > 0.0, "layer.thickness_um.std".to_owned()),
    ];
    for (i, table) in packed(file) {
        let keys = [
            (table.volume_fraction.is_some(), "volume_fraction"),
            (table.diameter_nm.is_some(), "diameter_nm"),
            (table.size.is_some(), "size"),
            (table.agglomeration.is_some(), "agglomeration"),
            (voxels && !table.shell.is_empty(), "shell"),
            (voxels && table.shape != Shape::default(), "shape"),
        ];
        found.extend(keys.map(|(found, key)| (found, format!("pigment[{i}].{key}"))));
    }
    for (_, field) in found.into_iter().filter(|(found, _)| *found) {
        let allowed = "nothing beside layer.microstructure, whose grains are placed";
        faults.add(field, "a value", allowed, "remove it");
    }
}

/// The period: of the files, or as written; both must agree.
fn period(file: &StudyFile, cuts: &[(String, Positions)], faults: &mut Faults) -> Option<[f64; 2]> {
    let written = file.layer.period_um.map(|pair| pair.xy());
    let sides = |b: [[f64; 2]; 3]| [b[0][1] - b[0][0], b[1][1] - b[1][0]];
    let own: Vec<_> = cuts.iter().filter_map(|(path, cut)| Some((path, sides(cut.box_um?)))).collect();
    let Some(period) = written.or(own.first().map(|(_, sides)| *sides)) else {
        let allowed = "one number or [x, y], µm: these files have no box";
        faults.add("layer.period_um", "nothing", allowed, "give the period of the positions");
        return None;
    };
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b;
    if let Some((path, sides)) = own.iter().find(|(_, s)| !(close(s[0], period[0]) && close(s[1], period[1])))
    {
        let unit = other_unit(sides[0] / period[0]);
        let found = format!("{path} with a box of {} × {} µm{unit}", sides[0], sides[1]);
        let allowed = format!("the period {} × {} µm of all files", period[0], period[1]);
        faults.add(FIELD, found, allowed, "leave layer.period_um out, or correct unit");
        return None;
    }
    let thickness = file.layer.thickness_um.mean();
    let height = |b: [[f64; 2]; 3]| b[2][1] - b[2][0];
    let mut heights = cuts.iter().filter_map(|(path, cut)| Some((path, height(cut.box_um?))));
    if let Some((path, height)) = heights.find(|(_, height)| !close(*height, thickness)) {
        let found = format!("{path} with a box {height} µm high{}", other_unit(height / thickness));
        let allowed = format!("the thickness of the layer, layer.thickness_um = {thickness}");
        let remedy = "make both equal: z runs from the lit face, the lower end of the box, to the paper; or correct unit";
        faults.add(FIELD, found, allowed, remedy);
        return None;
    }
    Some(period)
}

/// A question where a length differs by more than any mistake but that of the unit.
fn other_unit(ratio: f64) -> &'static str {
    if (1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) { "" } else { "; is unit right?" }
}

/// The grains of one cut in the cell, after all checks, and the contacts in it.
fn grains(
    file: &StudyFile,
    (_, cut): &(String, Positions),
    cell: V3,
    rule: ContactRule,
) -> Result<(Vec<Grain>, Contacts), Fault> {
    let refusal = |found: String, allowed: &str, remedy: &str| Fault::new(FIELD, found, allowed, remedy);
    if cut.spheres.is_empty() {
        return Err(refusal(
            "no spheres".into(),
            "at least one sphere per cut",
            "remove the file or the frame",
        ));
    }
    if let Some(found) = out_of_scale(cut, cell) {
        let allowed = "positions and sizes on the scale of the layer";
        let remedy = "correct unit, or the units in the names of the columns (x_um, x_nm, x_mm, x_m)";
        return Err(refusal(found, allowed, remedy));
    }
    let grains = placed(file, cut, cell).map_err(|found| {
        let allowed = "for each grain one of the study's pigments: names, or numbers, from 0 in CSV and \
                       from 1 in other files";
        refusal(found, allowed, "name it in [[pigment]]; number grains through all pigments")
    })?;
    if let Some(found) = outside(&grains, cell, rule) {
        let allowed = "spheres within 0 … layer.thickness_um along z";
        return Err(refusal(found, allowed, "correct the layer, the axes or the units"));
    }
    let unsound = |error: PackError| refusal(error.to_string(), "sound grains", "correct the file");
    let (grains, contacts) = rule.resolve(grains, cell).map_err(unsound)?;
    if let Some(fault) = contacts.refused(rule) {
        return Err(fault);
    }
    let packing = Packing::from_grains([cell[0], cell[1]], cell[2], true, grains).map_err(unsound)?;
    Ok((packing.into_grains(), contacts))
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
    let low = cut.box_um.map_or([0.0; 3], |b| b.map(|range| range[0]));
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
fn placed(file: &StudyFile, cut: &Positions, cell: V3) -> Result<Vec<Grain>, String> {
    let moved = cut.box_um.map_or([0.0; 3], |b| b.map(|range| range[0]));
    let mut grains: Vec<Grain> = Vec::new();
    for own in rows(cut) {
        let mut spheres = Vec::new();
        for &i in &own {
            let center_um = [0, 1, 2].map(|axis| cut.spheres[i].center_um[axis] - moved[axis]);
            spheres.push(near(Sphere { center_um, ..cut.spheres[i] }, spheres.first(), cell));
        }
        grains.push(Grain::new(spheres, pigment(file, cut, &own)?));
    }
    Ok(grains)
}

/// Rows of every grain, in the order of their first ones: programs in parallel mix them.
fn rows(cut: &Positions) -> Vec<Vec<usize>> {
    let (mut rows, mut places) = (Vec::new(), HashMap::new());
    for i in 0..cut.spheres.len() {
        let next = rows.len();
        let place = cut.grains.get(i).map_or(next, |grain| *places.entry(grain).or_insert(next));
        rows.resize_with(next.max(place + 1), Vec::new);
        rows[place].push(i);
    }
    rows
}

/// A sphere in the cell, or next to the first one of its grain.
fn near(sphere: Sphere, first: Option<&Sphere>, cell: [f64; 3]) -> Sphere {
    let mut center_um = sphere.center_um;
    for axis in 0..2 {
        let turns = match first {
            Some(first) => ((center_um[axis] - first.center_um[axis]) / cell[axis]).round(),
            None => (center_um[axis] / cell[axis]).floor(),
        };
        center_um[axis] -= turns * cell[axis];
    }
    Sphere { center_um, ..sphere }
}

/// The pigment of a grain's rows, by name or number; the first where the file names none.
fn pigment(file: &StudyFile, cut: &Positions, rows: &[usize]) -> Result<usize, String> {
    let Some(called) = cut.pigments.get(rows[0]) else { return Ok(0) };
    if rows.iter().any(|&i| cut.pigments.get(i) != Some(called)) {
        return Err(format!("grain {} of several pigments", cut.grains[rows[0]]));
    }
    let names = packed_names(file);
    let named = names.iter().position(|name| name == called);
    let first = cut.counted_from;
    let known =
        named.or_else(|| called.parse::<usize>().ok()?.checked_sub(first).filter(|&k| k < names.len()));
    known.ok_or_else(|| format!("pigment {called:?}"))
}

/// Which spheres leave the layer, and what else their file may mean.
fn outside(grains: &[Grain], [lx, ly, h]: [f64; 3], rule: ContactRule) -> Option<String> {
    let slack = 1e-9 * h;
    let spheres = || grains.iter().flat_map(|g| &g.spheres);
    let out = |s: &&Sphere| {
        let (z, contact) = (s.center_um[2], slack.max(rule.limit_um(s.radius_um)));
        z - s.radius_um < -contact || z + s.radius_um > h + contact
    };
    let first = spheres().find(out)?;
    let ends = |axis: usize| {
        let high = spheres().map(|s| s.center_um[axis] + s.radius_um).fold(f64::MIN, f64::max);
        (spheres().map(|s| s.center_um[axis] - s.radius_um).fold(f64::MAX, f64::min), high)
    };
    let fits = |axis: usize| ends(axis).0 > -slack && ends(axis).1 < h + slack;
    let largest = ends(2).1.max(-ends(2).0);
    let hint = if ends(2).1 > OTHER_UNIT * lx.max(ly).max(h) {
        "; lengths in nm that the file calls µm?"
    } else if fits(0) || fits(1) {
        "; is z, from the lit face down, in another column?"
    } else {
        ""
    };
    let [x, y, z] = first.center_um;
    let count = spheres().filter(out).count();
    Some(format!(
        "{count} spheres outside the layer of {h} µm, largest coordinate along z {largest} µm, first one of radius {} at \
         ({x}, {y}, {z}) µm{hint}",
        first.radius_um
    ))
}

/// Share of the layer and sizes of a pigment's grains.
fn sizes(cuts: &[Vec<Grain>], pigment: usize, [lx, ly, h]: [f64; 3]) -> Option<(f64, SizeDistribution)> {
    let own = cuts.iter().flatten().filter(|g| g.pigment == pigment);
    let um3: Vec<f64> = own.map(|grain| grain.volume_um3).collect();
    let share = um3.iter().sum::<f64>() / (lx * ly * h * cuts.len() as f64);
    let diameter = |v: f64| 1e3 * (6.0 * v / std::f64::consts::PI).cbrt();
    let mut values_nm: Vec<f64> = um3.into_iter().map(diameter).collect();
    values_nm.sort_by(f64::total_cmp);
    let (weights, of) = (Vec::new(), Measure::EffectiveDiameter);
    (!values_nm.is_empty()).then_some((share, SizeDistribution::List { values_nm, weights, of }))
}

/// The file with the cell, shares and sizes of the given grains.
fn filled(file: &StudyFile, given: &Given, cuts: usize) -> StudyFile {
    let mut filled = file.clone();
    filled.layer.period_um = Some(Pair::Each([given.cell_um[0], given.cell_um[1]]));
    filled.layer.cell = CellRule::Fixed;
    filled.run.realisations = filled.run.realisations.or(Some(cuts));
    let packed = filled.pigments.iter_mut().filter(|table| !is_molecular(table));
    for (table, (share, size)) in packed.zip(given.pigments.iter().flatten()) {
        (table.volume_fraction, table.size) = (Some(*share), Some(size.clone()));
    }
    filled
}
