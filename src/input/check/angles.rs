//! Angles of incidence: quadrature nodes for the picture, or a list.

use super::check_list;
use crate::appearance::angles::{AngleNode, AngleRule};
use crate::appearance::paper::Coupling;
use crate::input::fault::{Allowed, Fault, Faults};
use crate::input::file::{AnglesTable, StudyFile};
use crate::input::study::Angles;

/// Nodes of the rule unless told: T and R to about 1 % (see `angle_rule`).
const USUAL_COUNT: usize = 5;

pub(crate) fn angles(file: &StudyFile, coupling: Coupling, faults: &mut Faults) -> Angles {
    let table = &file.angles;
    let allowed = Allowed::between(-360.0, 360.0, "°");
    faults.number("angles.azimuth_deg", table.azimuth_deg, allowed, "0 is the x direction");
    match (&table.polar_deg, table.count) {
        (Some(list), None) => {
            let remedy = "give angles from the normal; 89 is nearly grazing";
            check_list("angles.polar_deg", list, Allowed::below(0.0, 90.0, "°"), remedy, faults);
            listed(table, list.clone())
        }
        (None, count) => by_rule(file, count.unwrap_or(USUAL_COUNT), coupling, faults),
        (Some(_), Some(_)) => {
            let allowed = "either angles.count or angles.polar_deg";
            faults.push(Fault::new("angles", "both count and polar_deg", allowed, "remove one of them"));
            listed(table, Vec::new())
        }
    }
}

fn listed(table: &AnglesTable, above: Vec<f64>) -> Angles {
    let AnglesTable { azimuth_deg, picture_max_deg, .. } = *table;
    Angles { above, below: Vec::new(), azimuth_deg, rule: None, picture_max_deg }
}

fn by_rule(file: &StudyFile, count: usize, coupling: Coupling, faults: &mut Faults) -> Angles {
    let table = &file.angles;
    let before = faults.0.len();
    surroundings(file, coupling, faults);
    super::whole("angles.count", count, 2..=64, "5 is usual; the normal is always one of them", faults);
    let remedy = "60 is usual; more angles reach nearer to grazing";
    let allowed = Allowed::above(0.0, 89.0, "°");
    faults.number("angles.picture_max_deg", table.picture_max_deg, allowed, remedy);
    if faults.0.len() > before {
        return listed(table, Vec::new());
    }
    match AngleRule::new(count, table.picture_max_deg, coupling) {
        Ok(rule) => Angles {
            above: degrees(&rule.above),
            below: if same_from_below(file, coupling) { Vec::new() } else { degrees(&rule.below) },
            rule: Some(rule),
            ..listed(table, Vec::new())
        },
        Err(error) => {
            let allowed = "angles that the quadrature reaches";
            let found = format!("{} with {count} angles: {error}", table.picture_max_deg);
            faults.push(Fault::new("angles.picture_max_deg", found, allowed, remedy));
            listed(table, Vec::new())
        }
    }
}

/// A layer between two plane walls with vacuum on both sides is statistically the same from above and from below:
/// its solves from above give R̄_b. A relief or a medium below breaks that symmetry.
fn same_from_below(file: &StudyFile, coupling: Coupling) -> bool {
    coupling == Coupling::Gap && file.layer.relief.is_none()
}

/// The picture is of an ink in air, on paper behind a gap of air or in contact with it.
fn surroundings(file: &StudyFile, coupling: Coupling, faults: &mut Faults) {
    let otherwise = "list angles.polar_deg for a study without paper and picture";
    if file.layer.index_above != 1.0 {
        let found = file.layer.index_above;
        faults.push(Fault::new("layer.index_above", found, "1, air above the ink", otherwise));
    }
    let below = file.layer.index_below;
    let (wrong, allowed) = match coupling {
        Coupling::Gap => (below != 1.0, "1, the thin gap to the paper"),
        Coupling::OpticalContact { .. } => {
            (below.is_nan() || below <= 1.0, "greater than 1, the medium of the paper's scatterers")
        }
    };
    if wrong {
        let remedy = format!("choose paper.coupling to suit, or {otherwise}");
        faults.push(Fault::new("layer.index_below", below, allowed, remedy));
    }
}

fn degrees(nodes: &[AngleNode]) -> Vec<f64> {
    nodes.iter().map(|node| node.polar_deg).collect()
}
