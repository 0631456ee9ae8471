//! Pigments: names, volume fractions, indices, and the requested packing.

use super::grains::{as_written, fraction, grains_of, is_molecular, of, packed, size};
use super::index::Tabulation;
use crate::ink::{Grain, PackError, PackingRequest, PigmentGrains, Shape, VoxelCut};
use crate::input::file::{PigmentTable, StudyFile};
use crate::input::study::{Dissolved, IndexSpectrum, Layer, Pigment};
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
            let keys = [
                (!table.shell.is_empty(), "shell"),
                (table.agglomeration.is_some(), "agglomeration"),
                (table.shape != Shape::default(), "shape"),
            ];
            for (_, key) in keys.into_iter().filter(|(found, _)| *found) {
                let allowed = "nothing of grains: dissolved pigments have none";
                let remedy = format!("give diameter_nm in nm, or remove {key}");
                faults.add(of(i, key), "a value", allowed, &remedy);
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

/// The packing of the nominal cell; its own check is made only if there are no other errors.
pub fn packing(
    file: &StudyFile,
    layer: &Layer,
    pigments: &[Pigment],
    (given, voxels): (Vec<Vec<Grain>>, Vec<VoxelCut>),
    faults: &mut Faults,
) -> PackingRequest {
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
        given,
        voxels,
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
