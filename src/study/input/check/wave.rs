//! Refuses studies with Maxwell's equations that cannot be solved, before anything is packed.

use super::pigments::packed;
use crate::input::fault::{Fault, Faults};
use crate::input::file::StudyFile;
use crate::input::study::Study;
use crate::material::mixing::MixingRule;
use crate::solve::SolverChoice;
use crate::wave::Media;
use num_complex::Complex64;

/// The mixing rule: that of vanishing grains for the chosen wave, unless the file sets another.
pub(super) fn mixing(file: &StudyFile) -> MixingRule {
    file.layer.mixing.unwrap_or(match file.light.wave.is_vector() {
        true => MixingRule::MaxwellGarnett,
        false => MixingRule::VolumeAverage,
    })
}

/// Reports features that are not available with Maxwell's equations.
pub(super) fn refusals(file: &StudyFile, study: &Study, faults: &mut Faults) {
    if !study.wave.is_vector() {
        return;
    }
    let scalar = "or take light.wave = \"scalar\"";
    if file.layer.relief.is_some() {
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
    let media: Vec<(f64, Media)> =
        study.wavelengths_nm.iter().map(|&nm| (nm, study.media(1e-3 * nm))).collect();
    for (place, (i, _)) in packed(file).enumerate() {
        let index = media.iter().map(|(nm, media)| (*nm, media.inclusions[place]));
        faults.0.extend(metal(format!("pigment[{i}].index"), index, scalar));
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
