//! Pigments: names, volume fractions, shapes and sizes that fit into the layer, and the requested
//! packing.

use super::grain_count;
use super::index::Tabulation;
use crate::ink::{Measure, PackError, PackingRequest, PigmentGrains, SizeDistribution};
use crate::input::file::{LayerTable, PigmentTable, StudyFile};
use crate::input::forms::Diameter;
use crate::input::study::{Dissolved, IndexSpectrum, Layer, Pigment};
use crate::input::variation::{CellRule, THICKNESS_CUT, shortest_side_um};
use crate::input::{Fault, Faults, limits};
use crate::material::mixing::MixingRule;
use num_complex::Complex64;

/// The pigments with grains.
pub fn grains(file: &StudyFile, period_um: [f64; 2], faults: &mut Faults) -> Vec<PigmentGrains> {
    let mut all = Vec::new();
    let unplaced = |table: &PigmentTable| table.volume_fraction.is_none() && !is_molecular(table);
    if file.layer.microstructure.is_some() && file.pigments.iter().any(unplaced) {
        // the files of the grains are reported
        return all;
    }
    let voxels = file.layer.microstructure.as_ref().is_some_and(|table| table.voxels.is_some());
    for (i, table) in file.pigments.iter().enumerate() {
        if voxels && !is_molecular(table) {
            // no packing to make: any share and size that voxels have is possible
            all.push(as_written(table, size(i, table, faults)));
        } else if !is_molecular(table) {
            all.push(grains_of(i, table, (&file.layer, period_um), faults));
        } else {
            fraction(i, table, faults);
            if !table.shell.is_empty() {
                let (found, allowed) = ("layers", "no layers around dissolved pigments: they have no grains");
                faults.add(of(i, "shell"), found, allowed, "give diameter_nm in nm, or remove shell");
            }
        }
    }
    names(file, faults);
    if !voxels {
        total_fraction(file, faults);
    }
    all
}

/// The checked pigments with their indices.
pub fn pigments(
    file: &StudyFile,
    grains: Vec<PigmentGrains>,
    indices: &Tabulation,
    faults: &mut Faults,
) -> Vec<Pigment> {
    let pigment = |((i, table), grains): ((usize, &PigmentTable), _)| Pigment {
        name: name(i, table),
        grains,
        material: indices.tabulate(&of(i, "index"), &table.index, faults),
        shell: shell(i, table, indices, faults),
    };
    packed(file).zip(grains).map(pigment).collect()
}

/// The layers' indices.
fn shell(i: usize, table: &PigmentTable, indices: &Tabulation, faults: &mut Faults) -> Vec<IndexSpectrum> {
    let layers = (0..).zip(&table.shell).map(|(j, layer)| (of(i, &format!("shell[{j}].index")), layer));
    layers.map(|(field, layer)| indices.tabulate(&field, &layer.index, faults)).collect()
}

/// The pigments without grains.
pub fn dissolved(file: &StudyFile, indices: &Tabulation, faults: &mut Faults) -> Vec<Dissolved> {
    let tables = file.pigments.iter().enumerate().filter(|(_, table)| is_molecular(table));
    let dissolved = tables.map(|(i, table)| Dissolved {
        name: name(i, table),
        volume_fraction: table.volume_fraction.unwrap_or(0.0),
        material: indices.tabulate(&of(i, "index"), &table.index, faults),
    });
    dissolved.collect()
}

/// Dissolves pigments in the binder; their fractions refer to the volume without grains.
pub fn dissolve(layer: &mut Layer, dissolved: &[Dissolved], grains: &[Pigment], mixing: MixingRule) {
    if dissolved.is_empty() {
        return;
    }
    let room = 1.0 - grains.iter().map(|pigment| pigment.grains.volume_fraction).sum::<f64>();
    let mixed = |(w, &eta): (usize, &Complex64)| {
        let share = |d: &Dissolved| (d.volume_fraction / room, d.material.index[w]);
        mixing.mix(eta, &dissolved.iter().map(share).collect::<Vec<_>>())
    };
    layer.binder.index = layer.binder.index.iter().enumerate().map(mixed).collect();
    let spectra = dissolved.iter().map(|d| (d.volume_fraction / room, d.material.spectrum.clone()));
    (layer.binder.dissolved, layer.binder.mixing) = (spectra.collect(), mixing);
}

/// The given name, or a numbered one.
fn name(i: usize, table: &PigmentTable) -> String {
    table.name.clone().unwrap_or_else(|| format!("pigment {}", i + 1))
}

/// Names of the pigments with grains.
pub(super) fn packed_names(file: &StudyFile) -> Vec<String> {
    packed(file).map(|(i, table)| name(i, table)).collect()
}

