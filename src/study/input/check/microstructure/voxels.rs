//! Voxels of a microstructure: labels become pigments, files become cuts.

use super::{FIELD, Given, GivenSizes, StatedLayer};
use crate::ink::packing::sizes::MOST_GRAINS;
use crate::ink::{Measure, SizeDistribution, VoxelCut};
use crate::input::file::{Continuation, LabelPigments, MicrostructureTable, VoxelEdges};
use crate::input::voxels::{LabelImage, MOST_VOXELS, read_labels};
use crate::input::{Fault, Faults, limits};
use ndarray::{Array3, ArrayView1, Axis, concatenate, s};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

/// Faces of voxels exceed a smooth surface of all directions by this factor: the mean of
/// |nx| + |ny| + |nz|.
const STAIRS: f64 = 1.5;

impl MicrostructureTable {
    /// The cuts of all files of voxels; `None` after an error.
    pub(super) fn voxels(
        &self,
        names: &[String],
        stated: &StatedLayer,
        folder: &Path,
        faults: &mut Faults,
    ) -> Option<Given> {
        let before = faults.0.len();
        let field = "layer.microstructure.voxel_nm";
        let remedy = "give the edge of a voxel in nm";
        let Some(edges_nm) = self.voxel_nm.map(VoxelEdges::xyz) else {
            faults.add(field, "nothing", limits::VOXEL_NM.to_string(), remedy);
            return None;
        };
        if let Some(&edge) = edges_nm.iter().find(|&&edge| !limits::VOXEL_NM.holds(edge)) {
            faults.number(field, edge, limits::VOXEL_NM, remedy);
        }
        for (axis, count) in self.cuts.into_iter().flatten().enumerate() {
            let field = format!("layer.microstructure.cuts[{axis}]");
            faults.whole(&field, count, limits::CUTS, "[2, 2] makes four realisations of one file");
        }
        let known = known_labels(self, &stated.pigments, faults);
        if faults.0.len() > before {
            return None;
        }
        let mut reader = VoxelReader {
            table: self,
            known,
            height: 1e3 * stated.thickness_um / edges_nm[2],
            cuts: Vec::new(),
            contents: BTreeMap::new(),
            remarks: Vec::new(),
        };
        for name in names {
            if let Err(fault) = reader.read(name, &folder.join(name)) {
                faults.push(Fault { found: format!("{name}: {}", fault.found), ..fault });
            }
        }
        if faults.0.len() > before || reader.cuts.is_empty() {
            return None;
        }
        let mut given = match reader.given(stated, edges_nm) {
            Ok(given) => given,
            Err(fault) => {
                faults.push(fault);
                return None;
            }
        };
        if let Some([x, y]) = stated.period_um {
            let [lx, ly, _] = given.cell_um;
            if (x - lx).abs() > 1e-6 * lx || (y - ly).abs() > 1e-6 * ly {
                let allowed = format!("{lx} × {ly} µm, the width of a cut");
                faults.add("layer.period_um", format!("{x} × {y} µm"), allowed, "leave it out");
                return None;
            }
            // a written period may have more digits than the edge of a voxel
            given.cell_um = [x, y, given.cell_um[2]];
        }
        Some(given)
    }
}

/// What the labels other than 0 are, as k + 1 for pigment k.
enum KnownLabels {
    /// All of them are of one pigment.
    One(u8),
    /// Those listed; others are mistakes.
    Each(BTreeMap<i64, u8>),
}

