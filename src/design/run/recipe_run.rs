//! One recipe, run: its study, its solves, and what is read of them.

use super::solved::{Composable, RecipeLayer, WholeLayer};
use super::{DesignError, DesignRun, Verified, study_at};
use crate::design::surface::{Spectra3, spectra};
use crate::design::wish::{NumberWish, ReachedNumber};
use crate::evaluate::composed::level::SolvedPortion;
use crate::evaluate::composed::summary::print::{ComposedPrint, MeanPlates};
use crate::evaluate::evaluated::FinishedSolves;
use crate::evaluate::ink_maker::distance;
use crate::evaluate::manifest::Manifest;
use crate::evaluate::numbers::sums_of_run;
use crate::evaluate::published::{NumberNote, Withheld};
use crate::evaluate::seen::{Seen, see};
use crate::evaluate::summary::summarise;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::run::{Collected, RunError};
use crate::store::folder::OutputFolder;
use crate::store::marker::Holds;
use crate::work::alone::{RanStudy, run_any_study};
use std::sync::Arc;

/// What is read of the solves of a recipe.
struct RecipeNumbers {
    lab: [f64; 3],
    hex: String,
    delta_e_2000: Option<Estimate>,
    contrast_ratio: Estimate,
    numbers: Vec<ReachedNumber>,
    realisations: usize,
    spectra: Spectra3,
    solved: Option<RecipeLayer>,
}

