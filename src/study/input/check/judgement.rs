//! What the prediction is compared with: conditions, a target colour, a measured spectrum.

use crate::appearance::tristimulus::TABLE_RANGE_NM;
use crate::appearance::viewing::{ColourError, Summation, Viewing};
use crate::input::measured::{MeasuredColour, MeasuredContent, MeasuredReading, MeasuredRequest};
use crate::input::study::Judgement;
use crate::input::{Fault, Faults, StudyFile};
use std::path::Path;

/// Reads what the prediction is compared with; remarks say what was taken where a file leaves
/// something open.
pub fn judgement(
    file: &StudyFile,
    wavelengths_nm: &[f64],
    folder: &Path,
    faults: &mut Faults,
    remarks: &mut Vec<String>,
) -> Judgement {
    let (viewing, mut target_lab) = (viewing(file, faults), target(file, faults));
    if viewing.summation == Summation::E308 && !is_even(wavelengths_nm) {
        let allowed =
            "\"plain\" where the wavelengths are not evenly spaced: ASTM E308 has no weights for them";
        let remedy = "write from_nm, to_nm and step_nm, or leave it out";
        faults.add("colour.summation", "\"e308\"", allowed, remedy);
    }
    let beside = [
        ("patch", file.compare.patch.as_ref().map(|patch| format!("{:?}", patch.to_string()))),
        ("unit", file.compare.unit.map(|unit| format!("{unit:?}").to_lowercase())),
        ("condition", file.compare.condition.map(|condition| condition.name().to_owned())),
    ];
    for (key, found) in beside {
        if let (Some(found), None) = (found, &file.compare.measured) {
            let what = if key == "patch" {
                "a name"
            } else if key == "unit" {
                "a unit"
            } else {
                "a condition"
            };
            let allowed = format!("{what} beside compare.measured");
            faults.add(format!("compare.{key}"), found, allowed, "add compare.measured");
        }
    }
    let mut measured = None;
    match read_measured(file, wavelengths_nm, folder, &viewing) {
        Some(Ok(reading)) => {
            remarks.extend(reading.remarks.iter().map(|remark| format!("compare.measured: {remark}")));
            match reading.measured {
                MeasuredContent::Colour(colour) => target_lab = wanted(colour, &viewing, target_lab, faults),
                MeasuredContent::Spectrum(spectrum) => measured = Some(spectrum),
            }
        }
        Some(Err(error)) => {
            let allowed = "a spectrum of reflectances at 45:0, or L*, a*, b*, as CSV (wavelength_nm,reflectance), CxF3 or CGATS.17";
            let remedy = "correct the file, compare.patch, compare.unit or compare.condition; its path is relative to the study file";
            faults.add("compare.measured", error, allowed, remedy);
        }
        None => {}
    }
    if let Some(measured) = &measured
        && !wavelengths_nm.is_empty()
        && wavelengths_nm.iter().all(|&nm| measured.at(nm).is_none())
    {
        let [low, high] = measured.range_nm();
        let found = format!("{} with values from {low} to {high} nm", measured.source);
        let allowed = "a spectrum with values at one of the wavelengths of [light] or more";
        faults.add("compare.measured", found, allowed, "give its wavelengths in nm");
    }
    Judgement { viewing, target_lab, measured }
}

/// Whether the steps are equal, up to rounding of the written numbers.
fn is_even(wavelengths_nm: &[f64]) -> bool {
    let steps = || wavelengths_nm.windows(2).map(|pair| pair[1] - pair[0]);
    let first = steps().next().unwrap_or(0.0);
    steps().all(|step| (step - first).abs() < 1e-6)
}

fn viewing(file: &StudyFile, faults: &mut Faults) -> Viewing {
    let table = &file.colour;
    let or = |name: &Option<String>, default: &str| name.clone().unwrap_or_else(|| default.to_owned());
    let (illuminant, observer) = (or(&table.illuminant, "D65"), or(&table.observer, "2"));
    Viewing::new(&illuminant, &observer, table.summation).unwrap_or_else(|error| {
        faults.push(viewing_fault(error));
        Viewing::default()
    })
}

/// Reports an unknown illuminant or observer.
fn viewing_fault(error: ColourError) -> Fault {
    let remedy = "write for example illuminant = \"D50\", observer = \"2\"";
    match error {
        ColourError::UnknownName { what, value, allowed } => {
            Fault::new(format!("colour.{what}"), format!("{value:?}"), allowed, remedy)
        }
        other => Fault::new("colour", other, "an illuminant and an observer", remedy),
    }
}

fn target(file: &StudyFile, faults: &mut Faults) -> Option<[f64; 3]> {
    let lab = file.colour.target_lab?;
    if !is_lab(lab) {
        let remedy = "write for example target_lab = [85, -10, 80]";
        faults.add("colour.target_lab", format!("{lab:?}"), LAB, remedy);
    }
    Some(lab)
}

/// Allowed Lab values of a print.
const LAB: &str = "L* from 0 to 150, a* and b* from -300 to 300";

fn is_lab(lab: [f64; 3]) -> bool {
    (0.0..=150.0).contains(&lab[0]) && lab.iter().all(|x| x.abs() <= 300.0)
}

/// The file of measurements, if there is one.
fn read_measured(
    file: &StudyFile,
    wavelengths_nm: &[f64],
    folder: &Path,
    viewing: &Viewing,
) -> Option<Result<MeasuredReading, String>> {
    let path = folder.join(file.compare.measured.as_ref()?);
    let used_nm = match wavelengths_nm {
        [] => TABLE_RANGE_NM,
        [first, .., last] => [*first, *last],
        [only] => [*only; 2],
    };
    let request = MeasuredRequest {
        patch: file.compare.patch.clone(),
        unit: file.compare.unit,
        condition: file.compare.condition,
        used_nm,
        viewing: viewing.clone(),
        ..MeasuredRequest::default()
    };
    Some(MeasuredReading::new(&path, &request))
}

/// The measured colour as a target, if it refers to the study's conditions and is the only one.
fn wanted(
    colour: MeasuredColour,
    viewing: &Viewing,
    target_lab: Option<[f64; 3]>,
    faults: &mut Faults,
) -> Option<[f64; 3]> {
    let allowed = format!("Lab under the conditions of [colour], {}, and stated", viewing.name());
    let remedy = "write these as [colour] illuminant and observer; where the file does not state them, write its values as \
                  colour.target_lab instead of the file";
    let MeasuredColour { lab, viewing: own } = colour;
    let found = match own.map(|own| (lab, own)) {
        Ok((lab, own)) if own == *viewing && is_lab(lab) && target_lab.is_none() => return Some(lab),
        Ok((_, own)) if own != *viewing => format!("Lab under {}", own.name()),
        Ok((lab, _)) if !is_lab(lab) => format!("Lab {lab:?}; allowed are {LAB}"),
        Ok(_) => {
            let remedy = "leave out colour.target_lab or compare.measured";
            let found = "Lab alone, which is a target, beside colour.target_lab";
            faults.add("compare.measured", found, "one target", remedy);
            return target_lab;
        }
        Err(reason) => format!("Lab alone, and {reason}"),
    };
    faults.add("compare.measured", found, allowed, remedy);
    None
}
