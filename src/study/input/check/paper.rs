//! The paper: its albedo as a number, a list or a table, and its contact with the layer. Directions
//! of the light: 0°, 45° and strata over the hemisphere, as paper and picture need them, or a list.

use super::light::check_list;
use crate::appearance::paper::{Albedo, Coupling, PRINT_DEG};
use crate::input::file::{AnglesTable, CouplingName, StudyFile};
use crate::input::forms::AlbedoWritten;
use crate::input::measured::{MeasuredContent, MeasuredGeometry, MeasuredReading, MeasuredRequest};
use crate::input::study::{Angles, Paper, StudyKind};
use crate::input::{Faults, limits};
use crate::material::columns::micrometres;
use std::path::Path;

const REMEDY: &str = "0 is black, 1 is a perfect white, 0.9 is good paper";

/// Reads the paper; remarks say what was taken where a file leaves something open.
pub fn paper(
    file: &StudyFile,
    wavelengths_nm: &[f64],
    folder: &Path,
    faults: &mut Faults,
    remarks: &mut Vec<String>,
) -> Paper {
    let coupling = match file.paper.coupling {
        CouplingName::Gap => Coupling::Gap,
        CouplingName::OpticalContact => Coupling::OpticalContact { index: file.layer.index_out },
    };
    let (source, albedo) = match &file.paper.albedo {
        AlbedoWritten::Constant(value) => {
            faults.number("paper.albedo", *value, limits::ALBEDO, REMEDY);
            (value.to_string(), Albedo::Constant(*value))
        }
        AlbedoWritten::Rows(rows) => {
            let source = format!("listed at {} wavelengths", rows.len());
            (source, spectral("paper.albedo", rows.clone(), wavelengths_nm, faults))
        }
        AlbedoWritten::Csv { csv, patch, unit, condition } => {
            let request = MeasuredRequest {
                patch: patch.clone(),
                one_must_be_named: true,
                unit: *unit,
                condition: *condition,
                geometries: Vec::new(),
                used_nm: range(wavelengths_nm),
                ..MeasuredRequest::default()
            };
            let path = folder.join(csv);
            let rows = read(&path, &request, faults, remarks);
            // only the file name: the same table is the same paper in any folder
            let name = path.file_name().map_or_else(|| csv.clone(), |name| name.to_string_lossy().into());
            let name = patch.as_ref().map_or(name.clone(), |patch| format!("{name}: {patch}"));
            let albedo = match rows {
                Some(rows) => {
                    // what the study does not ask for is not judged
                    let [from, to] = request.used_nm;
                    let first = rows.iter().rposition(|row| row[0] <= from).unwrap_or(0);
                    let last = rows.iter().position(|row| row[0] >= to).unwrap_or(rows.len() - 1);
                    let used = rows[first.min(last)..=last.max(first)].to_vec();
                    let used = if used.len() < 2 { rows } else { used };
                    spectral("paper.albedo.csv", used, wavelengths_nm, faults)
                }
                // a fault of the file is one already
                None => Albedo::Constant(1.0),
            };
            (name, albedo)
        }
    };
    Paper { source, albedo, coupling }
}

/// A table that covers every wavelength of the study.
fn spectral(field: &str, rows: Vec<[f64; 2]>, wavelengths_nm: &[f64], faults: &mut Faults) -> Albedo {
    let albedo = Albedo::Spectral(rows.clone());
    if let Some(i) = rows.iter().position(|row| !(0.0..=1.0).contains(&row[1])) {
        let found = format!("{} at {} nm", rows[i][1], rows[i][0]);
        faults.add(format!("{field}[{i}]"), found, "albedos from 0 to 1", REMEDY);
    } else if let Some(largest) = micrometres(rows.iter().map(|row| row[0])) {
        let found = format!("wavelengths up to {largest}, which look like µm");
        faults.add(field, found, "wavelengths in nm", "multiply the wavelengths by 1000");
    } else if let Some(error) = wavelengths_nm.iter().find_map(|&nm| albedo.at(nm).err()) {
        let allowed = "two or more rows [wavelength in nm, albedo], rising, that cover [light]";
        let remedy =
            "extend the table: colours need 400 to 700 nm; or, for spectra alone, keep [light] inside it";
        faults.add(field, error, allowed, remedy);
    }
    albedo
}

