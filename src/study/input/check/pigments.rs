//! Pigments: names, volume fractions, indices, and the requested packing.

use super::Tabulation;
use super::cell::NominalCell;
use crate::ink::{Orientation, PackError, PackingRequest, PigmentGrains, Shape};
use crate::input::file::{MicrostructureTable, PigmentTable};
use crate::input::forms::Diameter;
use crate::input::study::{Dissolved, Layer, Pigment};
use crate::input::{Fault, Faults, StudyFile, as_written, limits};
use crate::material::mixing::MixingRule;
use crate::numerics::vector::norm;
use num_complex::Complex64;

/// A pigment and its number in the file, from 0.
#[derive(Clone, Copy)]
pub(super) struct NumberedPigment<'a> {
    pub number: usize,
    pub table: &'a PigmentTable,
}

/// The pigments with grains.
pub(super) fn packed(pigments: &[PigmentTable]) -> impl Iterator<Item = NumberedPigment<'_>> {
    numbered(pigments).filter(|pigment| !pigment.table.is_molecular())
}

fn numbered(pigments: &[PigmentTable]) -> impl Iterator<Item = NumberedPigment<'_>> {
    pigments.iter().enumerate().map(|(number, table)| NumberedPigment { number, table })
}

impl PigmentTable {
    /// Whether it has no grains and is dissolved in the binder.
    pub(super) fn is_molecular(&self) -> bool {
        matches!(self.diameter_nm, Some(Diameter::Vanishing(_)))
    }
}

impl NumberedPigment<'_> {
    /// The path of one of its keys.
    pub(super) fn field(&self, key: &str) -> String {
        format!("pigment[{}].{key}", self.number)
    }

    /// The given name, or a numbered one.
    pub(super) fn name(&self) -> String {
        self.table.name.clone().unwrap_or_else(|| format!("pigment {}", self.number + 1))
    }

    /// Reports keys of grains beside `"molecular"`.
    fn check_dissolved(&self, faults: &mut Faults) {
        self.check_fraction(faults);
        let NumberedPigment { table, .. } = self;
        let shape = Some(&table.shape).filter(|shape| **shape != Shape::default());
        let keys_of_grains = [
            ("shell", (!table.shell.is_empty()).then(|| as_written(&table.shell))),
            ("agglomeration", table.agglomeration.as_ref().map(as_written)),
            ("shape", shape.map(as_written)),
            ("profile", table.profile.as_ref().map(as_written)),
            ("optic_axis", table.optic_axis.as_ref().map(as_written)),
        ];
        for (key, found) in keys_of_grains {
            if let Some(found) = found {
                let allowed = "nothing of grains: dissolved pigments have none";
                let remedy = format!("give diameter_nm in nm, or remove {key}");
                faults.add(self.field(key), found, allowed, remedy);
            }
        }
    }

    /// What birefringent grains cannot be with.
    fn check_crystal(&self, file: &StudyFile, faults: &mut Faults) {
        let key = if self.table.index.extraordinary.is_some() { "extraordinary" } else { "birefringent" };
        let field = self.field(&format!("index.{key}"));
        let mut refuse = |there: bool, found: &str, allowed: &str, remedy: &str| {
            if there {
                faults.add(field.clone(), found, allowed, remedy);
            }
        };
        let remedy = "set light.wave = \"unpolarised\", or give one index for both rays";
        let allowed =
            "Maxwell's equations (light.wave = \"unpolarised\", \"s\" or \"p\"), which feel the optic axis";
        refuse(!file.light.wave.is_vector(), "the scalar wave, which has no polarisation", allowed, remedy);
        let part = file.layer.contrast.is_full();
        refuse(!part, "layer.contrast", "the full contrast", "remove layer.contrast, or give one index");
        let voxels = file.layer.microstructure.as_ref().is_some_and(|table| table.voxels.is_some());
        let whole = "grains that are known one by one: several boxes of voxels make one grain";
        refuse(voxels, "layer.microstructure.voxels", whole, "give the grains' positions, or one index");
        let aligned = self.table.orientation != Orientation::Random;
        let composed = file.layer.composed.is_some();
        let isotropic =
            "orientation = \"random\" where the layer is composed: the mean wave between slabs has one index";
        let remedy = "remove orientation, or [layer.composed]";
        refuse(composed && aligned, "aligned optic axes", isotropic, remedy);
    }

    /// The pigment with its indices and those of the layers around its cores.
    fn with_indices(&self, grains: PigmentGrains, tables: &Tabulation, faults: &mut Faults) -> Pigment {
        let (material, extraordinary) = self.table.index.rays(&self.field("index"), tables, faults);
        let mut shell = Vec::new();
        for (layer, table) in self.table.shell.iter().enumerate() {
            let field = self.field(&format!("shell[{layer}].index"));
            shell.push(table.index.tabulated(&field, tables, faults));
        }
        Pigment { name: self.name(), grains, material, extraordinary, shell }
    }
}