impl DesignRun<'_> {
    /// Runs a recipe, of a verifying run with its number from 1; the inner error says why it has no
    /// colour.
    ///
    /// # Errors
    /// What ends every other run as well: a stop, an unwritable folder, too little memory.
    pub(super) fn run(
        &self,
        places: &[f64],
        round: Option<usize>,
    ) -> Result<Result<Verified, String>, DesignError> {
        let task = self.task;
        let study = match self.study(places, round) {
            Ok(study) => study,
            Err(fault) => return Ok(Err(fault.to_string())),
        };
        // a folder of its own: processes that help find this study alone in its queue
        let path = self.folder.path().join("runs").join(study.key().short());
        let folder = OutputFolder::open(&path, Holds::Study).map_err(RunError::from)?;
        let solved = match run_any_study(&study, &folder, self.settings, self.watch) {
            Ok(RanStudy { solved, .. }) => solved,
            Err(error) if error.is_of_the_study() => return Ok(Err(error.to_string())),
            Err(error) => return Err(error.into()),
        };
        if self.watch.stop() {
            return Err(RunError::Stopped.into());
        }
        let read = match &solved {
            FinishedSolves::Whole(collected) => self.read_whole(&study, collected)?,
            FinishedSolves::Slabs(slabs) => self.read_slabs(&study, slabs),
        };
        Ok(read.map(|read| Verified {
            recipe: task.in_words(places),
            values: task.values(places),
            lab: read.lab,
            hex: read.hex,
            delta_e_2000: read.delta_e_2000,
            predicted: None,
            surface_error: None,
            contrast_ratio: read.contrast_ratio,
            numbers: read.numbers,
            realisations: read.realisations,
            cost: task.cost(places),
            places: places.to_vec(),
            spectra: read.spectra,
            solved: read.solved.map(|layer| Arc::new(Composable::new(layer))),
        }))
    }

    /// What a layer that is solved as a whole gives, or why it gives no colour.
    fn read_whole(
        &self,
        study: &Study,
        collected: &Collected,
    ) -> Result<Result<RecipeNumbers, String>, DesignError> {
        let task = self.task;
        let seen = match see(study, collected) {
            Ok(seen) => seen,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let mut spectra = match &seen.ink {
            Ok(ink) => spectra(study, ink)?,
            Err(reason) => return Ok(Err(reason.to_string())),
        };
        match self.number_sums(study, &seen) {
            Ok(sums) => spectra.extend(sums),
            Err(reason) => return Ok(Err(reason)),
        }
        let manifest = summarise(study, collected, &seen);
        if let Some(what) = manifest.unphysical() {
            return Ok(Err(format!("{what}: curves through few wavelengths and cells overshoot")));
        }
        let realisations = manifest.main_numbers().realisations;
        let Manifest { ink_maker, no_ink_maker, no_colour, numbers, withheld, .. } = manifest;
        let target = ink_maker.as_ref().and_then(|maker| maker.target.as_ref());
        let delta_e_2000 = target.map(|target| target.delta_e_2000);
        let Some(maker) = ink_maker.filter(|_| delta_e_2000.is_some() || task.lab.is_none()) else {
            let reason = no_ink_maker.or(no_colour);
            return Ok(Err(reason.unwrap_or_else(|| "the run gives no colour at 45:0".into())));
        };
        let numbers = match self.reached(&numbers, &withheld) {
            Ok(numbers) => numbers,
            Err(reason) => return Ok(Err(reason)),
        };
        // kept for other papers alone
        let is_kept = task.composed().next().is_some();
        let layer = if is_kept { Some(WholeLayer::new(task, study, seen)?) } else { None };
        Ok(Ok(RecipeNumbers {
            lab: maker.print.colour.lab,
            hex: maker.print.hex,
            delta_e_2000,
            contrast_ratio: maker.contrast_ratio,
            numbers,
            realisations,
            spectra,
            solved: layer.map(RecipeLayer::Whole),
        }))
    }

    /// What a layer that is composed of slabs gives, or why it gives no colour.
    fn read_slabs(&self, study: &Study, slabs: &[SolvedPortion]) -> Result<RecipeNumbers, String> {
        let task = self.task;
        let print = ComposedPrint::new(study, slabs)?;
        let reason = || print.withheld.first().map_or("its colour is withheld".into(), Withheld::in_words);
        let colour = print.colour.ok_or_else(reason)?;
        let contrast_ratio = print.contrast_ratio.ok_or_else(reason)?;
        let exact = |lab: [f64; 3]| distance(&colour, lab);
        let [r, g, b] = colour.srgb8;
        let solved = RecipeLayer::Slabs(MeanPlates::new(study, slabs)?);
        Ok(RecipeNumbers {
            lab: colour.lab,
            hex: format!("#{r:02x}{g:02x}{b:02x}"),
            delta_e_2000: task.lab.map(exact),
            contrast_ratio,
            numbers: self.reached(&print.numbers, &print.withheld)?,
            realisations: print.realisations,
            spectra: solved.spectra(task, study)?.layer,
            solved: Some(solved),
        })
    }

    /// The sums behind the numbers that are wanted.
    fn number_sums(&self, study: &Study, seen: &Seen) -> Result<Vec<f64>, String> {
        let each = self.task.numbers.iter().map(|wish| sums_of_run(&wish.wanted, study, seen));
        Ok(each.collect::<Result<Vec<_>, String>>()?.concat())
    }

    /// The numbers of a run that are wanted, or why one of them is withheld.
    fn reached(&self, notes: &[NumberNote], withheld: &[Withheld]) -> Result<Vec<ReachedNumber>, String> {
        let find = |wish: &NumberWish| {
            let note = notes.iter().find(|note| note.name == wish.name);
            let reached = note.and_then(|note| note.estimate());
            let name = wish.name.clone();
            reached.map(|estimate| ReachedNumber { name, estimate, predicted: None }).ok_or_else(|| {
                let is_it = |withheld: &&Withheld| {
                    let rest = withheld.number.strip_prefix(&wish.name);
                    // of a composed layer with its thickness
                    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(" of "))
                };
                let withheld = withheld.iter().find(is_it);
                withheld.map_or_else(|| format!("it has no {}", wish.name), |why| why.in_words())
            })
        };
        self.task.numbers.iter().map(find).collect()
    }

    /// The study of a recipe. A verifying run has the requested number of packings, and others than
    /// the variants and every earlier one: searches fit their answer to the chance of the runs
    /// before.
    pub(super) fn study(&self, places: &[f64], round: Option<usize>) -> Result<Study, DesignError> {
        let mut study = study_at(self.task, places)?;
        study.judgement.target_lab = self.task.lab;
        if let Some(round) = round {
            study.packing.seed = study.packing.seed.wrapping_add(round as u64);
            study.realisations = self.task.settings.realisations.unwrap_or(study.realisations);
        }
        Ok(study)
    }
}
