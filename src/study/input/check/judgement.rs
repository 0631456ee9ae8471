//! What the prediction is compared with: conditions, a target colour, a measured spectrum.

use crate::appearance::viewing::{ColourError, Summation, Viewing};
use crate::input::measured_colour::MeasuredColour;
use crate::input::study::Judgement;
use crate::input::{Fault, Faults, MeasuredSpectrum, StudyFile};
use crate::numerics::files;
use std::path::Path;

pub fn judgement(file: &StudyFile, wavelengths_nm: &[f64], folder: &Path, faults: &mut Faults) -> Judgement {
    let (viewing, mut target_lab) = (viewing(file, faults), target(file, faults));
    if viewing.summation == Summation::E308 && !is_even(wavelengths_nm) {
        let allowed =
            "\"plain\" where the wavelengths are not evenly spaced: ASTM E308 has no weights for them";
        let remedy = "write from_nm, to_nm and step_nm, or leave it out";
        faults.add("colour.summation", "\"e308\"", allowed, remedy);
    }
    if let (Some(patch), None) = (&file.compare.patch, &file.compare.measured) {
        let allowed = "a name beside compare.measured";
        faults.add("compare.patch", format!("{patch:?}"), allowed, "add compare.measured");
    }
    if let (Some(unit), None) = (&file.compare.unit, &file.compare.measured) {
        let allowed = "a unit beside compare.measured";
        faults.add("compare.unit", format!("{unit:?}").to_lowercase(), allowed, "add compare.measured");
    }
    let measured = match measured_colour(file, folder) {
        Some(colour) => {
            target_lab = wanted(colour, &viewing, target_lab, faults);
            None
        }
        None => measured(file, folder, faults),
    };
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

/// Remark on a file with several samples.
pub fn first_of_several(file: &StudyFile, judgement: &Judgement) -> Option<String> {
    let measured = judgement.measured.as_ref().filter(|m| m.patches > 1 && file.compare.patch.is_none())?;
    let source = &measured.source;
    Some(format!("compare.measured: using {source}; compare.patch = \"…\" selects another by name"))
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

/// The colour in a measured file without spectra; other errors of the file are reported when its
/// spectrum is read.
fn measured_colour(file: &StudyFile, folder: &Path) -> Option<Result<MeasuredColour, String>> {
    let bytes = files::read_bytes(&folder.join(file.compare.measured.as_ref()?), files::TABLE).ok()?;
    MeasuredColour::parse(&String::from_utf8_lossy(&bytes), file.compare.patch.as_deref()).transpose()
}

/// The measured colour as a target, if it refers to the study's conditions and is the only one.
fn wanted(
    colour: Result<MeasuredColour, String>,
    viewing: &Viewing,
    target_lab: Option<[f64; 3]>,
    faults: &mut Faults,
) -> Option<[f64; 3]> {
    let allowed = format!("Lab under the conditions of [colour], {}, and stated", viewing.name());
    let remedy = "write these as [colour] illuminant and observer; where the file does not state them, write its values as \
                  colour.target_lab instead of the file";
    let found = match colour.and_then(|colour| Ok((colour.lab, colour.viewing(viewing.summation)?))) {
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

fn measured(file: &StudyFile, folder: &Path, faults: &mut Faults) -> Option<MeasuredSpectrum> {
    let path = folder.join(file.compare.measured.as_ref()?);
    let read = MeasuredSpectrum::read(&path, file.compare.patch.as_deref(), file.compare.unit);
    let allowed = "a spectrum as CSV (wavelength_nm,reflectance), CxF3 or CGATS.17 with fields SPEC_nnn, or Lab of the latter";
    let remedy = "correct the file, compare.patch or compare.unit; its path is relative to the study file";
    read.map_err(|error| faults.add("compare.measured", error, allowed, remedy)).ok()
}