/// Share of the volume that stands for one that cannot be.
const PLACEHOLDER_SHARE: f64 = 0.1;

/// Gives pigments with a profile its mean as their volume fraction.
pub(super) fn fill_profiles(file: &mut StudyFile, faults: &mut Faults) {
    let equilibrated = file.packing.equilibration.is_some();
    for (number, table) in file.pigments.iter_mut().enumerate() {
        let Some(rows) = &table.profile else { continue };
        let field = |key: &str| format!("pigment[{number}].{key}");
        if let Some(share) = table.volume_fraction {
            let allowed = "nothing beside profile, whose mean is the volume fraction";
            faults.add(field("volume_fraction"), share, allowed, "remove one of them");
        }
        if equilibrated {
            let allowed = "no profile where grains are equilibrated: they would mix";
            faults.add(field("profile"), "a profile", allowed, "remove it, or [packing.equilibration]");
        }
        let area = |pair: &[[f64; 2]]| 0.5 * (pair[1][0] - pair[0][0]) * (pair[0][1] + pair[1][1]);
        // rows that do not rise are reported with the request for the packing
        let is_rising = rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let is_list = rows.len() > 1;
        let mean = if is_list && is_rising { rows.windows(2).map(area).sum() } else { PLACEHOLDER_SHARE };
        table.volume_fraction = Some(mean);
        if rows.is_empty() {
            let remedy = "write for example profile = [[0, 0.1], [1, 0.3]], or volume_fraction";
            faults.empty(field("profile"), "two or more rows [depth, share]", remedy);
        }
        let is_wrong = |row: &&[f64; 2]| row[1] != 0.0 && !limits::VOLUME_FRACTION.holds(row[1]);
        if let Some([_, share]) = rows.iter().find(is_wrong) {
            let allowed = format!("shares {} or 0", limits::VOLUME_FRACTION);
            let remedy =
                if *share > 0.0 { "lower it: no random packing is denser" } else { "raise it: 0 for none" };
            faults.add(field("profile"), share, allowed, remedy);
            // one fault is enough
            table.volume_fraction = Some(PLACEHOLDER_SHARE);
        } else if is_list && is_rising && mean == 0.0 {
            let allowed = "a share above 0 at one depth or more";
            faults.add(field("profile"), "0 at every depth", allowed, "raise one, or remove the pigment");
            table.volume_fraction = Some(PLACEHOLDER_SHARE);
        }
    }
}

/// The grains of every pigment that has some; none if the files of given grains could not be read.
pub(super) fn grains(
    pigments: &[PigmentTable],
    microstructure: Option<&MicrostructureTable>,
    cell: &NominalCell,
    faults: &mut Faults,
) -> Vec<PigmentGrains> {
    let is_unplaced = |pigment: NumberedPigment| pigment.table.volume_fraction.is_none();
    if microstructure.is_some() && packed(pigments).any(is_unplaced) {
        // the files of the grains are reported
        return Vec::new();
    }
    let has_voxels = microstructure.is_some_and(|table| table.voxels.is_some());
    let mut all = Vec::new();
    for pigment in numbered(pigments) {
        if pigment.table.is_molecular() {
            pigment.check_dissolved(faults);
        } else if has_voxels {
            // no packing to make: any share and size that voxels have is possible
            all.push(pigment.grains(faults));
        } else {
            all.push(pigment.packed_grains(cell, faults));
        }
    }
    check_names(pigments, faults);
    if !has_voxels {
        check_total_fraction(pigments, faults);
    }
    all
}

