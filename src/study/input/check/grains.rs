//! Grains that fit into the layer: their sizes, their number, and the nominal period that they
//! require.

use crate::ink::packing::sizes::{MORE_ROOM, MOST_GRAINS, too_few_grains};
use crate::ink::{Measure, PigmentGrains, SizeDistribution};
use crate::input::file::{LayerTable, PigmentTable};
use crate::input::forms::Diameter;
use crate::input::variation::{AREA, THICKNESS_CUT, shortest_side_um};
use crate::input::{CellRule, Faults, StudyFile, limits};

/// Maximum area of a cell that is enlarged to hold a grain: sides of 1000 µm are the largest
/// allowed.
const WIDEST_UM2: f64 = 1e6;

/// The pigments with grains and their places in the file.
pub(super) fn packed(file: &StudyFile) -> impl Iterator<Item = (usize, &PigmentTable)> {
    file.pigments.iter().enumerate().filter(|(_, table)| !is_molecular(table))
}

pub(super) fn is_molecular(table: &PigmentTable) -> bool {
    matches!(table.diameter_nm, Some(Diameter::Vanishing(_)))
}

pub(super) fn of(pigment: usize, key: &str) -> String {
    format!("pigment[{pigment}].{key}")
}

pub(super) fn fraction(i: usize, table: &PigmentTable, faults: &mut Faults) {
    let remedy = "a share of the layer's volume, such as 0.3 for 30 %";
    match table.volume_fraction {
        Some(share) => faults.number(&of(i, "volume_fraction"), share, limits::VOLUME_FRACTION, remedy),
        None => faults.add(of(i, "volume_fraction"), "nothing", limits::VOLUME_FRACTION.to_string(), remedy),
    }
}

/// A layer and the nominal period of its cells.
pub(super) type NominalCell<'a> = (&'a LayerTable, [f64; 2]);

/// The grains of one pigment.
pub(super) fn grains_of(
    i: usize,
    table: &PigmentTable,
    layer: NominalCell,
    faults: &mut Faults,
) -> PigmentGrains {
    let before = faults.0.len();
    fraction(i, table, faults);
    let grains = as_written(table, size(i, table, faults));
    let field = of(i, if table.diameter_nm.is_some() { "diameter_nm" } else { "size" });
    fits(&field, &grains, layer, faults);
    if faults.0.len() == before && grains.shape.defect().is_none() {
        count([field, of(i, "volume_fraction")], &grains, layer, faults);
    }
    grains
}

pub(super) fn as_written(table: &PigmentTable, size: SizeDistribution) -> PigmentGrains {
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

pub(super) fn size(i: usize, table: &PigmentTable, faults: &mut Faults) -> SizeDistribution {
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

/// Reports an error in the field `size` or `share` if there are too many or too few grains.
fn count(
    [size, share]: [String; 2],
    grains: &PigmentGrains,
    (layer, [x, y]): (&LayerTable, [f64; 2]),
    faults: &mut Faults,
) {
    let thickness_um = layer.thickness_um.mean();
    // an invalid cell is reported separately
    if ![x, y, thickness_um].iter().all(|length| length.is_finite() && *length > 0.0) {
        return;
    }
    let (drawn, widest, cell) = match layer.cell {
        CellRule::Fixed => (x * y, x * y, "the cell"),
        CellRule::Varied => (AREA[1] * x * y, WIDEST_UM2.max(x * y), "the widest cell, 1000 × 1000 µm"),
    };
    let most = grains.expected(drawn * thickness_um);
    let least_share = grains.least_share(widest * thickness_um);
    if most > MOST_GRAINS as f64 {
        let found = format!("grains so small that a cell may hold {most:.1e} of them");
        let remedy = "sizes are in nm and periods in µm; take larger grains, a smaller layer.period_um, or \"molecular\"";
        faults.add(size, found, format!("at most {MOST_GRAINS} grains in a cell"), remedy);
    } else if grains.volume_fraction < least_share {
        let found = format!("{:e}", grains.volume_fraction);
        faults.add(share, found, too_few_grains(least_share, cell), MORE_ROOM);
    }
}
