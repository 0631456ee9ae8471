//! Grains in given places: the study file as if its pigments had been requested, and the cuts.

mod contacts;
mod placed;
mod voxels;

use super::pigments::{packed, packed_names};
use crate::ink::{Grain, Measure, Shape, SizeDistribution, Sphere, VoxelCut};
use crate::input::file::{MicrostructureTable, PigmentTable, StudyFile};
use crate::input::forms::Pair;
use crate::input::positions::{Positions, read_positions};
use crate::input::{CellRule, Fault, Faults, as_written, keys_in_words, limits};
use crate::numerics::allowed::shown;
use crate::numerics::vector::V3;
use contacts::{ContactRule, Contacts};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

const FIELD: &str = "layer.microstructure";
/// A box this much larger or smaller than the layer is in another unit.
const OTHER_UNIT: f64 = 30.0;

/// What files say of the layer.
#[derive(Default)]
pub(super) struct Given {
    /// Periods and thickness, µm.
    cell_um: V3,
    /// Grains of every realisation.
    pub grains: Vec<Vec<Grain>>,
    /// Labelled voxels instead, one cut per realisation.
    pub voxels: Vec<VoxelCut>,
    /// Share and sizes of every pigment with grains; `None` if no grain is of it.
    pigments: Vec<Option<GivenSizes>>,
    /// What the user should know of how the files were read.
    pub remarks: Vec<String>,
}

/// The grains of a pigment in all cuts.
struct GivenSizes {
    /// Their share of the layer's volume.
    volume_fraction: f64,
    size: SizeDistribution,
}

/// What the study says of the layer that its files describe.
struct StatedLayer {
    /// Periods, µm; by default those of the files.
    period_um: Option<[f64; 2]>,
    thickness_um: f64,
    /// Names of the pigments with grains, in order.
    pigments: Vec<String>,
}

/// A cut with the file that holds it.
struct CutOfFile {
    file: String,
    positions: Positions,
}

/// What is allowed, and what to do, where cuts are equal.
const DIFFERENT: &str = "different cuts, in one or more different files";
const NO_REPEATS: &str = "list every cut once: equal cuts say nothing of the scatter";

/// Fills in the cell, the shares and the sizes of the grains that the study's files hold; returns
/// what the files say. `None`, and the study as it was, without files and after an error.
pub(super) fn fill(file: &mut StudyFile, folder: &Path, faults: &mut Faults) -> Option<Given> {
    let table = file.layer.microstructure.as_ref()?;
    let before = faults.0.len();
    check_beside(file, table, faults);
    let stated = StatedLayer {
        period_um: file.layer.period_um.map(Pair::xy),
        thickness_um: file.layer.thickness_um.mean(),
        pigments: packed_names(&file.pigments),
    };
    let given = table.read(&stated, folder, faults)?;
    let absent = packed(&file.pigments).zip(&given.pigments).find(|(_, sizes)| sizes.is_none());
    if let Some(number) = absent.map(|(pigment, _)| pigment.number)
        && faults.0.len() == before
    {
        let allowed =
            "at least one grain of every pigment; a file without a column pigment has the first only";
        faults.add(format!("pigment[{number}]"), "no grain", allowed, "remove this pigment");
    }
    let cuts = given.grains.len() + given.voxels.len();
    let requested = file.run.realisations.unwrap_or(cuts);
    if requested > cuts {
        let allowed = format!("at most {cuts}, one per cut in the files");
        faults.add("run.realisations", requested, allowed, "leave it out, or add files");
    }
    if faults.0.len() > before {
        return None;
    }
    file.layer.period_um = Some(Pair::Each([given.cell_um[0], given.cell_um[1]]));
    file.layer.cell = CellRule::Fixed;
    file.run.realisations = Some(requested);
    let packed = file.pigments.iter_mut().filter(|table| !table.is_molecular());
    for (table, sizes) in packed.zip(given.pigments.iter().flatten()) {
        table.volume_fraction = Some(sizes.volume_fraction);
        table.size = Some(sizes.size.clone());
    }
    Some(given)
}

