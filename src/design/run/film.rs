//! What the coherent film of a recipe answers: the ground on which the surfaces of layers that are
//! solved as a whole lie.

use super::{DesignError, study_at};
use crate::design::recipe::DesignTask;
use crate::design::surface::{Spectra3, spectra};
use crate::evaluate::numbers::{AskedNumber, film_spectra};
use crate::evaluate::seen::film_alone;
use crate::input::file::SeenLight;

/// What the coherent film of a recipe answers: the spectra behind its colours, and the sums behind
/// the numbers that are wanted.
pub(super) struct FilmResponse<'a> {
    task: &'a DesignTask,
    asked: Vec<AskedNumber<'a>>,
    /// Wavelengths of the spectra that numbers take, nm.
    wavelengths_nm: Vec<f64>,
}

impl<'a> FilmResponse<'a> {
    /// Of recipes with the wavelengths of this one.
    pub fn new(task: &'a DesignTask, places: &[f64]) -> Result<Self, DesignError> {
        let wanted: Vec<_> = task.numbers.iter().map(|wish| &wish.wanted).collect();
        let wavelengths_nm =
            if wanted.is_empty() { Vec::new() } else { study_at(task, places)?.number_wavelengths_nm() };
        let asked =
            wanted.into_iter().filter_map(|wanted| AskedNumber::new(wanted, &wavelengths_nm)).collect();
        Ok(Self { task, asked, wavelengths_nm })
    }

    /// Spectra of a recipe's film, and the sums of its numbers.
    pub fn at(&self, places: &[f64]) -> Result<Spectra3, DesignError> {
        let study = study_at(self.task, places)?;
        let mut all = spectra(&study, &film_alone(&study)?)?;
        for asked in &self.asked {
            let lights: Vec<SeenLight> = asked.wanted.spectra().collect();
            let spectra = film_spectra(&study, &lights, &self.wavelengths_nm)?;
            all.extend(asked.sums_of(&spectra.iter().map(Vec::as_slice).collect::<Vec<_>>()));
        }
        Ok(all)
    }

    /// The numbers of such an answer, whose sums come last.
    pub fn numbers(&self, spectra: &[f64]) -> Vec<f64> {
        let counts: Vec<usize> = self.asked.iter().map(AskedNumber::count).collect();
        let mut sums = &spectra[spectra.len() - counts.iter().sum::<usize>()..];
        let mut numbers = Vec::new();
        for (asked, count) in self.asked.iter().zip(counts) {
            let (own, rest) = sums.split_at(count);
            numbers.push(asked.number(own));
            sums = rest;
        }
        numbers
    }
}
