//! The plates of a finished stack.

use super::super::level::{KeptPortion, Level, SolvedPortion};
use super::encoding::packed_states;
use super::{
    JointMedium, LIBRARY_FORM, Library, LibraryEye, LibraryLight, LibraryPlate, LibraryPortion, PlatePigment,
    ROUNDING,
};
use crate::appearance::composed::ordinates::Ordinates;
use crate::appearance::fluorescence::{summed_nm, summed_powers};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::study::{Composed, LayerPlates, Study};
use crate::store::identity::{Key, METHOD_VERSION};

/// Illuminants and observers whose weights a library holds.
const ILLUMINANTS: [&str; 6] = ["D65", "D50", "A", "E", "F2", "F11"];
const OBSERVERS: [&str; 2] = ["2", "10"];
/// Why a study is no library study, and what to do.
const NO_STATES: &str = "its layers were not solved between half-spaces of one index, so that no plates of them join any others: \
     write the layers as [[layer]] with [stack.composed] joint_index = 1.5 (or that of their binders), and run it again";

impl Library {
    /// The plates of a finished stack that was solved between half-spaces of one index.
    ///
    /// # Errors
    /// A study of another kind, layers without complete realisations, other media around the stack.
    pub fn of_stack(study: &Study, solved: &[SolvedPortion], program: &str) -> Result<Self, String> {
        let composed = study.composed().ok_or(NO_STATES)?;
        let index = composed.joint_index.ok_or(NO_STATES)?;
        let joint = joint_of(study, composed, index)?;
        let level =
            |halved| Level::new(solved, halved).ok_or("not every layer has a complete realisation yet");
        let portions = [level(false)?.kept(), level(true)?.kept()];
        let mut plates = Vec::new();
        for (layer, kind) in composed.layers.iter().enumerate() {
            let slabs = match kind {
                LayerPlates::Clear => continue,
                LayerPlates::Whole => None,
                LayerPlates::Slabs(um) => Some(*um),
            };
            plates.push(plate_of(study, layer, slabs, &portions, &joint));
        }
        Ok(Self {
            inkwave_library: LIBRARY_FORM,
            method: METHOD_VERSION,
            program: program.to_owned(),
            wave: study.wave,
            wavelengths_nm: study.wavelengths_nm.clone(),
            eyes: eyes(&study.wavelengths_nm),
            lights: lights(&study.wavelengths_nm),
            joint,
            plates,
        })
    }
}

/// The half-spaces of a study's stack.
fn joint_of(study: &Study, composed: &Composed, index: f64) -> Result<JointMedium, String> {
    for outer in [study.layer.index_in, study.layer.index_out] {
        if (outer - 1.0).abs() > ROUNDING && (outer - index).abs() > ROUNDING {
            return Err(format!(
                "stack.index_out: found {outer} around plates of joint_index {index}, which limits their directions; allowed are 1 \
                 and {index}"
            ));
        }
    }
    let polarisations = if study.wave.is_vector() { 2 } else { 1 };
    let directions = composed.directions;
    let ordinates = Ordinates::new(index, &[index], directions);
    Ok(JointMedium { index, directions, polarisations, sines: ordinates.sines, weights: ordinates.weights })
}

fn plate_of(
    study: &Study,
    layer: usize,
    slabs: Option<f64>,
    portions: &[Vec<KeptPortion>; 2],
    joint: &JointMedium,
) -> LibraryPlate {
    let own = study.of_layer(layer);
    let pigments = own.pigments.iter().map(|pigment| PlatePigment {
        name: pigment.name.clone(),
        volume_fraction: pigment.grains.volume_fraction,
        size_nm: [pigment.grains.size.smallest_nm(), pigment.grains.size.largest_nm()],
        index: pigment.material.source.clone(),
    });
    // names are no part of an ink: pigments of two layers have different ones
    let materials: Vec<_> = own.pigments.iter().map(|p| (&p.grains, &p.material, &p.shell)).collect();
    let packing = crate::ink::PackingRequest { seed: 0, thickness_um: 0.0, ..own.packing.clone() };
    let mut packed = Vec::new();
    for (halved, all) in [(false, &portions[0]), (true, &portions[1])] {
        for portion in all.iter().filter(|portion| portion.layer == layer) {
            packed.push(LibraryPortion {
                position: portion.position,
                halved,
                thickness_um: portion.slab_um,
                grid_error: portion.grid_error,
                states: portion.states.iter().map(|states| packed_states(states, joint)).collect(),
            });
        }
    }
    let even = |nm: &f64| own.even_permittivity(1e-3 * nm);
    LibraryPlate {
        name: study.stack[layer].name.clone(),
        ink: Key::of("ink", &(&own.layer.binder, materials, &packing)).short().to_owned(),
        binder: own.layer.binder.source.clone(),
        pigments: pigments.collect(),
        thickness_um: slabs.unwrap_or(study.stack[layer].thickness_um),
        slabs: slabs.is_some(),
        study: study.key().as_str().to_owned(),
        title: study.title.clone(),
        within: study.wavelengths_nm.iter().map(|nm| own.embedding_index(1e-3 * nm)).collect(),
        loss: study.wavelengths_nm.iter().map(|nm| even(nm).im).collect(),
        portions: packed,
    }
}

