//! What a design aims at: the colour and the numbers, checked with the studies at the ends of all
//! ranges.

use super::{DesignTask, corner};
use crate::design::file::TargetTable;
use crate::design::surface::{Eye, WantedColour};
use crate::design::wish::{NumberWish, check_kinds, check_ranges, wishes};
use crate::input::fault::{Fault, Faults};
use crate::input::field::set;
use crate::input::measured::MeasuredCondition;
use crate::input::study::Study;
use crate::numerics::allowed::Allowed;
use std::path::Path;
use toml::{Table, Value};

/// The target as the base's own.
pub(super) fn put_target(base: &mut Table, target: &TargetTable, folder: &Path, faults: &mut Faults) {
    if let Some(Value::Table(compare)) = base.get_mut("compare") {
        compare.clear();
    }
    if let Some(Value::Table(colour)) = base.get_mut("colour") {
        colour.remove("target_lab");
    }
    match (&target.lab, &target.file) {
        (Some(lab), None) => {
            let _ = set(base, "colour.target_lab", &lab.to_vec().into());
        }
        (None, Some(file)) => {
            let path = folder.join(file);
            let path = std::path::absolute(&path).unwrap_or(path).display().to_string();
            let unit = target.unit.and_then(|unit| Value::try_from(unit).ok());
            let patch = target.patch.as_ref().and_then(|patch| Value::try_from(patch).ok());
            let condition = target.condition.and_then(|condition| Value::try_from(condition).ok());
            let measured = Some(path.into());
            for (key, value) in
                [("measured", measured), ("patch", patch), ("unit", unit), ("condition", condition)]
            {
                let _ = value.map(|value| set(base, &format!("compare.{key}"), &value));
            }
        }
        (None, None) if !target.number.is_empty() => (),
        (both, _) => {
            let found = if both.is_some() { "lab and file" } else { "neither lab nor file nor number" };
            let allowed = "either lab, or file with a spectrum or a colour, or [[target.number]] beside or without a colour";
            faults.add("target", found, allowed, "write lab = [85, -10, 80]");
        }
    }
    check_ranges(&target.number, faults);
    if let Some(ratio) = target.contrast_ratio {
        let remedy = "0.98 hides nearly everything";
        faults.number("target.contrast_ratio", ratio, Allowed::between(0.0, 1.0, ""), remedy);
    }
}

/// The target of a design.
pub(super) struct DesignTarget {
    /// L*, a*, b*.
    pub lab: Option<[f64; 3]>,
    /// Weighted numbers.
    pub numbers: Vec<NumberWish>,
    /// What was taken where its file leaves something open.
    pub remarks: Vec<String>,
    /// The light under which it was measured, if that is known.
    pub condition: Option<MeasuredCondition>,
}

/// Whether a base is composed of slabs.
pub(super) fn is_composed(base: &Table) -> bool {
    let has = |table: &str| base.get(table).and_then(|table| table.get("composed")).is_some();
    has("layer") || has("stack")
}

/// The base without its slabs: composed studies hold no measurement, and the target may be one.
pub(super) fn uncomposed(base: &Table) -> Table {
    let mut base = base.clone();
    for table in ["layer", "stack"] {
        if let Some(Value::Table(table)) = base.get_mut(table) {
            table.remove("composed");
        }
    }
    base
}

/// Checks the studies at all corners of the box and gives the target, of a sample that is named or
/// the only one of its file; `measuring` is the base that names this file.
pub(super) fn checked_ends(
    task: &DesignTask,
    target: &TargetTable,
    measuring: &Table,
) -> Result<DesignTarget, Vec<Fault>> {
    let count = task.variables.len();
    let studies = (0..1 << count).map(|c| task.study(&corner(c, count)));
    let studies = studies.collect::<Result<Vec<Study>, _>>()?;
    let study = &studies[studies.len() - 1];
    if let Some(several) = study.composed().filter(|composed| composed.thicknesses_um.len() > 1) {
        let found = format!("{:?}", several.thicknesses_um);
        let remedy = "give one thickness, and its range as a [[vary]]: no further solves are needed for it";
        return Err(vec![Fault::new("base.layer.thickness_um", found, "one thickness", remedy)]);
    }
    let of_target = match *measuring == task.base {
        true => None,
        false => {
            let task = DesignTask { base: measuring.clone(), ..task.clone() };
            Some(task.study(&corner((1 << count) - 1, count))?)
        }
    };
    let of_target = of_target.as_ref().unwrap_or(study);
    if let Some(reason) = study.no_paper() {
        let remedy = "write [angles] count = 5";
        return Err(vec![Fault::new("base.angles", reason, "0°, 45° and the hemisphere", remedy)]);
    }
    if let Some(measured) = of_target
        .judgement
        .measured
        .as_ref()
        .filter(|measured| measured.patches > 1 && target.patch.is_none())
    {
        let found = format!("nothing, and {} samples in the file", measured.patches);
        let allowed = format!("the name of one of them; the first is {}", measured.source);
        let remedy = "write target.patch = \"…\" with the name of the sample that has the target colour";
        return Err(vec![Fault::new("target.patch", found, allowed, remedy)]);
    }
    let of_files = |remark: &&String| ["compare.", "paper."].iter().any(|start| remark.starts_with(start));
    let named =
        |remark: &String| remark.replace("compare.measured", "target.file").replace("compare.", "target.");
    let mut remarks: Vec<String> = of_target.remarks.iter().filter(of_files).map(named).collect();
    let numbers = wishes(&target.number, study)?;
    let mut faults = Faults::default();
    check_kinds(&numbers, &mut faults);
    let has_colour = target.lab.is_some() || target.file.is_some();
    if !has_colour && let Err(error) = Eye::new(study) {
        let allowed = "wavelengths that carry a colour: recipes are told with their colours";
        faults.add("base.light", error, allowed, "give [light] of the base 400 to 700 nm at least");
    }
    if !faults.0.is_empty() {
        return Err(faults.0);
    }
    let colour = if has_colour { Some(WantedColour::of(of_target)?) } else { None };
    let lab = colour.as_ref().map(|colour| colour.lab);
    remarks.extend(colour.and_then(|colour| colour.remark));
    let condition = of_target.judgement.condition;
    Ok(DesignTarget { lab, numbers, remarks, condition })
}