/// The pigment of every label.
fn known_labels(table: &MicrostructureTable, pigments: &[String], faults: &mut Faults) -> KnownLabels {
    let kind_of = |name: &String| {
        let place = pigments.iter().position(|pigment| pigment == name);
        place.and_then(|k| u8::try_from(k + 1).ok())
    };
    let allowed_names = || format!("the name of a pigment with grains: {}", pigments.join(", "));
    let labels = match &table.labels {
        None => return KnownLabels::Each((1..).zip(1..).take(pigments.len()).collect()),
        Some(LabelPigments::One(name)) => {
            if kind_of(name).is_none() {
                let field = "layer.microstructure.labels";
                faults.add(field, format!("{name:?}"), allowed_names(), "name it in [[pigment]]");
            }
            return KnownLabels::One(kind_of(name).unwrap_or(1));
        }
        Some(LabelPigments::Each(labels)) => labels,
    };
    let mut known = BTreeMap::new();
    for (label, name) in labels {
        let field = format!("layer.microstructure.labels.{label}");
        let number = label.parse::<i64>().ok().filter(|&n| n != 0);
        match (number, kind_of(name)) {
            (Some(number), Some(kind)) => drop(known.insert(number, kind)),
            (None, _) => {
                let allowed = "integers other than 0, which is the binder";
                faults.add(field, format!("label {label:?}"), allowed, "write 1 = \"yellow\"");
            }
            _ => faults.add(field, format!("{name:?}"), allowed_names(), "name it in [[pigment]]"),
        }
    }
    KnownLabels::Each(known)
}

/// The cuts read so far, as labels from 1 for the pigments.
struct VoxelReader<'a> {
    table: &'a MicrostructureTable,
    known: KnownLabels,
    /// The layer's thickness in voxels.
    height: f64,
    cuts: Vec<Array3<u8>>,
    /// Files by a hash of their labels.
    contents: BTreeMap<u64, String>,
    remarks: Vec<String>,
}

