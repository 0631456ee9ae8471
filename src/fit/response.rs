//! Reflectances of all drawdowns with their derivatives with respect to n, κ and the thickness.

use super::file::FitGeometry;
use super::load::{Drawdown, FitTask};
use crate::appearance::paper::{MirroredSky, PRINT_DEG, Substrate};
use crate::evaluate::ink::{InkError, InkOnPaper};
use crate::evaluate::layer::SpectrumEstimate;
use crate::evaluate::seen::{NoInk, film_alone, ink};
use crate::input::study::Study;
use crate::run::tangents::Linearised;
use num_complex::Complex64;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::f64::consts::PI;

/// Angle of the instrument with a sphere, degrees.
const SPHERE_DEG: f64 = 8.0;
/// Step of the differences of the evaluation, which is smooth.
const STEP: f64 = 1e-4;

/// Values of every drawdown at every wavelength.
pub type Spectra = Vec<Vec<f64>>;

/// What is computed of all drawdowns at one index.
#[derive(Clone, Debug)]
pub struct Response {
    /// Reflectance factors: drawdown → wavelength.
    pub values: Spectra,
    /// Derivatives with respect to n and κ at the same wavelength, and to the logarithm of the
    /// thickness.
    pub slopes: [Spectra; 3],
    /// Values of every ensemble that lacks one realisation: drawdown → realisation → wavelength.
    pub replicates: Vec<Vec<Vec<f64>>>,
    /// Their derivatives with respect to n.
    pub slope_replicates: Vec<Vec<Vec<f64>>>,
}

/// Where the numbers come from: the coherent films, or solves of every layer.
#[derive(Clone, Copy)]
pub enum Origin<'a> {
    /// The coherent film of the effective medium.
    Film,
    /// Solves with their derivatives, one set for each layer.
    Solved(&'a [Linearised]),
}

impl Origin<'_> {
    /// Every drawdown's values with the pigment's index, changed by `step` in n and κ and by a
    /// factor e^`log` of the thickness.
    ///
    /// # Errors
    /// The layer on its card gives no spectrum.
    pub fn spectra(
        self,
        task: &FitTask,
        drawdowns: &[Drawdown],
        index: &[[f64; 2]],
        (step, log): ([f64; 2], f64),
    ) -> Result<Vec<SpectrumEstimate>, NoInk> {
        let eta = index.iter().map(|[n, k]| Complex64::new(n + step[0], k + step[1]));
        let eta: Vec<Complex64> = eta.collect();
        let mut inks = BTreeMap::new();
        let mut spectra = Vec::new();
        for drawdown in drawdowns {
            let ink = match inks.entry(drawdown.coat) {
                Entry::Occupied(ink) => ink.into_mut(),
                Entry::Vacant(place) => {
                    let study = thicker(&task.coats[drawdown.coat], task.pigment, log.exp());
                    place.insert(self.ink(drawdown.coat, &study.with_index(task.pigment, &eta), step)?)
                }
            };
            spectra.push(spectrum(ink, drawdown)?);
        }
        Ok(spectra)
    }

    /// The ink of one layer.
    fn ink(self, coat: usize, study: &Study, step: [f64; 2]) -> Result<InkOnPaper, NoInk> {
        match self {
            Self::Film => Ok(film_alone(study)?),
            Self::Solved(all) => ink(study, &all[coat].collected(step)),
        }
    }

    /// Values with derivatives; `log` is the logarithm of a factor on the thicknesses.
    ///
    /// # Errors
    /// The layer on its card gives no spectrum.
    pub fn response(
        self,
        task: &FitTask,
        drawdowns: &[Drawdown],
        index: &[[f64; 2]],
        log: f64,
    ) -> Result<Response, NoInk> {
        let here = self.spectra(task, drawdowns, index, ([0.0; 2], log))?;
        let moved =
            |step: [f64; 2], further: f64| self.spectra(task, drawdowns, index, (step, log + further));
        let [along_n, along_kappa] = [moved([STEP, 0.0], 0.0)?, moved([0.0, STEP], 0.0)?];
        let thicker = moved([0.0; 2], STEP)?;
        let slope = |moved: &[SpectrumEstimate]| -> Spectra {
            here.iter().zip(moved).map(|(a, b)| differences(&a.values, &b.values)).collect()
        };
        Ok(Response {
            slopes: [slope(&along_n), slope(&along_kappa), slope(&thicker)],
            slope_replicates: slopes_of_replicates(&here, &along_n),
            replicates: here.iter().map(|spectrum| spectrum.replicates.clone()).collect(),
            values: here.into_iter().map(|spectrum| spectrum.values).collect(),
        })
    }
}

fn differences(here: &[f64], moved: &[f64]) -> Vec<f64> {
    here.iter().zip(moved).map(|(a, b)| (b - a) / STEP).collect()
}

fn slopes_of_replicates(here: &[SpectrumEstimate], moved: &[SpectrumEstimate]) -> Vec<Vec<Vec<f64>>> {
    let of = |(here, moved): (&SpectrumEstimate, &SpectrumEstimate)| {
        let cells = here.replicates.iter().zip(&moved.replicates);
        cells.map(|(here, moved)| differences(here, moved)).collect()
    };
    here.iter().zip(moved).map(of).collect()
}

/// A study whose layer with this pigment has `factor` times its thickness; its packings stay those
/// of the study.
pub(super) fn thicker(study: &Study, pigment: usize, factor: f64) -> Study {
    let mut thicker = study.clone();
    thicker.variation.thickness_std_um *= factor;
    let layer = study.layer_of_pigment(pigment);
    let Some(layer) = thicker.stack.get_mut(layer) else {
        thicker.layer.thickness_um *= factor;
        return thicker;
    };
    let more_um = (factor - 1.0) * layer.thickness_um;
    layer.thickness_um += more_um;
    // what cells have less than the stack is to be this layer's: the uneven one's
    layer.thickness_std_um = (layer.thickness_std_um * factor).max(f64::MIN_POSITIVE);
    thicker.layer.thickness_um += more_um;
    thicker
}

/// What an instrument reads of a layer on its card.
///
/// # Errors
/// The card and the layer trap all light.
pub fn spectrum(ink: &InkOnPaper, drawdown: &Drawdown) -> Result<SpectrumEstimate, InkError> {
    let paper = &drawdown.study.paper;
    let ink = ink.on(&Substrate { albedo: paper.albedo.clone(), coupling: paper.coupling })?;
    let normal = ink.at(0.0)?;
    let mut smooth = match drawdown.geometry {
        FitGeometry::UniformSky => ink.spectrum(|layer| layer.natural_light(&normal, MirroredSky::Included)),
        FitGeometry::Sphere | FitGeometry::SphereExcluded => {
            let view = ink.at(SPHERE_DEG)?;
            let is_included = drawdown.geometry.includes_mirrored();
            ink.spectrum(|layer| layer.albedo(&view) - if is_included { 0.0 } else { layer.mirrored(&view) })
        }
        FitGeometry::Transmitted => ink.spectrum(|layer| layer.transmittance(&normal)),
        FitGeometry::LitAt45 => {
            let lit = ink.at(PRINT_DEG)?;
            ink.spectrum(|layer| PI * layer.brdf(&lit, &normal))
        }
    };
    for spectrum in std::iter::once(&mut smooth.values).chain(&mut smooth.replicates) {
        for (wave, value) in spectrum.iter_mut().enumerate() {
            *value = drawdown.face.seen(wave, *value, drawdown.geometry);
        }
    }
    Ok(smooth)
}
