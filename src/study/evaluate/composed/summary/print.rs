//! A composed layer on its paper at 45:0, as designs judge it: its colour under the study's own
//! light and observer with all bars, and its spectra at any thickness and on any paper.

use super::rows::ThicknessRows;
use super::{levels_of, moved_levels, of_stack};
use crate::appearance::colour::Colour;
use crate::evaluate::composed::errors::{JudgedNumbers, MovedLevels, with_errors};
use crate::evaluate::composed::level::{Change, Level, SolvedPortion};
use crate::evaluate::composed::numbers::LayerTask;
use crate::evaluate::ink_maker::is_in_daylight;
use crate::evaluate::manifest::composed::{ComposedRow, independent};
use crate::evaluate::numbers::AskedNumber;
use crate::evaluate::published::{NumberNote, Withheld};
use crate::evaluate::quantities::LayerNumbers;
use crate::input::study::{Study, WantedNumber};
use crate::numerics::estimate::Estimate;

/// A composed layer of the last thickness of its study on its paper.
#[derive(Debug)]
pub struct ComposedPrint {
    /// Lit at 45° and seen along the normal, with the bars of its L*, a*, b* as if they were
    /// independent; none of a colour that cannot be.
    pub colour: Option<Colour>,
    /// Y over black divided by Y over white, at 45:0.
    pub contrast_ratio: Option<Estimate>,
    /// Weighted numbers that the study asks for.
    pub numbers: Vec<NumberNote>,
    /// What cannot be, with the reason.
    pub withheld: Vec<Withheld>,
    /// Complete realisations of the slab that has fewest of them.
    pub realisations: usize,
}

impl ComposedPrint {
    /// From the solved portions of a study.
    ///
    /// # Errors
    /// A portion without complete realisations, paper without an albedo.
    pub fn new(study: &Study, solved: &[SolvedPortion]) -> Result<Self, String> {
        let [whole, half] = levels_of(study, solved)?;
        let moved = moved_levels(study, solved);
        let own = judged(study, true, [&whole, &half], moved.as_ref())?;
        let colours = own.colours.first();
        let colour = colours.and_then(|colours| colour(study, &own, independent(colours.lit_at_45?)));
        let contrast_ratio = colours.and_then(|colours| Some(colours.contrast_ratio?.estimate()));
        let numbers = match is_lit_apart(study) {
            true => judged(study, false, [&whole, &half], moved.as_ref())?.weighted,
            false => own.weighted,
        };
        Ok(Self {
            colour,
            contrast_ratio,
            numbers,
            withheld: own.withheld,
            realisations: solved.iter().map(|(_, c)| c.complete().count()).min().unwrap_or(0),
        })
    }
}

/// Whether the paper fluoresces, so that colours under the study's own light take other factors
/// than weighted numbers, which are those of D65.
fn is_lit_apart(study: &Study) -> bool {
    study.paper.fluorescence.is_some() && !is_in_daylight(study)
}

/// The rows of the last thickness of a study.
fn judged(
    study: &Study,
    own_light: bool,
    levels: [&Level; 2],
    moved: Option<&MovedLevels>,
) -> Result<ThicknessRows, String> {
    let task = LayerTask::of_print(study, own_light)?;
    of_stack(&task, levels)?;
    let JudgedNumbers { numbers, .. } = with_errors(&task, levels, moved)?;
    let mut rows = ThicknessRows::default();
    if let Some((um, layer)) = task.composed.thicknesses_um.iter().zip(&numbers.requested).next_back() {
        rows.add(&task, *um, layer);
    }
    Ok(rows)
}

/// The colour at 45:0.
fn colour(study: &Study, own: &ThicknessRows, lab_covariance: [[f64; 3]; 3]) -> Option<Colour> {
    let task = LayerTask::of_print(study, true).ok()?;
    let lit = |row: &ComposedRow| row.layer.lit_at_45.map(|factor| factor.value);
    let factors: Option<Vec<f64>> = own.rows.get(task.visible.clone())?.iter().map(lit).collect();
    let eye = task.colorimeter?;
    let xyz = eye.xyz(&factors?).ok()?;
    let beyond = own.beyond_factors.first().copied().unwrap_or_default();
    let colour = eye.colour_of(std::array::from_fn(|c| xyz[c] + beyond[c]));
    Some(Colour { lab_covariance: Some(lab_covariance), ..colour })
}

/// The mean plates of a composed layer, from which its spectra of every thickness and on every
/// paper follow.
pub struct MeanPlates(Level);

impl MeanPlates {
    /// Of the solved portions of a study.
    ///
    /// # Errors
    /// A portion without complete realisations.
    pub fn new(study: &Study, solved: &[SolvedPortion]) -> Result<Self, String> {
        let [whole, _] = levels_of(study, solved)?;
        Ok(Self(whole.of_means()))
    }

    /// Factors at 45:0 of the last thickness of a study with the same slabs: over its paper, over
    /// black and over white, one after another; then the sums of these numbers.
    ///
    /// # Errors
    /// Paper without an albedo, slabs of another stack.
    pub fn spectra(&self, study: &Study, wanted: &[&WantedNumber]) -> Result<Vec<f64>, String> {
        let own = self.layer(study, true)?;
        let factors: [fn(&LayerNumbers<f64>) -> f64; 3] =
            [|layer| layer.lit_at_45, |layer| layer.over_black, |layer| layer.over_white];
        let mut all: Vec<f64> = factors.iter().flat_map(|factor| own.iter().map(factor)).collect();
        if wanted.is_empty() {
            return Ok(all);
        }
        let layer = if is_lit_apart(study) { self.layer(study, false)? } else { own };
        let task = LayerTask::of_print(study, false)?;
        for wanted in wanted {
            let asked = AskedNumber::new(wanted, &study.wavelengths_nm).ok_or("its weights are unknown")?;
            let spectra = task.weighted_spectra(&asked, &layer);
            all.extend(asked.sums_of(&spectra.iter().map(Vec::as_slice).collect::<Vec<_>>()));
        }
        Ok(all)
    }

    /// Numbers at every wavelength.
    fn layer(&self, study: &Study, own_light: bool) -> Result<Vec<LayerNumbers<f64>>, String> {
        let task = LayerTask::of_print(study, own_light)?;
        let mut numbers = task.numbers(&self.0, Change::default());
        Ok(numbers.requested.pop().ok_or("a layer without a thickness")?.spectra)
    }
}