impl VoxelReader<'_> {
    fn read(&mut self, name: &str, path: &Path) -> Result<(), Fault> {
        let labels = self.pigments(name, path)?;
        let (nx, ny, nz) = labels.dim();
        if (self.height - nz as f64).abs() > 1e-6 * nz as f64 {
            let thick = (1e3 * self.height).round() / 1e3;
            let found = format!("{nz} voxels along z, the last axis, in a layer {thick} voxels thick");
            let allowed = "layer.thickness_um = voxels along z × voxel_nm / 1000";
            let remedy = "correct layer.thickness_um or voxel_nm, or transpose the array to x, y, z";
            return Err(Fault::new(FIELD, found, allowed, remedy));
        }
        self.check_number(self.cuts.iter().map(Array3::len).sum::<usize>().saturating_add(labels.len()))?;
        let mut content = DefaultHasher::new();
        labels.hash(&mut content);
        if let Some(other) = self.contents.insert(content.finish(), name.to_owned()) {
            let found = format!("the same labels as {other}");
            return Err(Fault::new(FIELD, found, super::DIFFERENT, super::NO_REPEATS));
        }
        let [across, along] = self.table.cuts.unwrap_or([1, 1]);
        if nx % across > 0 || ny % along > 0 {
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

    /// Refuses more voxels than one image may have, in all cuts with their images.
    fn check_number(&self, voxels: usize) -> Result<(), Fault> {
        let allowed = format!("at most {} million voxels in all cuts", MOST_VOXELS / 1_000_000);
        let remedy = "crop the images, or take fewer of them";
        let fault = || Fault::new(FIELD, format!("{voxels} voxels"), allowed, remedy);
        if voxels > MOST_VOXELS { Err(fault()) } else { Ok(()) }
    }

    /// Labels of a file as 0 for the binder and k + 1 for pigment k.
    fn pigments(&mut self, name: &str, path: &Path) -> Result<Array3<u8>, Fault> {
        let mut unlisted: BTreeMap<i64, usize> = BTreeMap::new();
        // labels come in runs
        let (mut last, mut kind) = (0, Some(0));
        let mut take = |label: i64| {
            if label != last {
                last = label;
                kind = match &self.known {
                    _ if label == 0 => Some(0),
                    KnownLabels::One(kind) => Some(*kind),
                    KnownLabels::Each(known) => known.get(&label).copied(),
                };
            }
            if kind.is_none() {
                *unlisted.entry(label).or_default() += 1;
            }
            kind.unwrap_or_default()
        };
        let formats = "integers with axes x, y, z in a NumPy array (.npy), or a stack of TIFF pages";
        let read = read_labels(path, &mut take);
        let image = read.map_err(|found| Fault::new(FIELD, found, formats, "convert the file"))?;
        let LabelImage { labels, white_is_zero } = image;
        if white_is_zero {
            self.remarks.push(format!(
                "{FIELD}: {name} calls 0 white, so that other programs show it the other way round; its labels are the numbers \
                 as they are stored, and 0 is the binder"
            ));
        }
        if unlisted.is_empty() {
            return Ok(labels);
        }
        let counts: Vec<String> =
            unlisted.iter().take(5).map(|(label, n)| format!("{n} voxels of label {label}")).collect();
        let more = unlisted.len().saturating_sub(5);
        let more = if more > 0 { format!(" and {more} more labels") } else { String::new() };
        let known: Vec<String> = match &self.known {
            KnownLabels::One(_) => Vec::new(),
            KnownLabels::Each(known) => known.keys().map(i64::to_string).collect(),
        };
        let allowed = format!("0 for the binder and the study's labels: {}", known.join(", "));
        let remedy = "add them to layer.microstructure.labels, or write labels = \"yellow\" where every label but 0 \
                      is a grain of one pigment";
        Err(Fault::new(FIELD, counts.join(", ") + &more, &allowed, remedy))
    }

    fn given(self, stated: &StatedLayer, edges_nm: [f64; 3]) -> Result<Given, Fault> {
        let (nx, ny, nz) = self.cuts[0].dim();
        let is_mirrored = self.table.continuation == Some(Continuation::Mirrored);
        let times = if is_mirrored { 2 } else { 1 };
        self.check_number(
            (times * nx).saturating_mul(times * ny).saturating_mul(nz).saturating_mul(self.cuts.len()),
        )?;
        let width_um = |n: usize, axis: usize| (1e6 * edges_nm[axis] * (times * n) as f64).round() / 1e9;
        let cell_um = [width_um(nx, 0), width_um(ny, 1), stated.thickness_um];
        let labels = (1..=u8::MAX).take(stated.pigments.len());
        let pigments = labels.map(|label| sizes(&self.cuts, label, edges_nm)).collect();
        let mut voxels = Vec::new();
        for labels in self.cuts {
            let labels = if is_mirrored { mirrored(labels) } else { labels };
            let merged = VoxelCut::of_at_most(MOST_GRAINS, &labels, is_mirrored);
            voxels.push(merged.ok_or_else(|| {
                let found = format!("voxels that merge to more than {MOST_GRAINS} boxes of one label");
                Fault::new(FIELD, found, "coarser images", "crop the image, or remove its noise")
            })?);
        }
        Ok(Given { cell_um, grains: Vec::new(), voxels, pigments, remarks: self.remarks })
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
fn sizes(cuts: &[Array3<u8>], label: u8, edges_nm: [f64; 3]) -> Option<GivenSizes> {
    let all: usize = cuts.iter().map(Array3::len).sum();
    let number = cuts.iter().flatten().filter(|&&other| other == label).count();
    if number == 0 {
        return None;
    }
    let volume: f64 = edges_nm.iter().product();
    let faces = |axis: usize| cuts.iter().map(|cut| faces(cut, label, axis)).sum::<usize>() as f64;
    let area = (0..3).map(|axis| faces(axis) * volume / edges_nm[axis]).sum::<f64>();
    let value_nm = 6.0 * STAIRS * number as f64 * volume / area;
    let size = SizeDistribution::Constant { value_nm, of: Measure::EffectiveDiameter };
    Some(GivenSizes { volume_fraction: number as f64 / all as f64, size })
}

/// Faces of a label across one axis: both ends of every run. The layer's faces count.
fn faces(labels: &Array3<u8>, label: u8, axis: usize) -> usize {
    let is_periodic = axis < 2;
    labels.lanes(Axis(axis)).into_iter().map(|lane| ends(lane, label, is_periodic)).sum()
}

/// Ends of the runs of a label along one line of voxels.
fn ends(lane: ArrayView1<u8>, label: u8, is_periodic: bool) -> usize {
    let is_end = |(a, b): &(&u8, &u8)| (**a == label) != (**b == label);
    let inside = lane.iter().zip(lane.iter().skip(1)).filter(is_end).count();
    let at_start = lane[0] == label;
    let at_end = lane[lane.len() - 1] == label;
    let outer = match is_periodic {
        true => usize::from(at_start != at_end),
        false => usize::from(at_start) + usize::from(at_end),
    };
    inside + outer
}
