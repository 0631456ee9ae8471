//! The wavelengths and their sampling; studies with Maxwell's equations that cannot be solved are
//! refused before anything is packed.

use super::pigments::packed;
use crate::appearance::tristimulus::{COLOUR_RANGE_NM, Colorimeter, TABLE_RANGE_NM, visible};
use crate::input::file::{LightTable, PigmentTable, SamplingName};
use crate::input::limits::{self, LONGEST_LIST, LONGEST_WAVE_NM};
use crate::input::{Allowed, Fault, Faults, LightRule, Study, keys_in_words};
use crate::material::columns::micrometres;
use crate::numerics::allowed::{brief, shown};
use crate::solve::SolverChoice;
use num_complex::Complex64;

/// Tolerance of wavelengths, nm, for rounding.
const SLACK_NM: f64 = 1e-6;

/// Default wavelengths, nm: from, to, step.
const VISIBLE: [f64; 3] = [400.0, 700.0, 20.0];

/// The light of a study.
pub(super) struct Light {
    /// Vacuum wavelengths, nm; none after an error in a range, so that nothing that depends on them
    /// is checked.
    pub wavelengths_nm: Vec<f64>,
    /// Which of them a realisation uses.
    pub rule: LightRule,
}

impl LightTable {
    /// The wavelengths and their sampling.
    pub(super) fn checked(&self, faults: &mut Faults) -> Light {
        let wavelengths_nm = self.list_or_range_nm(faults);
        let rule = self.rule(&wavelengths_nm, faults);
        Light { wavelengths_nm, rule }
    }

    fn list_or_range_nm(&self, faults: &mut Faults) -> Vec<f64> {
        match (&self.wavelengths_nm, self.from_nm, self.to_nm, self.step_nm) {
            (Some(list), None, None, None) => {
                let remedy = match micrometres(list.iter().copied()) {
                    Some(_) => "these look like µm: write them in nm, times 1000",
                    None => "give vacuum wavelengths in nm, 400 to 700 for the visible",
                };
                check_list("light.wavelengths_nm", list, limits::WAVELENGTH_NM, remedy, faults);
                list.clone()
            }
            (None, Some(from), Some(to), Some(step)) => wavelength_range(from, to, step, faults),
            (None, None, None, step) => {
                wavelength_range(VISIBLE[0], VISIBLE[1], step.unwrap_or(VISIBLE[2]), faults)
            }
            _ => {
                let allowed = "either wavelengths_nm, or all of from_nm, to_nm and step_nm, or step_nm alone from 400 to 700 nm";
                let found = keys_in_words(self, &["wavelengths_nm", "from_nm", "to_nm", "step_nm"]);
                let remedy = "write for example from_nm = 400, to_nm = 700, step_nm = 20";
                faults.add("light", found, allowed, remedy);
                Vec::new()
            }
        }
    }

    /// Wavelengths of a range are shifted between realisations, those of a list are used as they
    /// are.
    fn rule(&self, wavelengths_nm: &[f64], faults: &mut Faults) -> LightRule {
        let last = wavelengths_nm.len().saturating_sub(1);
        let is_shifted = self.wavelengths_nm.is_none() && self.sampling == SamplingName::Shifted && last > 0;
        if let Some(count) = self.per_realisation {
            let remedy = "10 to 16 is usual; it needs a range of wavelengths";
            faults.whole("light.per_realisation", count, limits::PER_REALISATION, remedy);
            if !is_shifted && !wavelengths_nm.is_empty() {
                let allowed = "from_nm, to_nm and step_nm with sampling = \"shifted\"";
                faults.add("light.per_realisation", count, allowed, "give a range, or leave it out");
            }
        }
        if !is_shifted {
            return LightRule::Listed;
        }
        let strata = self.per_realisation.unwrap_or(last).max(1);
        LightRule::Shifted { range_nm: [wavelengths_nm[0], wavelengths_nm[last]], strata }
    }

    /// Remark on a range whose last step does not end at `to_nm`.
    pub(super) fn short_of_end(&self, wavelengths_nm: &[f64]) -> Option<String> {
        let to = self.to_nm.unwrap_or(VISIBLE[1]);
        let step = self.step_nm?;
        let last = wavelengths_nm.last()?;
        let count = wavelengths_nm.len() - 1;
        let last_nm = brief(*last);
        let remark = format!(
            "light.to_nm = {to} is not from_nm + n · step_nm: the last wavelength is {last_nm} nm (n = {count}); \
             choose a step that divides the range to reach {to} nm"
        );
        (*last < to - 1e-6 * step).then_some(remark)
    }
}

/// Remark on spectra that end inside the visible range but still give a colour.
pub(super) fn colour_is_extrapolated(wavelengths_nm: &[f64]) -> Option<String> {
    let [from, to] = COLOUR_RANGE_NM;
    let visible_nm = &wavelengths_nm[visible(wavelengths_nm)];
    let first = *visible_nm.first()?;
    let last = *visible_nm.last()?;
    let is_short = first > from + SLACK_NM || last < to - SLACK_NM;
    let remark = format!(
        "light: the wavelengths reach from {first} to {last} nm, and colours need {from} to {to} nm: the spectra are continued by their \
         values at the ends, and the error bars of colours include what the rest could be"
    );
    (is_short && Colorimeter::new(visible_nm).is_ok()).then_some(remark)
}

