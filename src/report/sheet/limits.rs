//! What the page's list of limits depends on beside the manifest.

use crate::evaluate::manifest::Manifest;
use crate::evaluate::summary::aimed_at;
use crate::input::study::Study;
use crate::input::variation::LightRule;
use crate::report::scalar_error;
use minijinja::{Value, context};

pub(crate) fn limits(study: &Study, manifest: &Manifest<&Study>) -> Value {
    context! {
        viewing => study.judgement.viewing.name(),
        scalar_error => scalar_error::line(study),
        synthetic => study.pigments.iter().any(|p| p.material.source.contains("synthetic")),
        too_few => few_wavelengths(study, manifest),
        widest => missed_target(study, manifest),
    }
}

/// Wavelengths that a colour needs.
const ENOUGH_WAVELENGTHS: usize = 8;

/// The number of wavelengths of a colour that has too few: those solved over all realisations where
/// each has its own.
fn few_wavelengths(study: &Study, manifest: &Manifest<&Study>) -> Option<usize> {
    let solved = match study.variation.light {
        LightRule::Shifted { strata, .. } => strata * manifest.realisations.finished,
        LightRule::Listed => study
            .wavelengths_nm
            .iter()
            .filter(|nm| manifest.spectra.iter().any(|row| row.wavelength_nm == **nm))
            .count(),
    };
    (solved < ENOUGH_WAVELENGTHS && study.angles.strata > 0).then_some(solved)
}

/// The widest interval where it is beyond `run.target_delta_e`.
fn missed_target(study: &Study, manifest: &Manifest<&Study>) -> Option<f64> {
    let target = study.target_delta_e?;
    let bars = aimed_at(study, manifest).filter_map(|note| note.delta_e_2000_95);
    bars.reduce(f64::max).filter(|&bar| bar > target)
}
