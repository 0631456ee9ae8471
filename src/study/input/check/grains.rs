//! The grains of a pigment: their sizes, whether they fit into the layer, their number, and the
//! nominal period that they require.

use super::cell::NominalCell;
use super::pigments::{NumberedPigment, packed};
use crate::ink::packing::sizes::{MORE_ROOM, MOST_GRAINS, too_few_grains};
use crate::ink::{Measure, PigmentGrains, SizeDistribution};
use crate::input::file::PigmentTable;
use crate::input::forms::Diameter;
use crate::input::variation::AREA;
use crate::input::{CellRule, Faults, keys_in_words, limits};

/// Maximum area of a cell that is enlarged to hold a grain: sides of 1000 µm are the largest
/// allowed.
const WIDEST_UM2: f64 = 1e6;
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

impl NumberedPigment<'_> {
    /// The grains to pack in a cell.
    pub(super) fn packed_grains(&self, cell: &NominalCell, faults: &mut Faults) -> PigmentGrains {
        let before = faults.0.len();
        self.check_fraction(faults);
        let grains = self.grains(faults);
        let size_field = self.field(if self.table.diameter_nm.is_some() { "diameter_nm" } else { "size" });
        check_extents(&size_field, &grains, cell, faults);
        if faults.0.len() == before && grains.shape.defect().is_none() {
            self.check_count(&size_field, &grains, cell, faults);
        }
        grains
    }

    /// Reports a volume fraction that is missing or not allowed.
    pub(super) fn check_fraction(&self, faults: &mut Faults) {
        let field = self.field("volume_fraction");
        let remedy = "a share of the layer's volume, such as 0.3 for 30 %";
        match self.table.volume_fraction {
            Some(share) => faults.number(&field, share, limits::VOLUME_FRACTION, remedy),
            None => faults.add(field, "nothing", limits::VOLUME_FRACTION.to_string(), remedy),
        }
    }

    /// The grains with the sizes that the file gives.
    pub(super) fn grains(&self, faults: &mut Faults) -> PigmentGrains {
        let size = self.table.written_size().unwrap_or_else(|| {
            let remedy = "write diameter_nm = 250 for grains that are all alike";
            let field = format!("pigment[{}]", self.number);
            let found = keys_in_words(self.table, &["diameter_nm", "size"]);
            faults.add(field, found, "either diameter_nm or size", remedy);
            SizeDistribution::diameter_nm(1e-3)
        });
        self.table.grains_of(size)
    }

    /// Reports that there are too many or too few grains.
    fn check_count(&self, size_field: &str, grains: &PigmentGrains, cell: &NominalCell, faults: &mut Faults) {
        let [x, y] = cell.period_um;
        // an invalid cell is reported separately
        if ![x, y, cell.thickness_um].iter().all(|length| length.is_finite() && *length > 0.0) {
            return;
        }
        let usual_um2 = x * y;
        let (drawn_um2, widest_um2, widest_in_words) = match cell.rule {
            CellRule::Fixed => (usual_um2, usual_um2, "the cell"),
            CellRule::Varied => {
                (AREA[1] * usual_um2, WIDEST_UM2.max(usual_um2), "the widest cell, 1000 × 1000 µm")
            }
        };
        let most = grains.expected(drawn_um2 * cell.thickness_um);
        let least_share = grains.least_share(widest_um2 * cell.thickness_um);
        if most > MOST_GRAINS as f64 {
            let found = format!("grains so small that a cell may hold {most:.1e} of them");
            let remedy = "sizes are in nm and periods in µm; take larger grains, a smaller layer.period_um, or \"molecular\"";
            faults.add(size_field, found, format!("at most {MOST_GRAINS} grains in a cell"), remedy);
        } else if grains.volume_fraction < least_share {
            let found = format!("{:e}", grains.volume_fraction);
            let allowed = too_few_grains(least_share, widest_in_words);
            faults.add(self.field("volume_fraction"), found, allowed, MORE_ROOM);
        }
    }
}

impl PigmentTable {
    /// The sizes of the grains; `None` unless they are given once.
    fn written_size(&self) -> Option<SizeDistribution> {
        match (self.diameter_nm, &self.size) {
            (Some(Diameter::Nm(nm)), None) => Some(SizeDistribution::diameter_nm(nm)),
            (None, Some(size)) => Some(size.clone()),
            _ => None,
        }
    }