/// What birefringent grains cannot be with, and optic axes of other ones.
pub(super) fn crystal_faults(file: &StudyFile, faults: &mut Faults) {
    for pigment in packed(&file.pigments) {
        let table = pigment.table;
        if let Some(axis) = table.optic_axis {
            let length = norm(axis);
            if !(length.is_finite() && length > 0.0) {
                let allowed = "a direction [x, y, z] of finite length above 0";
                faults.add(pigment.field("optic_axis"), format!("{axis:?}"), allowed, "[0, 0, 1] is usual");
            }
            if !table.index.is_birefringent() {
                let allowed = "an optic axis of grains with two indices";
                let remedy = "give index = { ordinary = …, extraordinary = … }, or remove optic_axis";
                faults.add(pigment.field("optic_axis"), "one index", allowed, remedy);
            }
        }
        if table.index.is_birefringent() {
            pigment.check_crystal(file, faults);
        }
    }
}

/// The checked pigments with their indices.
pub(super) fn with_indices(
    pigments: &[PigmentTable],
    grains: Vec<PigmentGrains>,
    tables: &Tabulation,
    faults: &mut Faults,
) -> Vec<Pigment> {
    let both = packed(pigments).zip(grains);
    both.map(|(pigment, grains)| pigment.with_indices(grains, tables, faults)).collect()
}

/// The pigments without grains.
pub(super) fn dissolved(
    pigments: &[PigmentTable],
    tables: &Tabulation,
    faults: &mut Faults,
) -> Vec<Dissolved> {
    let molecular = numbered(pigments).filter(|pigment| pigment.table.is_molecular());
    let dissolved = molecular.map(|pigment| Dissolved {
        name: pigment.name(),
        volume_fraction: pigment.table.volume_fraction.unwrap_or(0.0),
        material: pigment.table.index.tabulated(&pigment.field("index"), tables, faults),
    });
    dissolved.collect()
}

/// Dissolves pigments in the binder; their fractions refer to the volume without grains.
pub(super) fn dissolve(layer: &mut Layer, dissolved: &[Dissolved], grains: &[Pigment], mixing: MixingRule) {
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
    layer.binder.dissolved = spectra.collect();
    layer.binder.mixing = mixing;
}

/// Names of the pigments with grains.
pub(super) fn packed_names(pigments: &[PigmentTable]) -> Vec<String> {
    packed(pigments).map(|pigment| pigment.name()).collect()
}

/// The error found by the packing's own check.
pub(super) fn packing_fault(request: &PackingRequest) -> Option<Fault> {
    let Err(PackError::BadInput { field, found, allowed, remedy }) = request.check() else { return None };
    let field = if field.starts_with("pigment") {
        field
    } else if field.starts_with("relief") {
        format!("layer.{field}")
    } else {
        format!("packing.{field}")
    };
    Some(Fault::new(field, found, allowed, remedy))
}

fn check_names(pigments: &[PigmentTable], faults: &mut Faults) {
    let names: Vec<String> = numbered(pigments).map(|pigment| pigment.name()).collect();
    for (pigment, name) in numbered(pigments).zip(&names) {
        let others = names[..pigment.number].iter().map(String::as_str);
        faults.name(pigment.field("name"), name, others, "pigment");
    }
}

fn check_total_fraction(pigments: &[PigmentTable], faults: &mut Faults) {
    let total: f64 = pigments.iter().filter_map(|pigment| pigment.volume_fraction).sum();
    if pigments.len() > 1 && !limits::VOLUME_FRACTION.holds(total) {
        let field = format!("pigment[{}].volume_fraction", pigments.len() - 1);
        let allowed = format!("a sum {} over all pigments", limits::VOLUME_FRACTION);
        faults.add(field, format!("{total} in all"), allowed, "lower the volume fractions");
    }
}