impl MicrostructureTable {
    /// Reads all files; `None` after an error that leaves nothing to check further.
    fn read(&self, stated: &StatedLayer, folder: &Path, faults: &mut Faults) -> Option<Given> {
        let names = match (&self.spheres, &self.voxels) {
            (Some(names), None) | (None, Some(names)) => names.all(),
            _ => {
                let found = keys_in_words(self, &["spheres", "voxels"]);
                faults.add(FIELD, found, "either spheres or voxels", "write voxels = \"cut.npy\"");
                return None;
            }
        };
        if let Some(found) = repeated(names, folder) {
            faults.add(FIELD, found, DIFFERENT, NO_REPEATS);
            return None;
        }
        if self.spheres.is_some() {
            self.spheres(names, stated, folder, faults)
        } else {
            self.voxels(names, stated, folder, faults)
        }
    }

    /// Grains of all files of spheres.
    fn spheres(
        &self,
        names: &[String],
        stated: &StatedLayer,
        folder: &Path,
        faults: &mut Faults,
    ) -> Option<Given> {
        let before = faults.0.len();
        let mut cuts = Vec::new();
        for name in names {
            match read_positions(&folder.join(name), self) {
                Ok(cuts_of_file) => {
                    for positions in cuts_of_file {
                        cuts.push(CutOfFile { file: name.clone(), positions });
                    }
                }
                Err(reason) => faults.add(FIELD, name, format!("positions of spheres: {reason}"), FORMATS),
            }
        }
        if faults.0.len() > before {
            return None;
        }
        if let Some(found) = equal_cuts(&cuts) {
            faults.add(FIELD, found, DIFFERENT, NO_REPEATS);
            return None;
        }
        let rule = ContactRule { overlap_um: self.overlap_um };
        if let Some(overlap) = self.overlap_um {
            let remedy = "0.001 allows contacts of a nanometre; leave it out for a thousandth of a diameter";
            faults.number("layer.microstructure.overlap_um", overlap, limits::OVERLAP_UM, remedy);
        }
        let [lx, ly] = stated.period_of(&cuts, faults)?;
        let cell_um = [lx, ly, stated.thickness_um];
        let mut grains = Vec::new();
        let mut contacts = Contacts::default();
        for CutOfFile { file, positions } in &cuts {
            match placed::grains(positions, &stated.pigments, cell_um, rule) {
                Ok(placed) => {
                    contacts = contacts.and(placed.contacts);
                    grains.push(placed.grains);
                }
                Err(fault) => faults.push(Fault { found: format!("{file}: {}", fault.found), ..fault }),
            }
        }
        let pigments = (0..stated.pigments.len()).map(|k| sizes(&grains, k, cell_um)).collect();
        let remarks = contacts.in_words().into_iter().collect();
        Some(Given { cell_um, grains, voxels: Vec::new(), pigments, remarks })
    }
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
fn equal_cuts(cuts: &[CutOfFile]) -> Option<String> {
    let mut known: HashMap<u64, &String> = HashMap::new();
    for CutOfFile { file, positions } in cuts {
        let mut content = DefaultHasher::new();
        for Sphere { center_um: [x, y, z], radius_um } in &positions.spheres {
            [x, y, z, radius_um].map(|number| number.to_bits()).hash(&mut content);
        }
        positions.pigments.hash(&mut content);
        positions.grains.hash(&mut content);
        match known.insert(content.finish(), file) {
            Some(other) if other == file => return Some(format!("{file} with the same frame twice")),
            Some(other) => return Some(format!("{other} and {file} with the same spheres")),
            None => {}
        }
    }
    None
}

const FORMATS: &str = "give CSV with x_um, y_um, z_um and radius_um or diameter_um (or _nm), optionally pigment and grain, a LAMMPS \
                       dump, or extended XYZ";

/// Reports what has no meaning beside given grains.
fn check_beside(file: &StudyFile, table: &MicrostructureTable, faults: &mut Faults) {
    let mut refuse = |found: Option<String>, field: String| {
        if let Some(found) = found {
            let allowed = "nothing beside layer.microstructure, whose grains are placed";
            faults.add(field, found, allowed, "remove it");
        }
    };
    let has_voxels = table.voxels.is_some();
    let keys_of_files = [
        ("unit", table.unit.as_ref().filter(|_| has_voxels).map(as_written)),
        ("size", table.size.as_ref().filter(|_| has_voxels).map(as_written)),
        ("overlap_um", table.overlap_um.as_ref().filter(|_| has_voxels).map(as_written)),
        ("voxel_nm", table.voxel_nm.as_ref().filter(|_| !has_voxels).map(as_written)),
        ("labels", table.labels.as_ref().filter(|_| !has_voxels).map(as_written)),
        ("continuation", table.continuation.as_ref().filter(|_| !has_voxels).map(as_written)),
        ("cuts", table.cuts.as_ref().filter(|_| !has_voxels).map(as_written)),
    ];
    for (key, found) in keys_of_files {
        refuse(found, format!("{FIELD}.{key}"));
    }
    refuse(file.layer.composed.as_ref().map(as_written), "layer.composed".to_owned());
    refuse(file.layer.relief.as_ref().map(as_written), "layer.relief".to_owned());
    let std_um = Some(file.layer.thickness_um.std()).filter(|std_um| *std_um > 0.0);
    refuse(std_um.map(shown), "layer.thickness_um.std".to_owned());
    for pigment in packed(&file.pigments) {
        let PigmentTable { volume_fraction, diameter_nm, size, agglomeration, shell, shape, profile, .. } =
            pigment.table;
        refuse(profile.as_ref().map(as_written), pigment.field("profile"));
        refuse(volume_fraction.as_ref().map(as_written), pigment.field("volume_fraction"));
        refuse(diameter_nm.as_ref().map(as_written), pigment.field("diameter_nm"));
        refuse(size.as_ref().map(as_written), pigment.field("size"));
        refuse(agglomeration.as_ref().map(as_written), pigment.field("agglomeration"));
        refuse((has_voxels && !shell.is_empty()).then(|| as_written(shell)), pigment.field("shell"));
        let shape = Some(shape).filter(|shape| has_voxels && **shape != Shape::default());
        refuse(shape.map(as_written), pigment.field("shape"));
    }
}

impl StatedLayer {
    /// The period: of the files, or as written; both must agree.
    fn period_of(&self, cuts: &[CutOfFile], faults: &mut Faults) -> Option<[f64; 2]> {
        let boxed = || cuts.iter().filter_map(|cut| Some((&cut.file, box_sides_um(&cut.positions)?)));
        let period_of_files = boxed().next().map(|(_, [x, y, _])| [x, y]);
        let Some(period) = self.period_um.or(period_of_files) else {
            let allowed = "one number or [x, y], µm: these files have no box";
            faults.add("layer.period_um", "nothing", allowed, "give the period of the positions");
            return None;
        };
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b;
        let is_wide = |[x, y, _]: V3| close(x, period[0]) && close(y, period[1]);
        if let Some((file, [x, y, _])) = boxed().find(|(_, sides)| !is_wide(*sides)) {
            let unit = other_unit(x / period[0]);
            let found = format!("{file} with a box of {x} × {y} µm{unit}");
            let allowed = format!("the period {} × {} µm of all files", period[0], period[1]);
            faults.add(FIELD, found, allowed, "leave layer.period_um out, or correct unit");
            return None;
        }
        let thickness = self.thickness_um;
        if let Some((file, [_, _, height])) = boxed().find(|(_, [_, _, height])| !close(*height, thickness)) {
            let found = format!("{file} with a box {height} µm high{}", other_unit(height / thickness));
            let allowed = format!("the thickness of the layer, layer.thickness_um = {thickness}");
            let remedy = "make both equal: z runs from the lit face, the lower end of the box, to the paper; or correct unit";
            faults.add(FIELD, found, allowed, remedy);
            return None;
        }
        Some(period)
    }
}

/// Sides of the box of a cut, µm, if its file has one.
fn box_sides_um(positions: &Positions) -> Option<V3> {
    positions.box_um.map(|ranges| ranges.map(|[low, high]| high - low))
}

/// A question where a length differs by more than any mistake but that of the unit.
fn other_unit(ratio: f64) -> &'static str {
    if (1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) { "" } else { "; is unit right?" }
}

/// Share of the layer and sizes of a pigment's grains.
fn sizes(cuts: &[Vec<Grain>], pigment: usize, [lx, ly, h]: V3) -> Option<GivenSizes> {
    let grains = cuts.iter().flatten().filter(|grain| grain.pigment == pigment);
    let um3: Vec<f64> = grains.map(|grain| grain.volume_um3).collect();
    let volume_fraction = um3.iter().sum::<f64>() / (lx * ly * h * cuts.len() as f64);
    let diameter = |v: f64| 1e3 * (6.0 * v / std::f64::consts::PI).cbrt();
    let mut values_nm: Vec<f64> = um3.into_iter().map(diameter).collect();
    values_nm.sort_by(f64::total_cmp);
    if values_nm.is_empty() {
        return None;
    }
    let size = SizeDistribution::List { values_nm, weights: Vec::new(), of: Measure::EffectiveDiameter };
    Some(GivenSizes { volume_fraction, size })
}
