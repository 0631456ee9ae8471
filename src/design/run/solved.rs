//! A recipe that was solved, from which its spectra at every place of the composed axes follow: on
//! every paper, and of every thickness where it is composed of slabs.

use super::{DesignError, study_at};
use crate::design::recipe::DesignTask;
use crate::design::surface::Spectra3;
use crate::evaluate::composed::summary::print::MeanPlates;
use crate::evaluate::ink_maker::bare::BareInk;
use crate::evaluate::numbers::sums_of_ink;
use crate::evaluate::seen::{Seen, film_alone};
use crate::input::study::Study;
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// A layer that was solved as a whole, to be laid on all papers.
pub(super) struct WholeLayer {
    ink: BareInk,
    film: BareInk,
    /// What weighted numbers take, where any are wanted.
    seen: Option<Box<Seen>>,
}

/// What the solves of a recipe tell of all papers and thicknesses.
pub(super) enum RecipeLayer {
    /// Solved as a whole.
    Whole(WholeLayer),
    /// Composed of slabs.
    Slabs(MeanPlates),
}

/// Spectra of a recipe at a place of the composed axes.
pub(super) struct ComposedSpectra {
    /// Those of its layer, and the sums of the numbers that are wanted.
    pub layer: Spectra3,
    /// Those of its film, without sums; none of a layer in slabs.
    pub film: Spectra3,
}

/// A recipe's layer with the spectra that have been composed from it, by the places of the composed
/// axes.
pub(super) struct Composable {
    layer: RecipeLayer,
    known: Mutex<HashMap<Vec<u64>, Arc<ComposedSpectra>>>,
}

impl fmt::Debug for Composable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("Composable")
    }
}

impl WholeLayer {
    /// Of the evaluated solves of a study.
    pub fn new(task: &DesignTask, study: &Study, seen: Seen) -> Result<Self, DesignError> {
        let none = |reason| DesignError::NoColour(format!("{}: {reason}", study.title));
        let ink = seen.ink.as_ref().map_err(none)?;
        Ok(Self {
            ink: BareInk::new(ink)?,
            film: BareInk::new(&film_alone(study)?)?,
            seen: (!task.numbers.is_empty()).then(|| Box::new(seen.of_means())),
        })
    }

    /// Its spectra on the paper of a study.
    fn spectra(&self, task: &DesignTask, study: &Study) -> Result<ComposedSpectra, String> {
        let on_paper = |ink: &BareInk| ink.factors(study).map_err(|error| error.to_string());
        let mut layer = on_paper(&self.ink)?;
        if let Some(seen) = &self.seen {
            let ink = seen.ink_on_paper_of(study)?;
            for wish in &task.numbers {
                layer.extend(sums_of_ink(&wish.wanted, study, seen, &ink)?);
            }
        }
        Ok(ComposedSpectra { layer, film: on_paper(&self.film)? })
    }
}

impl RecipeLayer {
    /// Spectra of the layer under another study, which takes the same solves, and the sums of the
    /// numbers that are wanted.
    pub fn spectra(&self, task: &DesignTask, study: &Study) -> Result<ComposedSpectra, String> {
        match self {
            Self::Whole(layer) => layer.spectra(task, study),
            Self::Slabs(plates) => {
                let wanted: Vec<_> = task.numbers.iter().map(|wish| &wish.wanted).collect();
                Ok(ComposedSpectra { layer: plates.spectra(study, &wanted)?, film: Vec::new() })
            }
        }
    }
}

impl Composable {
    pub fn new(layer: RecipeLayer) -> Self {
        Self { layer, known: Mutex::default() }
    }

    /// Spectra of the recipe of which this is the layer, at a place of the box that differs from it
    /// on the composed axes alone.
    pub fn at(&self, task: &DesignTask, places: &[f64]) -> Result<Arc<ComposedSpectra>, DesignError> {
        let name: Vec<u64> = task.composed_places(places).into_iter().map(f64::to_bits).collect();
        if let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&name) {
            return Ok(known.clone());
        }
        let study = study_at(task, places)?;
        let spectra = self.layer.spectra(task, &study);
        let spectra = spectra.map_err(|reason| DesignError::no_colour(task, places, reason))?;
        let spectra = Arc::new(spectra);
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(name, spectra.clone());
        Ok(spectra)
    }
}