/// First and last wavelength.
fn range(wavelengths_nm: &[f64]) -> [f64; 2] {
    let first = wavelengths_nm.first().copied().unwrap_or(f64::NEG_INFINITY);
    [first, wavelengths_nm.last().copied().unwrap_or(f64::INFINITY)]
}

/// Reads an albedo from a file of measurements.
fn read(
    path: &Path,
    request: &MeasuredRequest,
    faults: &mut Faults,
    remarks: &mut Vec<String>,
) -> Option<Vec<[f64; 2]>> {
    let own_keys = |text: &str| text.replace("compare.", "paper.albedo.");
    let reading = MeasuredReading::new(path, request).and_then(|reading| match reading.measured {
        MeasuredContent::Spectrum(spectrum) => Ok((spectrum.rows, reading.geometry, reading.remarks)),
        MeasuredContent::Colour(_) => Err(format!("{}: a colour, and no spectrum", path.display())),
    });
    let (rows, geometry, own) = match reading {
        Ok(read) => read,
        Err(error) => {
            let allowed = "a readable table with the columns wavelength_nm and albedo, or a spectrum as CGATS.17 or CxF3";
            let remedy = "correct the file, or name a sample beside it: { csv = \"…\", patch = \"…\" }; its path is relative \
                          to the study file";
            faults.add("paper.albedo.csv", own_keys(&error), allowed, remedy);
            return None;
        }
    };
    remarks.extend(own.iter().map(|remark| format!("paper.albedo: {}", own_keys(remark))));
    if geometry == Some(MeasuredGeometry::Sphere(Some(true))) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        remarks.push(format!(
            "paper.albedo: {name} holds the light that the surface mirrors (specular light included), some 4 %, which an \
             albedo does not"
        ));
    }
    Some(rows)
}

/// Default number of directions: 0°, 45° and three strata.
const USUAL_COUNT: usize = 5;
/// Number of directions that are not strata.
const EXACT: usize = 2;

/// The directions of the light, and what they allow to be computed.
pub struct Directions {
    pub angles: Angles,
    /// The ink on its paper, or the layer alone.
    pub kind: StudyKind,
}

pub fn directions(file: &StudyFile, coupling: Coupling, faults: &mut Faults) -> Directions {
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
fn listed(file: &StudyFile, exact_deg: Vec<f64>, coupling: Coupling) -> Directions {
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

fn alone(table: &AnglesTable, exact_deg: Vec<f64>, reason: String) -> Directions {
    let AnglesTable { azimuth_deg, picture_max_deg, .. } = *table;
    let angles = Angles { exact_deg, strata: 0, exit_strata: 0, azimuth_deg, picture_max_deg };
    Directions { angles, kind: StudyKind::LayerAlone(reason) }
}

fn over_hemisphere(file: &StudyFile, exact_deg: Vec<f64>, strata: usize, coupling: Coupling) -> Directions {
    // A layer between two plane walls with vacuum on both sides is statistically the same from both
    // sides: solves from the incident side give Ā_b. A relief or another medium on the exit side
    // breaks this symmetry.
    let exit_strata = if coupling == Coupling::Gap && file.layer.relief.is_none() { 0 } else { strata };
    let AnglesTable { azimuth_deg, picture_max_deg, .. } = file.angles;
    let angles = Angles { exact_deg, strata, exit_strata, azimuth_deg, picture_max_deg };
    Directions { angles, kind: StudyKind::InkOnPaper }
}

/// The picture shows an ink in air, on paper behind an air gap or in contact with it.
fn surroundings(file: &StudyFile, coupling: Coupling, faults: &mut Faults) {
    let otherwise = match file.layer.composed {
        Some(_) => "give it an allowed value: a composed layer lies on its paper",
        None => "list angles.polar_deg for a study without paper and picture",
    };
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
