//! What the prediction is compared with: conditions, a target colour, a measured spectrum.

use super::Tabulation;
use crate::appearance::tristimulus::TABLE_RANGE_NM;
use crate::appearance::viewing::{ColourError, Summation, Viewing};
use crate::input::file::{ColourTable, CompareTable};
use crate::input::measured::{MeasuredColour, MeasuredContent, MeasuredReading, MeasuredRequest};
use crate::input::study::{Judgement, Paper};
use crate::input::{Fault, Faults, limits};
use crate::material::columns::in_other_unit;

/// `[colour]`, checked.
pub(super) struct PrintTarget {
    pub viewing: Viewing,
    /// L*, a*, b* under these conditions.
    pub lab: Option<[f64; 3]>,
}

impl ColourTable {
    /// The conditions, and the target colour as it is written.
    pub(super) fn checked(&self, wavelengths_nm: &[f64], faults: &mut Faults) -> PrintTarget {
        let illuminant = self.illuminant.as_deref().unwrap_or("D65");
        let observer = self.observer.as_deref().unwrap_or("2");
        let viewing = Viewing::new(illuminant, observer, self.summation).unwrap_or_else(|error| {
            faults.push(viewing_fault(error));
            Viewing::default()
        });
        if let Some(lab) = self.target_lab
            && !is_lab(lab)
        {
            let remedy = "write for example target_lab = [85, -10, 80]";
            faults.add("colour.target_lab", format!("{lab:?}"), lab_in_words(), remedy);
        }
        if viewing.summation == Summation::E308 && !is_even(wavelengths_nm) {
            let allowed =
                "\"plain\" where the wavelengths are not evenly spaced: ASTM E308 has no weights for them";
            let remedy = "write from_nm, to_nm and step_nm, or leave it out";
            faults.add("colour.summation", "\"e308\"", allowed, remedy);
        }
        PrintTarget { viewing, lab: self.target_lab }
    }
}

impl CompareTable {
    /// Reads what the prediction is compared with; remarks say what was taken where a file leaves
    /// something open.
    pub(super) fn checked(
        &self,
        target: PrintTarget,
        paper: &Paper,
        tables: &Tabulation,
        faults: &mut Faults,
        remarks: &mut Vec<String>,
    ) -> Judgement {
        self.check_keys_of_file(faults);
        let mut judgement =
            Judgement { target_lab: target.lab, viewing: target.viewing, ..Judgement::default() };
        let Some(file_name) = &self.measured else { return judgement };
        let request = MeasuredRequest {
            patch: self.patch.clone(),
            unit: self.unit,
            condition: self.condition,
            used_nm: match tables.wavelengths_nm {
                [] => TABLE_RANGE_NM,
                [first, .., last] => [*first, *last],
                [only] => [*only; 2],
            },
            viewing: judgement.viewing.clone(),
            ..MeasuredRequest::default()
        };
        let path = tables.folder.join(file_name);
        // a file that states no condition was measured under the one that the study names
        let unstated = || {
            let request = MeasuredRequest { condition: None, ..request.clone() };
            let condition = self.condition?;
            let reading =
                MeasuredReading::new(&path, &request).ok().filter(|reading| reading.condition.is_none())?;
            let remark =
                format!("the file states no condition, and is taken as measured under {}", condition.name());
            let remarks = reading.remarks.iter().cloned().chain([remark]).collect();
            Some(MeasuredReading { condition: Some(condition), remarks, ..reading })
        };
        let reading = match MeasuredReading::new(&path, &request).or_else(|error| unstated().ok_or(error)) {
            Ok(reading) => reading,
            Err(error) => {
                let allowed = "a spectrum of reflectances at 45:0, or L*, a*, b*, as CSV (wavelength_nm,reflectance), CxF3 or CGATS.17";
                let remedy = "correct the file, compare.patch, compare.unit or compare.condition; its path is relative to the study file";
                faults.add("compare.measured", error, allowed, remedy);
                return judgement;
            }
        };
        remarks.extend(reading.remarks.iter().map(|remark| format!("compare.measured: {remark}")));
        if paper.fluorescence.is_some() {
            judgement.condition = reading.condition;
            let illuminant = judgement.viewing.illuminant();
            remarks.push(match reading.condition {
                Some(condition) => format!(
                    "compare.measured: the print is compared, and shown at 45:0, in the instrument's light of {}",
                    condition.name()
                ),
                None => format!(
                    "compare.measured: the file states no condition, and the paper is brightened: compared in the light of \
                     illuminant {illuminant}; compare.condition = \"M1\" says another (M0, M1, M2)"
                ),
            });
        }
        match reading.measured {
            MeasuredContent::Colour(colour) => {
                judgement.target_lab = measured_target(colour, &judgement, faults);
            }
            MeasuredContent::Spectrum(measured) => {
                let is_outside = |&nm: &f64| measured.at(nm).is_none();
                if !tables.wavelengths_nm.is_empty() && tables.wavelengths_nm.iter().all(is_outside) {
                    let [low, high] = measured.range_nm();
                    let found = format!("{} with values from {low} to {high} nm", measured.source);
                    let allowed = "a spectrum with values at one of the wavelengths of [light] or more";
                    let other = in_other_unit([low, high], request.used_nm);
                    let remedy = other.unwrap_or_else(|| "measure it at wavelengths of [light]".to_owned());
                    faults.add("compare.measured", found, allowed, remedy);
                }
                judgement.measured = Some(measured);
            }
        }
        judgement
    }