/// The weights of wavelengths for the usual conditions; none where they carry no colour.
fn eyes(wavelengths_nm: &[f64]) -> Vec<LibraryEye> {
    let seen = visible(wavelengths_nm);
    let mut all = Vec::new();
    for illuminant in ILLUMINANTS {
        for observer in OBSERVERS {
            let viewing = Viewing::new(illuminant, observer, Summation::Plain);
            let eye = viewing.and_then(|viewing| Colorimeter::under(&wavelengths_nm[seen.clone()], &viewing));
            let Ok(eye) = eye else { continue };
            let weight = |w: usize| {
                let only: Vec<f64> = seen.clone().map(|k| f64::from(u8::from(k == w))).collect();
                eye.xyz(&only).unwrap_or_default()
            };
            let weights = (0..wavelengths_nm.len()).map(weight).collect();
            all.push(LibraryEye {
                illuminant: illuminant.to_owned(),
                observer: observer.to_owned(),
                weights,
                emitted: weights_of_emitted(&eye, wavelengths_nm),
            });
        }
    }
    all
}

/// The weights of what a paper emits under a lamp with lines, at all of these wavelengths.
fn weights_of_emitted(eye: &Colorimeter, wavelengths_nm: &[f64]) -> Vec<[f64; 3]> {
    if !eye.viewing().has_lines() {
        return Vec::new();
    }
    let seen = visible(wavelengths_nm);
    let powers = eye.viewing().mean_powers(wavelengths_nm);
    let mut weights = vec![[0.0; 3]; wavelengths_nm.len()];
    weights[seen.clone()].copy_from_slice(eye.emission(&powers[seen]).rows());
    weights
}

/// The powers of the usual illuminants at the wavelengths at which excitation is summed.
pub(super) fn lights(wavelengths_nm: &[f64]) -> Vec<LibraryLight> {
    let (Some(&from_nm), Some(&to_nm)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Vec::new();
    };
    let nm = summed_nm(from_nm, to_nm);
    let light = |illuminant: &str| {
        let viewing = Viewing::new(illuminant, OBSERVERS[0], Summation::Plain).ok()?;
        let powers = summed_powers(&viewing, &nm);
        let seen_powers = if viewing.has_lines() { viewing.mean_powers(wavelengths_nm) } else { Vec::new() };
        Some(LibraryLight { illuminant: illuminant.to_owned(), powers, seen_powers })
    };
    ILLUMINANTS.into_iter().filter_map(light).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weights of emitted light in a file give, with its powers, what a sum over every
    /// nanometre gives; smooth lights need none. *Planted*: powers at the wavelengths.
    #[test]
    fn emitted_light_weighs_as_in_a_sum_over_every_nanometre() {
        let nm: Vec<f64> = (0..36).map(|i| 380.0 + 10.0 * f64::from(i)).collect();
        let every: Vec<f64> = (380..=730).map(f64::from).collect();
        let radiance = |nm: f64| (-0.5 * ((nm - 450.0) / 30.0).powi(2)).exp();
        for eye in eyes(&nm) {
            let lamp = Viewing::new(&eye.illuminant, &eye.observer, Summation::Plain).unwrap();
            assert_eq!(eye.emitted.len(), if lamp.has_lines() { nm.len() } else { 0 }, "{}", eye.illuminant);
            let Some(light) = lights(&nm).into_iter().find(|light| light.illuminant == eye.illuminant) else {
                panic!("no light of {}", eye.illuminant)
            };
            let factors: Vec<f64> = every.iter().map(|&nm| radiance(nm) / lamp.power(nm)).collect();
            let truth = Colorimeter::under(&every, &lamp).unwrap().xyz(&factors).unwrap();
            let parts = nm.iter().zip(&light.seen_powers).map(|(nm, power)| radiance(*nm) / power);
            let mut xyz = [0.0; 3];
            parts.zip(&eye.emitted).for_each(|(part, row)| (0..3).for_each(|c| xyz[c] += part * row[c]));
            // order: cubic interpolation over 10 nm of a band of σ = 30 nm
            let near = xyz.iter().zip(truth).all(|(have, want)| (have / want - 1.0).abs() < 1e-3);
            assert!(near || eye.emitted.is_empty(), "{}: {xyz:?} {truth:?}", eye.illuminant);
        }
    }
}
