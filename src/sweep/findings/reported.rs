//! Summary of a sweep's report.

use super::conclusions::Judged;
use super::outcome::{Outcome, lab};
use super::target::Nearest;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::sweep::definition::load::Sweep;

/// Summary of a report.
#[derive(Clone, Debug)]
pub struct Reported {
    /// The outcome of each variant.
    pub outcomes: Vec<Outcome>,
    /// The conclusions with their verdicts.
    pub conclusions: Vec<Judged>,
    /// The variants nearest to the target colour; `None` without a target.
    pub nearest: Option<Nearest>,
}

impl Reported {
    /// Number of variants in which every solve is finished.
    pub fn complete(&self) -> usize {
        self.outcomes.iter().filter(|o| o.is_complete()).count()
    }

    /// Number of failures, over all variants.
    pub fn failures(&self) -> usize {
        self.outcomes.iter().map(|o| o.failures).sum()
    }
}

/// The numbers of a variant for a page: ΔE₀₀ to a reference of another ink is left out, unless the
/// file names the reference.
pub(crate) fn shown(sweep: &Sweep, number: usize, outcomes: &[Outcome]) -> Option<[Estimate; 6]> {
    let outline = &sweep.outline;
    let mut numbers = numbers(&outcomes[number], &outcomes[outline.reference])?;
    let [own, other] = [number, outline.reference].map(|v| Some(inks(&sweep.variants.get(v)?.study)));
    if !outline.reference_asked && own != other {
        numbers[5] = Estimate::unknown_error(f64::NAN);
    }
    Some(numbers)
}

/// Names of a study's pigments.
pub(super) fn inks(study: &Study) -> Vec<&str> {
    let grains = study.pigments.iter().map(|p| p.name.as_str());
    let mut names: Vec<&str> = grains.chain(study.dissolved.iter().map(|d| d.name.as_str())).collect();
    names.sort_unstable();
    names
}

/// L*, a*, b*, C*, h and ΔE₀₀ to the reference; `None` without a colour.
pub(crate) fn numbers(outcome: &Outcome, reference: &Outcome) -> Option<[Estimate; 6]> {
    let colour = outcome.colour.as_ref()?;
    let difference = match outcome.difference(reference) {
        // the difference to itself is zero, without an error
        Some(_) if outcome.name == reference.name => Estimate::unknown_error(0.0),
        difference => difference.map_or(Estimate::unknown_error(f64::NAN), |d| d.estimate),
    };
    Some([lab(colour, 0), lab(colour, 1), lab(colour, 2), colour.chroma(), colour.hue_deg(), difference])
}
