//! What a study of Maxwell's equations may hold, refused before anything is packed.

use crate::input::fault::{Fault, Faults};
use crate::input::file::StudyFile;
use crate::input::study::{Material, Study};
use crate::material::spectra::MixingRule;
use crate::solve::SolverChoice;
use crate::wave::Scheme;

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
    if let Some(scheme) = file.resolution.scheme.filter(|scheme| *scheme != Scheme::Quadratic) {
        let allowed = "nothing, or \"quadratic\": Maxwell's equations have two planes a cell";
        let found = format!("{scheme:?}").to_lowercase();
        faults.push(Fault::new("resolution.scheme", found, allowed, format!("leave it out, {scalar}")));
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
    let grains = (0..file.pigments.len()).filter(|&i| is_packed(file, i)).zip(&study.pigments);
    let grains = grains.map(|(i, pigment)| (format!("pigment[{i}].index"), &pigment.material));
    for (field, material) in grains.chain([("layer.binder.index".to_owned(), &study.layer.binder)]) {
        faults.0.extend(metal(field, material, &study.wavelengths_nm, scalar));
    }
}

fn is_packed(file: &StudyFile, pigment: usize) -> bool {
    !super::pigments::is_molecular(&file.pigments[pigment])
}

/// The normal-field tensor may be singular in metals, and has not been tested there.
fn metal(field: String, material: &Material, wavelengths_nm: &[f64], scalar: &str) -> Option<Fault> {
    let (eta, nm) = material.index.iter().zip(wavelengths_nm).find(|(eta, _)| eta.im >= eta.re)?;
    let found = format!("{} + {}i at {nm} nm, a metal", eta.re, eta.im);
    let allowed =
        "n greater than k with Maxwell's equations: the field across a metal's surface is not resolved";
    Some(Fault::new(field, found, allowed, format!("give another pigment, {scalar}")))
}