/// The pigments with grains and their places in the file.
pub(super) fn packed(file: &StudyFile) -> impl Iterator<Item = (usize, &PigmentTable)> {
    file.pigments.iter().enumerate().filter(|(_, table)| !is_molecular(table))
}

pub(super) fn is_molecular(table: &PigmentTable) -> bool {
    matches!(table.diameter_nm, Some(Diameter::Vanishing(_)))
}

/// The packing of the nominal cell; its own check is made only if there are no other errors.
pub fn packing(file: &StudyFile, layer: &Layer, pigments: &[Pigment], faults: &mut Faults) -> PackingRequest {
    let request = PackingRequest {
        period_um: layer.period_um,
        thickness_um: layer.thickness_um,
        pigments: pigments.iter().map(|pigment| pigment.grains.clone()).collect(),
        method: file.packing.method,
        seed: file.run.seed,
        sequential: file.packing.sequential,
        relaxation: file.packing.relaxation,
        equilibration: file.packing.equilibration,
        relief: file.layer.relief,
        walls: file.layer.walls,
        ..PackingRequest::default()
    };
    if faults.0.is_empty() {
        faults.0.extend(packing_fault(&request));
    }
    request
}

/// The error found by the packing's own check.
fn packing_fault(request: &PackingRequest) -> Option<Fault> {
    let Err(PackError::BadInput { field, found, allowed, remedy }) = request.check() else { return None };
    let field = match &field {
        own if own.starts_with("pigment") => field,
        own if own.starts_with("relief") => format!("layer.{field}"),
        _ => format!("packing.{field}"),
    };
    Some(Fault::new(field, found, allowed, remedy))
}

fn of(pigment: usize, key: &str) -> String {
    format!("pigment[{pigment}].{key}")
}

/// A layer and the nominal period of its cells.
type NominalCell<'a> = (&'a LayerTable, [f64; 2]);

/// The grains of one pigment.
fn grains_of(i: usize, table: &PigmentTable, layer: NominalCell, faults: &mut Faults) -> PigmentGrains {
    let before = faults.0.len();
    fraction(i, table, faults);
    let grains = as_written(table, size(i, table, faults));
    let field = of(i, if table.diameter_nm.is_some() { "diameter_nm" } else { "size" });
    fits(&field, &grains, layer, faults);
    if faults.0.len() == before && grains.shape.defect().is_none() {
        grain_count::check([field, of(i, "volume_fraction")], &grains, layer, faults);
    }
    grains
}

fn as_written(table: &PigmentTable, size: SizeDistribution) -> PigmentGrains {
    PigmentGrains {
        shape: table.shape.clone(),
        size,
        shell_nm: table.shell.iter().map(|layer| layer.thickness_nm).collect(),
        volume_fraction: table.volume_fraction.unwrap_or(0.0),
        orientation: table.orientation,
        agglomeration: table.agglomeration.clone(),
        share: table.share,
    }
}

/// Default nominal period: the usual one, or what the largest grains require, µm.
pub(super) fn nominal_period_um(file: &StudyFile) -> f64 {
    let need = packed(file).filter_map(|(_, table)| needed_period_um(table)).fold(USUAL_PERIOD_UM, f64::max);
    (need / PERIOD_STEP_UM - 1e-9).ceil() * PERIOD_STEP_UM
}

/// Period required by a pigment's largest grains, µm; `None` if their size or shape is invalid.
fn needed_period_um(table: &PigmentTable) -> Option<f64> {
    let grains = as_written(table, written_size(table).filter(|size| size.defect().is_none())?);
    if grains.shape.defect().is_some() {
        return None;
    }
    let (_, longest) = largest_extents_nm(&grains);
    let diameter = grains.shape.template().effective_diameter() / grains.shape.template().length * longest;
    Some(1e-3 * (DIAMETERS * diameter).max(LONGEST * longest))
}

/// A pigment's size distribution; `None` unless it is given once.
fn written_size(table: &PigmentTable) -> Option<SizeDistribution> {
    match (table.diameter_nm, &table.size) {
        (Some(Diameter::Nm(nm)), None) => Some(SizeDistribution::diameter_nm(nm)),
        (None, Some(size)) => Some(size.clone()),
        _ => None,
    }
}

/// Usual nominal period, µm: no bias is seen in R and T of three inks (40 cells; 1.2 µm has one at
/// 50 %).
const USUAL_PERIOD_UM: f64 = 1.6;
/// Minimum nominal period in mean diameters of the largest grains: a grain, its neighbours and
/// theirs.
const DIAMETERS: f64 = 4.5;
/// Minimum nominal period in lengths of the longest grains: the shortest side drawn is twice the
/// length.
const LONGEST: f64 = 3.2;
/// Nominal periods are integer multiples of this, µm.
const PERIOD_STEP_UM: f64 = 0.1;

