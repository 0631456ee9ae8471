//! Grains in given places: the study file as if its pigments had been asked for, and the cuts.

mod voxels;

use super::grains::{is_molecular, packed};
use super::pigments::packed_names;
use crate::ink::{Grain, Measure, PackError, Packing, Shape, SizeDistribution, Sphere, VoxelCut};
use crate::input::file::{FileNames, MicrostructureTable, StudyFile};
use crate::input::forms::Pair;
use crate::input::positions::{Positions, read_positions};
use crate::input::{CellRule, Faults, keys_in_words};
use crate::numerics::vector::V3;
use std::collections::HashMap;
use std::path::Path;

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
}

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
    let files = names.all();
    let twice = files.iter().enumerate().find(|(i, name)| files[..*i].contains(name));
    if files.is_empty() || twice.is_some() {
        let found = twice.map_or("no file".into(), |(_, name)| format!("{name} twice"));
        let remedy = "list the files, without repeats: equal cuts say nothing of the scatter";
        faults.add(FIELD, found, "one or more different files", remedy);
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
    let period_um = period(file, &cuts, faults)?;
    let cell_um = [period_um[0], period_um[1], file.layer.thickness_um.mean()];
    let grains: Vec<Vec<Grain>> = cuts.iter().map(|cut| grains(file, cut, cell_um, faults)).collect();
    let pigments = (0..packed(file).count()).map(|k| sizes(&grains, k, cell_um)).collect();
    Some(Given { cell_um, grains, voxels: Vec::new(), pigments })
}

const FORMATS: &str = "give CSV with x_um, y_um, z_um and radius_um or diameter_um (or _nm), optionally pigment and grain, a LAMMPS \
                       dump, or extended XYZ";

/// What has no meaning beside given grains.
fn beside(file: &StudyFile, own: &MicrostructureTable, faults: &mut Faults) {
    let voxels = own.voxels.is_some();
    let mut found = vec![
        (voxels && own.unit.is_some(), format!("{FIELD}.unit")),
        (voxels && own.size.is_some(), format!("{FIELD}.size")),
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
        let ratio = sides[0] / period[0];
        let unit = if (1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) { "" } else { "; is unit right?" };
        let found = format!("{path} with a box of {} × {} µm{unit}", sides[0], sides[1]);
        let allowed = format!("the period {} × {} µm of all files", period[0], period[1]);
        faults.add(FIELD, found, allowed, "leave layer.period_um out, or correct unit");
        return None;
    }
    Some(period)
}

/// The grains of one cut in the cell, after all checks.
fn grains(file: &StudyFile, (path, cut): &(String, Positions), cell: V3, faults: &mut Faults) -> Vec<Grain> {
    let mut refuse = |found: String, allowed: &str, remedy: &str| {
        faults.add(FIELD, format!("{path}: {found}"), allowed, remedy);
        Vec::new()
    };
    if cut.spheres.is_empty() {
        return refuse("no spheres".into(), "at least one sphere per cut", "remove the file or the frame");
    }
    let grains = match placed(file, cut, cell) {
        Ok(grains) => grains,
        Err(found) => {
            let allowed = "for each grain one of the study's pigments: names, or numbers, from 0 in CSV and \
                           from 1 in other files";
            return refuse(found, allowed, "name it in [[pigment]]; number grains through all pigments");
        }
    };
    if let Some(found) = outside(&grains, cell) {
        let allowed = "spheres within 0 … layer.thickness_um along z";
        return refuse(found, allowed, "correct the layer, the axes or the units");
    }
    match Packing::from_grains([cell[0], cell[1]], cell[2], true, grains.clone()) {
        Ok(_) => grains,
        Err(PackError::Overlap { .. }) => {
            let remedy =
                "grains may touch; spheres of one grain share a number in the column grain (mol in dumps)";
            let allowed = "grains apart from each other and from their periodic images";
            refuse(overlaps(&grains, cell), allowed, remedy)
        }
        Err(other) => refuse(other.to_string(), "sound grains", "correct the file"),
    }
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
fn outside(grains: &[Grain], [lx, ly, h]: [f64; 3]) -> Option<String> {
    let slack = 1e-9 * h;
    let spheres = || grains.iter().flat_map(|g| &g.spheres);
    let out = |s: &&Sphere| s.center_um[2] - s.radius_um < -slack || s.center_um[2] + s.radius_um > h + slack;
    let first = spheres().find(out)?;
    let ends = |axis: usize| {
        let high = spheres().map(|s| s.center_um[axis] + s.radius_um).fold(f64::MIN, f64::max);
        (spheres().map(|s| s.center_um[axis] - s.radius_um).fold(f64::MAX, f64::min), high)
    };
    let fits = |axis: usize| ends(axis).0 > -slack && ends(axis).1 < h + slack;
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
        "{count} spheres outside the layer of {h} µm, first one of radius {} at ({x}, {y}, {z}) µm{hint}",
        first.radius_um
    ))
}

/// How many pairs of grains overlap, and where they do most.
fn overlaps(grains: &[Grain], [lx, ly, _]: [f64; 3]) -> String {
    let (mut count, mut worst) = (0, (0.0, [0.0; 3]));
    for (i, a) in grains.iter().enumerate() {
        for b in &grains[..i] {
            let pairs = a.spheres.iter().flat_map(|s| b.spheres.iter().map(move |t| (s, t)));
            let deep = pairs.map(|(s, t)| (-nearest_gap(s, t, [lx, ly]), s.center_um));
            let deepest = deep.fold((0.0, [0.0; 3]), |best, own| if own.0 > best.0 { own } else { best });
            count += usize::from(deepest.0 > 0.0);
            worst = if deepest.0 > worst.0 { deepest } else { worst };
        }
    }
    let (depth, [x, y, z]) = worst;
    match count {
        0 => "a grain that overlaps its own periodic image or a wall".into(),
        _ => {
            format!("{count} pairs of grains overlap, by up to {depth:.4} µm at ({x:.4}, {y:.4}, {z:.4}) µm")
        }
    }
}

fn nearest_gap(a: &Sphere, b: &Sphere, period: [f64; 2]) -> f64 {
    let apart = |axis: usize| {
        let d = a.center_um[axis] - b.center_um[axis];
        period.get(axis).map_or(d, |l| d - l * (d / l).round())
    };
    apart(0).hypot(apart(1)).hypot(apart(2)) - a.radius_um - b.radius_um
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
