//! Voxels of a microstructure: labels become pigments, files become cuts.

use super::{FIELD, Given, GrainFiles};
use crate::ink::{Measure, SizeDistribution, VoxelCut};
use crate::input::check::pigments::packed_names;
use crate::input::file::{Continuation, MicrostructureTable, StudyFile, VoxelEdges};
use crate::input::voxels::read_labels;
use crate::input::{Fault, Faults, limits};
use ndarray::{Array3, ArrayView1, Axis, concatenate, s};
use std::collections::BTreeMap;
use std::path::Path;

/// Faces of voxels exceed a smooth surface of all directions by this factor: the mean of
/// |nx| + |ny| + |nz|.
const STAIRS: f64 = 1.5;

/// The cuts of all files; `None` after an error.
pub fn voxels(
    file: &StudyFile,
    folder: &Path,
    (table, names): GrainFiles,
    faults: &mut Faults,
) -> Option<Given> {
    let before = faults.0.len();
    let field = "layer.microstructure.voxel_nm";
    let remedy = "give the edge of a voxel in nm";
    let Some(edges_nm) = table.voxel_nm.map(VoxelEdges::xyz) else {
        faults.add(field, "nothing", limits::VOXEL_NM.to_string(), remedy);
        return None;
    };
    if let Some(&edge) = edges_nm.iter().find(|&&edge| !limits::VOXEL_NM.holds(edge)) {
        faults.number(field, edge, limits::VOXEL_NM, remedy);
    }
    let pigments = packed_names(file);
    let known = known_labels(table, &pigments, faults);
    if faults.0.len() > before {
        return None;
    }
    let height = 1e3 * file.layer.thickness_um.mean() / edges_nm[2];
    let mut reader = VoxelReader { table, known, height, cuts: Vec::new() };
    for path in names.all() {
        if let Err(fault) = reader.read(&folder.join(path)) {
            faults.push(Fault { found: format!("{path}: {}", fault.found), ..fault });
        }
    }
    if faults.0.len() > before || reader.cuts.is_empty() {
        return None;
    }
    let mut given = reader.given(file, edges_nm, pigments.len());
    let [lx, ly, h] = given.cell_um;
    let other = |[x, y]: &[f64; 2]| (x - lx).abs() > 1e-6 * lx || (y - ly).abs() > 1e-6 * ly;
    if let Some([x, y]) = file.layer.period_um.map(|pair| pair.xy()).filter(other) {
        let allowed = format!("{lx} × {ly} µm, the width of a cut");
        faults.add("layer.period_um", format!("{x} × {y} µm"), allowed, "leave it out");
        return None;
    }
    // a written period may have more digits than the edge of a voxel
    given.cell_um = file.layer.period_um.map_or([lx, ly, h], |pair| [pair.xy()[0], pair.xy()[1], h]);
    Some(given)
}

/// The pigment of every label.
fn known_labels(table: &MicrostructureTable, pigments: &[String], faults: &mut Faults) -> BTreeMap<i64, u8> {
    let Some(labels) = &table.labels else { return (1..).zip(1..).take(pigments.len()).collect() };
    let mut known = BTreeMap::new();
    for (label, name) in labels {
        let field = format!("layer.microstructure.labels.{label}");
        let number = label.parse::<i64>().ok().filter(|&n| n != 0);
        let pigment = pigments.iter().position(|own| own == name);
        match (number, pigment.and_then(|k| u8::try_from(k + 1).ok())) {
            (Some(number), Some(kind)) => drop(known.insert(number, kind)),
            (None, _) => {
                let allowed = "integers other than 0, which is the binder";
                faults.add(field, format!("label {label:?}"), allowed, "write 1 = \"yellow\"");
            }
            _ => {
                let allowed = format!("the name of a pigment with grains: {}", pigments.join(", "));
                faults.add(field, format!("{name:?}"), allowed, "name it in [[pigment]]");
            }
        }
    }
    known
}

/// The cuts read so far, as labels from 1 for the pigments.
struct VoxelReader<'a> {
    table: &'a MicrostructureTable,
    known: BTreeMap<i64, u8>,
    /// The layer's thickness in voxels.
    height: f64,
    cuts: Vec<Array3<u8>>,
}

