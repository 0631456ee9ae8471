//! What a study of Maxwell's equations may hold, refused before anything is packed.

use crate::input::fault::{Fault, Faults};
use crate::input::file::StudyFile;
use crate::input::study::Study;
use crate::material::mixing::MixingRule;
use crate::solve::SolverChoice;
use crate::wave::Media;
use num_complex::Complex64;

/// The limit of vanishing grains of the wave asked for, unless the file says otherwise.
pub(super) fn mixing(file: &StudyFile) -> MixingRule {
    file.layer.mixing.unwrap_or(match file.light.wave.is_vector() {
        true => MixingRule::MaxwellGarnett,
        false => MixingRule::VolumeAverage,
    })
}

/// Faults of what Maxwell's equations are not solved for.
pub(super) fn refusals(file: &StudyFile, study: &Study, faults: &mut Faults) {
    if !study.wave.is_vector() {
        return;
    }
    let scalar = "or take light.wave = \"scalar\"";
    if file.layer.relief.is_some() {
        let allowed =
            "none with Maxwell's equations: the slope of a rough surface has no normal-field tensor yet";
        let remedy = format!("remove [layer.relief], {scalar}");
        faults.push(Fault::new("layer.relief", "a rough surface", allowed, remedy));
    }
    if let SolverChoice::ConvergentBorn(_) | SolverChoice::Relaxation(_) = study.solver {
        let allowed = "\"krylov\", \"bicgstab\", \"born\" or \"direct\" with Maxwell's equations: their unknowns are no values at points";
        let found = study.solver.build().name().to_owned();
        faults.push(Fault::new("solver.strategy", found, allowed, format!("leave it out, {scalar}")));
    }
    if study.pigments.is_empty() {
        // Metal films are exact.
        return;
    }
    let media: Vec<(f64, Media)> =
        study.wavelengths_nm.iter().map(|&nm| (nm, study.media(1e-3 * nm))).collect();
    let packed = (0..file.pigments.len()).filter(|&i| is_packed(file, i)).enumerate();
    for (place, i) in packed {
        let index = media.iter().map(|(nm, media)| (*nm, media.inclusions[place]));
        faults.0.extend(metal(format!("pigment[{i}].index"), index, scalar));
    }
    let binder = media.iter().map(|(nm, media)| (*nm, media.backgrounds[0]));
    faults.0.extend(metal("layer.binder.index".to_owned(), binder, scalar));
}

fn is_packed(file: &StudyFile, pigment: usize) -> bool {
    !super::pigments::is_molecular(&file.pigments[pigment])
}

/// The normal-field tensor may be singular in metals, Re η² ≤ 0, and has not been tested there.
fn metal(field: String, mut index: impl Iterator<Item = (f64, Complex64)>, scalar: &str) -> Option<Fault> {
    let (nm, eta) = index.find(|(_, eta)| (eta * eta).re <= 0.0)?;
    let found = format!("{} + {}i at {nm} nm, a metal", eta.re, eta.im);
    let allowed =
        "n greater than k with Maxwell's equations: the field across a metal's surface is not resolved";
    Some(Fault::new(field, found, allowed, format!("give another pigment, {scalar}")))
}
