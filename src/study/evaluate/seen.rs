//! Evaluates the finished solves: spectra of the layer, its distributions, and the ink on its
//! paper.

mod complete;
mod sums;

pub(super) use complete::complete_cells;

use super::coherent::CoherentLight;
use super::films::{FilmAt, Films, Indices};
use super::films::{fringe_nm, fringing_um};
use super::ink::{InkError, InkInputs, InkOnPaper};
use super::layer::{LayerEnsemble, SpectrumEstimate, Total, film_totals};
use super::levels::GridPart;
use super::prints::Brightened;
use super::samples::SolvedRealisation;
use super::summed::number_wavelengths_nm;
use super::wavelengths::nearest;
use crate::appearance::bdf::{Bdf, BdfError};
use crate::appearance::film::{Profile, ProfileLayer};
use crate::appearance::paper::Substrate;
use crate::appearance::viewing::Viewing;
use crate::input::study::{StackLayer, Study};
use crate::input::variation::LightRule;
use crate::numerics::estimate::Estimate;
use crate::run::Collected;
use complete::CompleteCells;
use num_complex::Complex64;

/// The appearance, as far as the finished solves allow.
#[derive(Debug)]
pub struct Seen {
    /// Numbers of the realisations that enter every result.
    pub realisations: Vec<usize>,
    /// The first realisation of every cell: packings that share one are one sample of the layer.
    pub cells: Vec<usize>,
    /// The solves of every cell, corrected for the grid where two were used.
    pub solved: Vec<SolvedRealisation>,
    /// Errors of R and T due to the grid.
    pub grid: GridPart,
    /// The layer without paper, once a realisation is complete.
    pub layer: Option<LayerSeen>,
    /// The layer's distributions at the exact angles, wavelength by wavelength.
    pub bdfs: Vec<Bdf>,
    /// The ink on its paper, or why there is none.
    pub ink: Result<InkOnPaper, NoInk>,
    /// The layer with tables of indices moved by their errors, once the solves for it are there.
    pub(super) inputs: Option<MovedLayers>,
}

/// The layer of a few packings as the study describes it, and with tables of indices moved by
/// their errors.
#[derive(Debug)]
pub(super) struct MovedLayers {
    few: LayerSeen,
    moved: Vec<LayerSeen>,
}

impl MovedLayers {
    /// Standard error of a total at one of the exact angles due to the tables' errors, against the
    /// study's wavelengths.
    pub fn errors(&self, angle: usize, total: Total) -> Vec<f64> {
        self.errors_of(|layer| layer.spectrum(angle, total).values)
    }

    /// Standard error of what a layer of a stack absorbs, as of totals.
    pub fn absorbed_errors(&self, angle: usize, layer: usize) -> Vec<f64> {
        self.errors_of(|seen| seen.absorbed(angle, layer).values)
    }