fn fraction(i: usize, table: &PigmentTable, faults: &mut Faults) {
    let remedy = "a share of the layer's volume, such as 0.3 for 30 %";
    match table.volume_fraction {
        Some(share) => faults.number(&of(i, "volume_fraction"), share, limits::VOLUME_FRACTION, remedy),
        None => faults.add(of(i, "volume_fraction"), "nothing", limits::VOLUME_FRACTION.to_string(), remedy),
    }
}

fn size(i: usize, table: &PigmentTable, faults: &mut Faults) -> SizeDistribution {
    written_size(table).unwrap_or_else(|| {
        let remedy = "write diameter_nm = 250 for grains that are all alike";
        faults.add(format!("pigment[{i}]"), "both or neither", "either diameter_nm or size", remedy);
        SizeDistribution::diameter_nm(1e-3)
    })
}

/// Checks that grains fit between the walls and do not touch their own periodic images.
fn fits(field: &str, grains: &PigmentGrains, (layer, period_um): NominalCell, faults: &mut Faults) {
    if grains.shape.defect().is_some() {
        // the packing's own check reports errors in the shape
        return;
    }
    if let Some((_, found, allowed)) = grains.size.defect() {
        faults.add(field, found, allowed, "correct these numbers; pigment grains measure 50 to 500 nm");
        return;
    }
    let (thickest, longest) = largest_extents_nm(grains);
    let shortest = shortest_side_um(layer.cell, period_um);
    let side = match layer.cell {
        CellRule::Fixed => "half the layer's period",
        CellRule::Varied => "half the shortest side that a varied cell gets (0.65 layer.period_um)",
    };
    let thinnest = match layer.thickness_um.std() > 0.0 {
        true => "the thinnest layer drawn, mean - 3 std of layer.thickness_um",
        false if layer.composed.is_some() => "half of layer.composed.slab_um",
        false => "the layer's thickness",
    };
    let thinnest_um = layer.thickness_um.mean() - THICKNESS_CUT * layer.thickness_um.std();
    let limits = [(longest, 500.0 * shortest, side), (thickest, 1e3 * thinnest_um, thinnest)];
    // an invalid cell is reported separately
    let wrong = limits.into_iter().find(|&(extent, limit, _)| limit > 0.0 && extent > limit * (1.0 + 1e-12));
    if let Some((extent, limit, name)) = wrong {
        let [found, most] = [extent, limit].map(|nm| (1e6 * nm).round() / 1e6);
        let allowed = format!("grains of at most {most} nm, {name}");
        let (room, now) = match name == side {
            true => ("a larger cell, layer.period_um", period_um[0].max(period_um[1])),
            false => ("a thicker layer, layer.thickness_um", layer.thickness_um.mean()),
        };
        let needed = (100.0 * now * extent / limit - 1e-9).ceil() / 100.0;
        let remedy = format!(
            "pigment grains measure 50 to 500 nm, flakes more; take smaller grains or {room} = {needed} or more"
        );
        faults.add(field, format!("grains of up to {found} nm"), allowed, &remedy);
    }
}

/// Thickness and length of the largest grain, nm.
pub fn largest_extents_nm(grains: &PigmentGrains) -> (f64, f64) {
    let template = grains.shape.template();
    let largest = grains.size.largest_nm();
    let radius = match grains.size.measure() {
        Measure::EffectiveDiameter => largest / template.effective_diameter(),
        Measure::Radius => largest,
        Measure::Length => largest / template.length,
    };
    match &template.form {
        // a platelet may lie flat, but its neighbours and images may not reach over its corners
        Some(form) => (2.0 * form.thin_um() * radius, 2.0 * form.reach_um() * radius),
        None => (2.0 * radius, template.length * radius),
    }
}

fn names(file: &StudyFile, faults: &mut Faults) {
    let names: Vec<String> = file.pigments.iter().enumerate().map(|(i, table)| name(i, table)).collect();
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) || name.trim().is_empty() {
            let allowed = "a name that no other pigment has";
            faults.add(of(i, "name"), format!("{name:?}"), allowed, "give it another name");
        }
    }
}

fn total_fraction(file: &StudyFile, faults: &mut Faults) {
    let total: f64 = file.pigments.iter().filter_map(|pigment| pigment.volume_fraction).sum();
    if file.pigments.len() > 1 && !limits::VOLUME_FRACTION.holds(total) {
        let allowed = format!("a sum {} over all pigments", limits::VOLUME_FRACTION);
        let found = format!("{total} in all");
        let remedy = "lower the volume fractions";
        faults.add(of(file.pigments.len() - 1, "volume_fraction"), found, allowed, remedy);
    }
}