/// Remark on wavelengths beyond those of colours.
pub(super) fn colour_takes_a_part(wavelengths_nm: &[f64]) -> Option<String> {
    let [from, to] = TABLE_RANGE_NM;
    let visible_nm = &wavelengths_nm[visible(wavelengths_nm)];
    let remark = format!(
        "light: colours take the wavelengths from {from} to {to} nm, where eyes see; the spectra have all of them"
    );
    (visible_nm.len() < wavelengths_nm.len() && Colorimeter::new(visible_nm).is_ok()).then_some(remark)
}

/// The wavelengths of a range; empty after an error, so that nothing depending on them is checked.
fn wavelength_range(from: f64, to: f64, step: f64, faults: &mut Faults) -> Vec<f64> {
    let before = faults.0.len();
    faults.number("light.step_nm", step, limits::STEP_NM, "20 is usual");
    faults.number("light.from_nm", from, limits::WAVELENGTH_NM, "400 is usual");
    if !(to >= from && to <= LONGEST_WAVE_NM) {
        let allowed = format!("from from_nm = {from} to {LONGEST_WAVE_NM} nm");
        faults.add("light.to_nm", to, allowed, "700 is usual");
    }
    let count = ((to - from) / step + 1e-9).floor();
    if faults.0.len() == before && count >= LONGEST_LIST as f64 {
        let allowed = format!("a step that gives fewer than {LONGEST_LIST} wavelengths");
        faults.add("light.step_nm", shown(step), allowed, "20 is usual");
    }
    // a range with a single wavelength is a mistake
    if faults.0.len() == before && to > from && count == 0.0 {
        let remedy = "20 is usual; for one wavelength write wavelengths_nm = [550]";
        faults.add("light.step_nm", step, format!("at most to_nm - from_nm = {} nm", to - from), remedy);
    }
    if faults.0.len() > before {
        return Vec::new();
    }
    (0..=count as usize).map(|i| from + i as f64 * step).collect()
}

/// Checks that a list has entries, all allowed and increasing.
pub(super) fn check_list(field: &str, list: &[f64], allowed: Allowed, remedy: &str, faults: &mut Faults) {
    let entries = format!("1 to {LONGEST_LIST} entries, each {allowed}");
    if list.is_empty() {
        faults.empty(field, entries, remedy);
    } else if list.len() > LONGEST_LIST {
        faults.add(field, format!("{} entries", list.len()), entries, remedy);
    }
    if let Some(i) = list.iter().position(|&value| !allowed.holds(value)) {
        faults.number(&format!("{field}[{i}]"), list[i], allowed, remedy);
    } else if let Some(i) = (1..list.len()).find(|&i| list[i] <= list[i - 1]) {
        let found = format!("{} after {}", list[i], list[i - 1]);
        faults.add(format!("{field}[{i}]"), found, "rising values", "sort the list, without repeats");
    }
}

/// Reports features that are not available with Maxwell's equations.
pub(super) fn refusals(pigments: &[PigmentTable], study: &Study, faults: &mut Faults) {
    if !study.wave.is_vector() {
        return;
    }
    let scalar = "or take light.wave = \"scalar\"";
    if study.packing.relief.is_some() {
        let allowed =
            "none with Maxwell's equations: the slope of a rough surface has no normal-field tensor yet";
        faults.add("layer.relief", "a rough surface", allowed, format!("remove [layer.relief], {scalar}"));
    }
    if let SolverChoice::ConvergentBorn(_) | SolverChoice::Relaxation(_) = study.solver {
        let allowed = "\"krylov\", \"bicgstab\", \"idr\", \"born\" or \"direct\" with Maxwell's equations: their unknowns are no values at points";
        let found = study.solver.build().name().to_owned();
        faults.add("solver.strategy", found, allowed, format!("leave it out, {scalar}"));
    }
    if study.pigments.is_empty() {
        // metal films are exact
        return;
    }
    let media: Vec<_> = study.wavelengths_nm.iter().map(|&nm| (nm, study.media(1e-3 * nm))).collect();
    for (core, pigment) in packed(pigments).enumerate() {
        let index = media.iter().map(|(nm, media)| (*nm, media.inclusions[core]));
        faults.0.extend(metal(pigment.field("index"), index, scalar));
    }
    for (pigment, checked) in packed(pigments).zip(&study.pigments) {
        let Some(other) = &checked.extraordinary else { continue };
        let index = study.wavelengths_nm.iter().copied().zip(other.index.iter().copied());
        faults.0.extend(metal(pigment.field("index.extraordinary"), index, scalar));
    }
    let binder = media.iter().map(|(nm, media)| (*nm, media.backgrounds[0]));
    faults.0.extend(metal("layer.binder.index".to_owned(), binder, scalar));
}

/// Refuses metals, Re η² ≤ 0: the normal-field tensor may be singular there, and has not been
/// tested.
fn metal(field: String, mut index: impl Iterator<Item = (f64, Complex64)>, scalar: &str) -> Option<Fault> {
    let (nm, eta) = index.find(|(_, eta)| (eta * eta).re <= 0.0)?;
    let found = format!("{} + {}i at {nm} nm, a metal", eta.re, eta.im);
    let allowed =
        "n greater than k with Maxwell's equations: the field across a metal's surface is not resolved";
    Some(Fault::new(field, found, allowed, format!("give another pigment, {scalar}")))
}