    /// Standard errors of any spectrum due to the tables' errors.
    fn errors_of(&self, spectrum: impl Fn(&LayerSeen) -> Vec<f64>) -> Vec<f64> {
        let unmoved = spectrum(&self.few);
        let mut squares = vec![0.0; unmoved.len()];
        for moved in &self.moved {
            let there = spectrum(moved);
            let changes = there.iter().zip(&unmoved).map(|(there, unmoved)| there - unmoved);
            squares.iter_mut().zip(changes).for_each(|(sum, change)| *sum += 0.5 * change * change);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

/// The layer without paper at the study's wavelengths.
#[derive(Debug)]
pub struct LayerSeen {
    /// The fits behind the numbers.
    pub(super) ensemble: LayerEnsemble,
    /// The coherent film at each wavelength.
    films: Vec<FilmAt>,
    pub(super) wavelengths_nm: Vec<f64>,
    /// The coherent film at each wavelength over which weighted numbers are summed.
    sum_films: Vec<FilmAt>,
    coherent: Option<CoherentLight>,
}

/// Why there is no ink on paper.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum NoInk {
    /// The study's angles or wavelengths do not suffice.
    #[error("{0}")]
    Missing(String),
    /// No cell is complete yet.
    #[error("no cell has every wavelength and angle of all packings that share it")]
    Unfinished,
    /// The paper or the angles were refused.
    #[error(transparent)]
    Refused(#[from] InkError),
}

impl LayerSeen {
    /// The coherent film at the study's wavelength nearest to `nm`.
    pub fn film(&self, nm: f64) -> &FilmAt {
        &self.films[nearest(self.wavelengths_nm.iter().copied(), nm)]
    }

    /// A total at one of the exact angles against the study's wavelengths.
    pub fn spectrum(&self, angle: usize, total: Total) -> SpectrumEstimate {
        let ensemble = &self.ensemble;
        let deg = self.ensemble.exact_deg[angle];
        let film: Vec<f64> = self.films.iter().map(|film| film_totals(film, deg)[total as usize]).collect();
        let column = ensemble.column(angle, total);
        SpectrumEstimate {
            values: self.beyond(&film, None, column),
            replicates: (0..ensemble.replicates()).map(|r| self.beyond(&film, Some(r), column)).collect(),
        }
    }

    /// What a layer of a stack absorbs at one of the exact angles, against the study's wavelengths.
    pub fn absorbed(&self, angle: usize, layer: usize) -> SpectrumEstimate {
        let ensemble = &self.ensemble;
        let deg = ensemble.exact_deg[angle];
        let film: Vec<f64> = self.films.iter().map(|film| film.absorbed(deg)[layer]).collect();
        let column = ensemble.absorbed_column(angle, layer);
        SpectrumEstimate {
            values: self.beyond(&film, None, column),
            replicates: (0..ensemble.replicates()).map(|r| self.beyond(&film, Some(r), column)).collect(),
        }
    }

    /// |⟨t⟩|² at one of the exact angles against the study's wavelengths, if all is of one
    /// thickness.
    pub fn coherent_transmittance(&self, angle: usize) -> Option<Vec<Estimate>> {
        let deg = self.ensemble.exact_deg[angle];
        let coherent = self.coherent.as_ref()?;
        Some(coherent.transmittance(angle, &self.films, deg, &self.wavelengths_nm))
    }

    /// Values of the film plus the fitted differences from it.
    fn beyond(&self, film: &[f64], left_out: Option<usize>, column: usize) -> Vec<f64> {
        let LayerEnsemble { basis, .. } = &self.ensemble;
        let fitted = |nm: f64| self.ensemble.fitted(left_out, &basis.weights(nm), column);
        film.iter().zip(&self.wavelengths_nm).map(|(film, &nm)| film + fitted(nm)).collect()
    }
}

impl Study {
    /// Wavelengths at which the spectra that weighted numbers take are known, nm: those of a list,
    /// or of the sums where realisations have their own.
    pub fn number_wavelengths_nm(&self) -> Vec<f64> {
        match self.variation.light {
            LightRule::Listed => self.wavelengths_nm.clone(),
            LightRule::Shifted { .. } => self.sum_wavelengths_nm(),
        }
    }

    /// Wavelengths over which weighted numbers are summed, nm; none without any.
    fn sum_wavelengths_nm(&self) -> Vec<f64> {
        let ends = self.wavelengths_nm.first().zip(self.wavelengths_nm.last());
        let ends = ends.filter(|_| !self.numbers.is_empty());
        let is_stack = !self.stack.is_empty();
        ends.map_or(Vec::new(), |(&from, &to)| {
            let um = fringing_um(&self.thicknesses(), is_stack, to);
            number_wavelengths_nm([from, to], |nm| fringe_nm(nm, um), &self.numbers)
        })
    }
}

impl Seen {
    /// What papers are laid under: the layer and the ink without errors, and no distributions.
    pub fn of_means(self) -> Self {
        Self {
            solved: Vec::new(),
            bdfs: Vec::new(),
            ink: self.ink.map(|ink| ink.of_means()),
            inputs: None,
            ..self
        }
    }

    /// The ink on the paper of another study that differs in its paper alone, the contact excepted.
    ///
    /// # Errors
    /// There is no ink, or the paper is refused.
    pub fn ink_on_paper_of(&self, study: &Study) -> Result<InkOnPaper, String> {
        let ink = self.ink.as_ref().map_err(ToString::to_string)?;
        let laid = ink.on(&substrate(study)).and_then(|ink| in_daylight(study, ink));
        laid.map_err(|error| error.to_string())
    }
}

/// The ink on its paper alone, from the complete realisations.
///
/// # Errors
/// None is complete, or as [`NoInk`] says.
pub fn ink(study: &Study, collected: &Collected) -> Result<InkOnPaper, NoInk> {
    CompleteCells::new(study, collected).appearance().ink
}

/// The ink as its coherent film, with the requested volume fractions in every plane.
///
/// # Errors
/// As [`InkOnPaper::homogeneous`].
pub fn film_alone(study: &Study) -> Result<InkOnPaper, InkError> {
    film_at(study, &study.wavelengths_nm)
}

/// The ink as its coherent film at other wavelengths within the study's range, nm.
pub(super) fn film_at(study: &Study, outputs_nm: &[f64]) -> Result<InkOnPaper, InkError> {
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, requested_profile(study), &indices);
    let substrate = substrate(study);
    let ink = InkOnPaper::homogeneous(&InkInputs { films: &films, substrate: &substrate, outputs_nm })?;
    in_daylight(study, ink)
}

/// Totals of the coherent film alone for light along the normal, at wavelengths within the study's
/// range, nm: in the order of [`Total`].
pub(super) fn film_totals_at(study: &Study, wavelengths_nm: &[f64]) -> Vec<Vec<f64>> {
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, requested_profile(study), &indices);
    wavelengths_nm.iter().map(|&nm| film_totals(&films.at(nm), 0.0).to_vec()).collect()
}

/// The ink under D65, on whose ultraviolet light depends what its paper emits.
fn in_daylight(study: &Study, ink: InkOnPaper) -> Result<InkOnPaper, InkError> {
    match Brightened::new(&study.paper, &study.wavelengths_nm, &Viewing::default(), 0.0) {
        Some(brightened) => Ok(ink.lit_by(&brightened)?),
        None => Ok(ink),
    }
}

/// The requested volume fractions, one slice a layer.
fn requested_profile(study: &Study) -> Profile {
    let shares = study.material_shares();
    let layers_of_materials = study.layers_of_materials();
    let slice = |layer: usize| {
        let materials = shares.iter().zip(&layers_of_materials);
        materials.map(|(&share, &its_layer)| if its_layer == layer { share } else { 0.0 }).collect()
    };
    let count = study.stack.len().max(1);
    Profile { fractions: (0..count).map(slice).collect(), layers: profile_layers(study) }
}

/// The layers of a study's stack, as their film sees them.
fn profile_layers(study: &Study) -> Vec<ProfileLayer> {
    let layer = |layer: &StackLayer| ProfileLayer {
        thickness_um: layer.thickness_um,
        is_uneven: layer.thickness_std_um > 0.0,
    };
    study.stack.iter().map(layer).collect()
}

/// The coherent film of a study's layer.
fn films<'a>(study: &Study, profile: Profile, indices: &'a Indices<'a>) -> Films<'a> {
    Films {
        profile,
        indices,
        thicknesses: study.thicknesses(),
        index_out: study.layer.index_out,
        wave: study.wave,
    }
}

fn substrate(study: &Study) -> Substrate {
    Substrate { albedo: study.paper.albedo.clone(), coupling: study.paper.coupling }
}

/// Evaluates all complete realisations.
///
/// # Errors
/// The records do not match, because of a bug or a damaged store.
pub fn see(study: &Study, collected: &Collected) -> Result<Seen, BdfError> {
    let cells = CompleteCells::new(study, collected);
    let mut seen = cells.appearance();
    if !cells.cells.is_empty() {
        seen.bdfs = cells.distributions()?;
    }
    Ok(seen)
}

/// Indices of the backgrounds, the inclusions, and last of the space beyond a relief.
fn indices(study: &Study, nm: f64) -> (Vec<Complex64>, Vec<Complex64>) {
    let media = study.mean_media(1e-3 * nm);
    let beyond = study.packing.relief.map_or(media.incident, |relief| media.index_of(relief.face.into()));
    (media.backgrounds, media.inclusions.into_iter().chain([beyond]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::check::check;
    use std::path::Path;

    /// The coherent film's last medium. *Planted*: that of the incident side, whichever face is
    /// rough.
    #[test]
    fn beyond_a_relief_there_is_the_medium_of_its_side() {
        for (face, expected) in [("incident", 1.0), ("exit", 1.4)] {
            let text = format!(
                "[layer]\nthickness_um = 1\nbinder.index = 1.5\nindex_out = 1.4\n\
                 relief = {{ depth_um = 0.1, face = '{face}' }}\n[paper]\ncoupling = 'optical_contact'\n\
                 [[pigment]]\ndiameter_nm = 100\nvolume_fraction = 0.05\nindex = 1.6\n"
            );
            let file = toml::from_str(&text).expect("a study file");
            let study = check(&file, Path::new("."), "test").expect("a study");
            assert_eq!(indices(&study, 550.0).1.last(), Some(&Complex64::from(expected)));
        }
    }
}