impl VoxelReader<'_> {
    fn read(&mut self, path: &Path) -> Result<(), Fault> {
        let formats = "integers with axes x, y, z in a NumPy array (.npy), or a stack of TIFF pages";
        let labels =
            read_labels(path).map_err(|found| Fault::new(FIELD, found, formats, "convert the file"))?;
        let (nx, ny, nz) = labels.dim();
        if (self.height - nz as f64).abs() > 1e-6 * nz as f64 {
            let thick = (1e3 * self.height).round() / 1e3;
            let found = format!("{nz} voxels along z, the last axis, in a layer {thick} voxels thick");
            let allowed = "layer.thickness_um = voxels along z × voxel_nm / 1000";
            let remedy = "correct layer.thickness_um or voxel_nm, or transpose the array to x, y, z";
            return Err(Fault::new(FIELD, found, allowed, remedy));
        }
        let labels = self.pigments(&labels)?;
        let [across, along] = self.table.cuts.unwrap_or([1, 1]);
        if across * along == 0 || nx % across > 0 || ny % along > 0 {
            let found = format!("{nx} × {ny} voxels in {across} × {along} cuts");
            let allowed = "numbers that divide the voxels evenly";
            return Err(Fault::new(FIELD, found, allowed, "change cuts, or trim the array"));
        }
        let (width, depth) = (nx / across, ny / along);
        for (i, j) in (0..across).flat_map(|i| (0..along).map(move |j| (i * width, j * depth))) {
            self.cuts.push(labels.slice(s![i..i + width, j..j + depth, ..]).to_owned());
        }
        if self.cuts[0].dim() != (width, depth, nz) {
            let found = format!("cuts of {width} × {depth} voxels beside {:?}", self.cuts[0].dim());
            return Err(Fault::new(FIELD, found, "cuts of one size in all files", "trim the arrays"));
        }
        Ok(())
    }

    /// Labels of the file as 0 for the binder and k + 1 for pigment k.
    fn pigments(&self, labels: &Array3<i64>) -> Result<Array3<u8>, Fault> {
        let mut unlisted: BTreeMap<i64, usize> = BTreeMap::new();
        for label in labels.iter().filter(|label| **label != 0 && !self.known.contains_key(label)) {
            *unlisted.entry(*label).or_default() += 1;
        }
        if unlisted.is_empty() {
            return Ok(labels.map(|label| self.known.get(label).copied().unwrap_or_default()));
        }
        let counts: Vec<String> =
            unlisted.iter().take(5).map(|(label, n)| format!("{n} voxels of label {label}")).collect();
        let more = unlisted.len().saturating_sub(5);
        let more = if more > 0 { format!(" and {more} more labels") } else { String::new() };
        let known: Vec<String> = self.known.keys().map(i64::to_string).collect();
        let allowed = format!("0 for the binder and the study's labels: {}", known.join(", "));
        Err(Fault::new(FIELD, counts.join(", ") + &more, &allowed, "add them to layer.microstructure.labels"))
    }

    fn given(self, file: &StudyFile, edges_nm: [f64; 3], pigments: usize) -> Given {
        let (nx, ny, _) = self.cuts[0].dim();
        let mirror = self.table.continuation == Some(Continuation::Mirrored);
        let times = if mirror { 2 } else { 1 };
        let wide = |n: usize, axis: usize| (1e6 * edges_nm[axis] * (times * n) as f64).round() / 1e9;
        let cell_um = [wide(nx, 0), wide(ny, 1), file.layer.thickness_um.mean()];
        let pigments = (0..pigments).map(|k| share_and_size(&self.cuts, k as u8 + 1, edges_nm)).collect();
        let voxel_cut = |labels| VoxelCut::new(&if mirror { mirrored(labels) } else { labels }, mirror);
        let voxels = self.cuts.into_iter().map(voxel_cut).collect();
        Given { cell_um, grains: Vec::new(), voxels, pigments }
    }
}

/// A cut with its mirror images along x and y.
fn mirrored(mut labels: Array3<u8>) -> Array3<u8> {
    for axis in [Axis(0), Axis(1)] {
        let mut image = labels.clone();
        image.invert_axis(axis);
        labels = concatenate![axis, labels, image];
    }
    labels
}

/// Share of a label, and the diameter of spheres with its surface per volume; `None` if it is
/// absent.
fn share_and_size(cuts: &[Array3<u8>], own: u8, edges_nm: [f64; 3]) -> Option<(f64, SizeDistribution)> {
    let all: usize = cuts.iter().map(Array3::len).sum();
    let number = cuts.iter().flatten().filter(|&&label| label == own).count();
    let volume: f64 = edges_nm.iter().product();
    let faces = |axis: usize| cuts.iter().map(|cut| faces(cut, own, axis)).sum::<usize>() as f64;
    let area = (0..3).map(|axis| faces(axis) * volume / edges_nm[axis]).sum::<f64>();
    let value_nm = 6.0 * STAIRS * number as f64 * volume / area;
    let size = SizeDistribution::Constant { value_nm, of: Measure::EffectiveDiameter };
    (number > 0).then_some((number as f64 / all as f64, size))
}

/// Faces of a label across one axis: both ends of every run. The layer's faces count.
fn faces(labels: &Array3<u8>, own: u8, axis: usize) -> usize {
    labels.lanes(Axis(axis)).into_iter().map(|lane| ends(lane, own, axis < 2)).sum()
}

/// Ends of the runs of a label along one line of voxels.
fn ends(lane: ArrayView1<u8>, own: u8, periodic: bool) -> usize {
    let inside = lane.iter().zip(lane.iter().skip(1)).filter(|(a, b)| (**a == own) != (**b == own)).count();
    let [first, last] = [lane[0], lane[lane.len() - 1]].map(|end| end == own);
    let outer = if periodic { usize::from(first != last) } else { usize::from(first) + usize::from(last) };
    inside + outer
}
