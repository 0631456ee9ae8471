//! What the prediction is held against: conditions, a target, a measured spectrum.

use crate::appearance::error::ColourError;
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::fault::{Fault, Faults};
use crate::input::file::StudyFile;
use crate::input::measured::{MeasuredError, MeasuredSpectrum};
use crate::input::study::Judgement;
use std::path::Path;

pub fn judgement(file: &StudyFile, wavelengths_nm: &[f64], folder: &Path, faults: &mut Faults) -> Judgement {
    let (viewing, target_lab) = (viewing(file, faults), target(file, faults));
    if viewing.summation == Summation::E308 && !is_even(wavelengths_nm) {
        let allowed =
            "\"plain\" where the wavelengths are not evenly spaced: ASTM E308 has no weights for them";
        let remedy = "write from_nm, to_nm and step_nm, or leave it out";
        faults.push(Fault::new("colour.summation", "\"e308\"", allowed, remedy));
    }
    if let (Some(patch), None) = (&file.compare.patch, &file.compare.measured) {
        let allowed = "a name beside compare.measured";
        faults.push(Fault::new("compare.patch", format!("{patch:?}"), allowed, "add compare.measured"));
    }
    let measured = measured(file, folder, faults);
    if let Some(measured) = &measured {
        faults.0.extend(elsewhere(measured, wavelengths_nm));
    }
    Judgement { viewing, target_lab, measured }
}

/// What a file with several samples leaves open.
pub fn first_of_several(file: &StudyFile, judgement: &Judgement) -> Option<String> {
    let measured = judgement.measured.as_ref().filter(|m| m.patches > 1 && file.compare.patch.is_none())?;
    Some(format!(
        "compare.measured: taken is {}; compare.patch = \"…\" takes another by its name",
        measured.source
    ))
}

/// Equal steps, to the rounding of written numbers.
fn is_even(wavelengths_nm: &[f64]) -> bool {
    let steps = || wavelengths_nm.windows(2).map(|pair| pair[1] - pair[0]);
    let first = steps().next().unwrap_or(0.0);
    steps().all(|step| (step - first).abs() < 1e-6)
}

/// A spectrum that answers at none of the study's wavelengths.
fn elsewhere(measured: &MeasuredSpectrum, wavelengths_nm: &[f64]) -> Option<Fault> {
    let [low, high] = measured.range_nm();
    let none = !wavelengths_nm.is_empty() && wavelengths_nm.iter().all(|&nm| measured.at(nm).is_none());
    let found = format!("{} with values from {low} to {high} nm", measured.source);
    let allowed = "a spectrum with values at one of the wavelengths of [light] or more";
    none.then(|| Fault::new("compare.measured", found, allowed, "give its wavelengths in nm"))
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

/// A light or an observer that is not known.
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
    if !((0.0..=150.0).contains(&lab[0]) && lab.iter().all(|x| x.abs() <= 300.0)) {
        let allowed = "L* from 0 to 150, a* and b* from -300 to 300";
        let remedy = "write for example target_lab = [85, -10, 80]";
        faults.push(Fault::new("colour.target_lab", format!("{lab:?}"), allowed, remedy));
    }
    Some(lab)
}

fn measured(file: &StudyFile, folder: &Path, faults: &mut Faults) -> Option<MeasuredSpectrum> {
    let path = folder.join(file.compare.measured.as_ref()?);
    let fault = |error: MeasuredError| {
        let allowed = "a spectrum as CSV (wavelength_nm,reflectance), CxF3 or CGATS.17 with fields SPEC_nnn";
        let remedy = "correct the file or compare.patch; its path is relative to the study file";
        faults.push(Fault::new("compare.measured", error, allowed, remedy));
    };
    MeasuredSpectrum::read(&path, file.compare.patch.as_deref()).map_err(fault).ok()
}
