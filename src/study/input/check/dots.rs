//! The dots of a halftone print: kinds of area and the screen.

use crate::input::file::{AreaBears, AreaTable, DotsTable};
use crate::input::study::Dots;
use crate::input::{Allowed, Faults, limits};

/// Rounding of coverages that add up to 1.
const SLACK: f64 = 1e-6;

/// The tints of a study; `None` where it prints a solid alone, or after an error.
pub(super) fn checked(screen: &DotsTable, areas: &[AreaTable], faults: &mut Faults) -> Option<Dots> {
    let before = faults.0.len();
    if areas.is_empty() {
        let given = screen.ruling_per_cm.is_some() || screen.spread_um.is_some();
        if given || screen.physical_gain != 0.0 {
            let remedy = "add [[area]] with coverage = [0.25, 0.5, 0.75], or remove [dots]";
            faults.add("dots", "a screen without areas", "a screen with [[area]]", remedy);
        }
        return None;
    }
    faults.number("dots.physical_gain", screen.physical_gain, limits::DOT_GAIN, "0 to 0.1 is usual");
    let ruling_per_cm = required("dots.ruling_per_cm", screen.ruling_per_cm, limits::RULING_PER_CM, faults);
    let spread_um = required("dots.spread_um", screen.spread_um, limits::SPREAD_UM, faults);
    let count = areas[0].coverage.all().len();
    for (i, area) in areas.iter().enumerate() {
        let all = area.coverage.all();
        let field = format!("area[{i}].coverage");
        if all.len() != count || all.is_empty() {
            let allowed = format!("{} entries, as in area[0]", count.max(1));
            faults.add(&field, format!("{} entries", all.len()), allowed, "give one coverage for each tint");
        }
        for coverage in all {
            faults.number(&field, coverage, limits::SHARE, "0.5 covers half of the area");
        }
    }
    if faults.0.len() > before {
        return None;
    }
    let sum = |bears: AreaBears, tint: usize| -> f64 {
        areas.iter().filter(|area| area.bears == bears).map(|area| area.coverage.all()[tint]).sum()
    };
    let has_paper = areas.iter().any(|area| area.bears == AreaBears::Paper);
    for tint in 0..count {
        let whole = sum(AreaBears::Layer, tint) + sum(AreaBears::Paper, tint);
        if whole > 1.0 + SLACK || (has_paper && whole < 1.0 - SLACK) {
            let allowed = if has_paper { "1, since bare paper is among them" } else { "at most 1" };
            let remedy =
                "coverages share the area: change one, or leave out the bare paper, which is what they leave";
            faults.add("area.coverage", format!("a sum of {whole} in tint {}", tint + 1), allowed, remedy);
            return None;
        }
    }
    let nominal = (0..count).map(|tint| sum(AreaBears::Layer, tint).min(1.0)).collect();
    let physical_gain = screen.physical_gain;
    Some(Dots { nominal, ruling_per_cm: ruling_per_cm?, spread_um: spread_um?, physical_gain })
}

/// A number of the screen, which dots need.
fn required(field: &str, value: Option<f64>, allowed: Allowed, faults: &mut Faults) -> Option<f64> {
    let remedy = "ruling_per_cm = 60 and spread_um = 40 are usual of offset prints on coated paper";
    match value {
        Some(value) => faults.number(field, value, allowed, remedy),
        None => faults.add(field, "nothing", format!("{allowed}, since there are areas"), remedy),
    }
    value
}
