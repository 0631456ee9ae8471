//! Directions of the light: 0°, 45° and strata over the hemisphere, as paper and picture need them,
//! or a list.

use super::light::check_list;
use crate::appearance::paper::{Coupling, PRINT_DEG};
use crate::input::fault::Faults;
use crate::input::file::{AnglesTable, StudyFile};
use crate::input::limits;
use crate::input::study::Angles;

/// Default number of directions: 0°, 45° and three strata.
const USUAL_COUNT: usize = 5;
/// Number of directions that are not strata.
const EXACT: usize = 2;

pub fn angles(file: &StudyFile, coupling: Coupling, faults: &mut Faults) -> Angles {
    let table = &file.angles;
    faults.number("angles.azimuth_deg", table.azimuth_deg, limits::AZIMUTH_DEG, "0 is the x direction");
    let remedy = "60 is usual";
    faults.number("angles.picture_max_deg", table.picture_max_deg, limits::PICTURE_MAX_DEG, remedy);
    match (&table.polar_deg, table.count) {
        (Some(list), None) => {
            let remedy = "give angles from the normal; 89 is nearly grazing";
            check_list("angles.polar_deg", list, limits::POLAR_DEG, remedy, faults);
            listed(file, list.clone(), coupling)
        }
        (None, count) => {
            let count = count.unwrap_or(USUAL_COUNT);
            surroundings(file, coupling, faults);
            let remedy = "5 is usual; 0° and 45° are always among them";
            faults.whole("angles.count", count, limits::DIRECTIONS, remedy);
            over_hemisphere(file, vec![0.0, PRINT_DEG], count.saturating_sub(EXACT), coupling)
        }
        (Some(_), Some(_)) => {
            let allowed = "either angles.count or angles.polar_deg";
            faults.add("angles", "both count and polar_deg", allowed, "remove one of them");
            alone(table, Vec::new(), String::new())
        }
    }
}

/// Listed angles allow paper and colour if they include 0° and 45° and the surroundings permit it.
fn listed(file: &StudyFile, exact_deg: Vec<f64>, coupling: Coupling) -> Angles {
    let table = &file.angles;
    let absent = |deg: &f64| !exact_deg.iter().any(|have| (have - deg).abs() < 1e-9);
    let missing = [0.0, PRINT_DEG].into_iter().filter(absent).map(|deg: f64| deg.to_string());
    let missing: Vec<String> = missing.collect();
    if !missing.is_empty() {
        let reason = format!(
            "angles.polar_deg does not list {}: paper and colour need 0 and 45, or angles.count instead of a list",
            missing.join(" and ")
        );
        return alone(table, exact_deg, reason);
    }
    let mut unsuited = Faults::default();
    surroundings(file, coupling, &mut unsuited);
    match unsuited.0.first() {
        Some(fault) => alone(table, exact_deg, format!("no paper and colour: {fault}")),
        None => over_hemisphere(file, exact_deg, USUAL_COUNT - EXACT, coupling),
    }
}

fn alone(table: &AnglesTable, exact_deg: Vec<f64>, reason: String) -> Angles {
    let AnglesTable { azimuth_deg, picture_max_deg, .. } = *table;
    Angles { exact_deg, strata: 0, exit_strata: 0, azimuth_deg, picture_max_deg, no_paper: Some(reason) }
}

fn over_hemisphere(file: &StudyFile, exact_deg: Vec<f64>, strata: usize, coupling: Coupling) -> Angles {
    // A layer between two plane walls with vacuum on both sides is statistically the same from both
    // sides: solves from the incident side give Ā_b. A relief or another medium on the exit side
    // breaks this symmetry.
    let exit_strata = if coupling == Coupling::Gap && file.layer.relief.is_none() { 0 } else { strata };
    Angles { strata, exit_strata, no_paper: None, ..alone(&file.angles, exact_deg, String::new()) }
}

/// The picture shows an ink in air, on paper behind an air gap or in contact with it.
fn surroundings(file: &StudyFile, coupling: Coupling, faults: &mut Faults) {
    let otherwise = "list angles.polar_deg for a study without paper and picture";
    if file.layer.index_in != 1.0 {
        faults.add("layer.index_in", file.layer.index_in, "1, air above the ink", otherwise);
    }
    let below = file.layer.index_out;
    let (wrong, allowed) = match coupling {
        Coupling::Gap => (below != 1.0, "1, the thin gap to the paper"),
        Coupling::OpticalContact { .. } => {
            (below.is_nan() || below <= 1.0, "greater than 1, the medium of the paper's scatterers")
        }
    };
    if wrong {
        let remedy = format!("choose paper.coupling to suit, or {otherwise}");
        faults.add("layer.index_out", below, allowed, remedy);
    }
}