    /// Reports keys that say how a file is read where there is none.
    fn check_keys_of_file(&self, faults: &mut Faults) {
        if self.measured.is_some() {
            return;
        }
        let mut refuse = |key: &str, found: String, kind: &str| {
            let allowed = format!("{kind} beside compare.measured");
            faults.add(format!("compare.{key}"), found, allowed, "add compare.measured");
        };
        if let Some(patch) = &self.patch {
            refuse("patch", format!("{:?}", patch.to_string()), "a name");
        }
        if let Some(unit) = self.unit {
            refuse("unit", format!("{unit:?}").to_lowercase(), "a unit");
        }
        if let Some(condition) = self.condition {
            refuse("condition", condition.name().to_owned(), "a condition");
        }
    }
}

/// Whether the steps are equal, up to rounding of the written numbers.
fn is_even(wavelengths_nm: &[f64]) -> bool {
    let steps = || wavelengths_nm.windows(2).map(|pair| pair[1] - pair[0]);
    let first = steps().next().unwrap_or(0.0);
    steps().all(|step| (step - first).abs() < 1e-6)
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

/// Allowed Lab values of a print.
fn lab_in_words() -> String {
    format!("L* {}, a* and b* {}", limits::LIGHTNESS, limits::CHROMA)
}

fn is_lab([lightness, a, b]: [f64; 3]) -> bool {
    limits::LIGHTNESS.holds(lightness) && limits::CHROMA.holds(a) && limits::CHROMA.holds(b)
}

/// The measured colour as a target, if it refers to the study's conditions and is the only one.
fn measured_target(colour: MeasuredColour, judgement: &Judgement, faults: &mut Faults) -> Option<[f64; 3]> {
    let lab = colour.lab;
    let found = match colour.viewing {
        Err(reason) => format!("Lab alone, and {reason}"),
        Ok(viewing) if viewing != judgement.viewing => format!("Lab under {}", viewing.name()),
        Ok(_) if !is_lab(lab) => format!("Lab {lab:?}; allowed are {}", lab_in_words()),
        Ok(_) if judgement.target_lab.is_some() => {
            let remedy = "leave out colour.target_lab or compare.measured";
            let found = "Lab alone, which is a target, beside colour.target_lab";
            faults.add("compare.measured", found, "one target", remedy);
            return judgement.target_lab;
        }
        Ok(_) => return Some(lab),
    };
    let conditions = judgement.viewing.name();
    let allowed = format!("Lab under the conditions of [colour], {conditions}, and stated");
    let remedy = "write these as [colour] illuminant and observer; where the file does not state them, write its values as \
                  colour.target_lab instead of the file";
    faults.add("compare.measured", found, allowed, remedy);
    None
}