    fn grains_of(&self, size: SizeDistribution) -> PigmentGrains {
        PigmentGrains {
            shape: self.shape.clone(),
            size,
            shell_nm: self.shell.iter().map(|layer| layer.thickness_nm).collect(),
            volume_fraction: self.volume_fraction.unwrap_or(0.0),
            orientation: self.orientation,
            agglomeration: self.agglomeration.clone(),
            share: self.share,
            profile: self.profile.clone().unwrap_or_default(),
            optic_axis: self.index.is_birefringent().then(|| self.optic_axis.unwrap_or([0.0, 0.0, 1.0])),
        }
    }

    /// Period required by the largest grains, µm; `None` if their size or shape is invalid.
    fn needed_period_um(&self) -> Option<f64> {
        let size = self.written_size().filter(|size| size.defect().is_none())?;
        let grains = self.grains_of(size);
        if grains.shape.defect().is_some() {
            return None;
        }
        let (_, longest) = largest_extents_nm(&grains);
        let template = grains.shape.template();
        let diameter = template.effective_diameter() / template.length * longest;
        Some(1e-3 * (DIAMETERS * diameter).max(LONGEST * longest))
    }
}

/// Default nominal period: the usual one, or what the largest grains require, µm.
pub(super) fn nominal_period_um(pigments: &[PigmentTable]) -> f64 {
    let needed = packed(pigments).filter_map(|pigment| pigment.table.needed_period_um());
    let longest = needed.fold(USUAL_PERIOD_UM, f64::max);
    (longest / PERIOD_STEP_UM - 1e-9).ceil() * PERIOD_STEP_UM
}

/// Checks that grains fit between the walls and do not touch their own periodic images.
fn check_extents(field: &str, grains: &PigmentGrains, cell: &NominalCell, faults: &mut Faults) {
    if grains.shape.defect().is_some() {
        // the packing's own check reports errors in the shape
        return;
    }
    if let Some((_, found, allowed)) = grains.size.defect() {
        faults.add(field, found, allowed, "correct these numbers; pigment grains measure 50 to 500 nm");
        return;
    }
    let (thickest_nm, longest_nm) = largest_extents_nm(grains);
    let across = Extent {
        nm: longest_nm,
        limit_nm: 500.0 * cell.shortest_side_um(),
        limit_in_words: match cell.rule {
            CellRule::Fixed => "half the layer's period",
            CellRule::Varied => "half the shortest side that a varied cell gets (0.65 layer.period_um)",
        },
        larger_layer: "a larger cell, layer.period_um",
        layer_um: cell.period_um[0].max(cell.period_um[1]),
    };
    let along_z = Extent {
        nm: thickest_nm,
        limit_nm: 1e3 * cell.thinnest_um(),
        limit_in_words: if cell.thickness_std_um > 0.0 {
            "the thinnest layer drawn, mean - 3 std of layer.thickness_um"
        } else if cell.is_slab {
            "half of layer.composed.slab_um"
        } else {
            "the layer's thickness"
        },
        larger_layer: "a thicker layer, layer.thickness_um",
        layer_um: cell.thickness_um,
    };
    let Some(wrong) = [across, along_z].into_iter().find(Extent::is_too_large) else { return };
    let rounded = |nm: f64| (1e6 * nm).round() / 1e6;
    let found = format!("grains of up to {} nm", rounded(wrong.nm));
    let allowed = format!("grains of at most {} nm, {}", rounded(wrong.limit_nm), wrong.limit_in_words);
    let needed_um = (100.0 * wrong.layer_um * wrong.nm / wrong.limit_nm - 1e-9).ceil() / 100.0;
    let remedy = format!(
        "pigment grains measure 50 to 500 nm, flakes more; take smaller grains or {} = {needed_um} or more",
        wrong.larger_layer
    );
    faults.add(field, found, allowed, remedy);
}

/// Size of the largest grain along one direction, and the room that it has.
struct Extent {
    nm: f64,
    limit_nm: f64,
    limit_in_words: &'static str,
    /// The key that gives more room.
    larger_layer: &'static str,
    /// Its value, µm.
    layer_um: f64,
}

impl Extent {
    fn is_too_large(&self) -> bool {
        // an invalid cell is reported separately
        self.limit_nm > 0.0 && self.nm > self.limit_nm * (1.0 + 1e-12)
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
