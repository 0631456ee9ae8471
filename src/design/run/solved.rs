//! A recipe that was solved, from which its spectra at every place of the composed axes follow: on
//! every paper, and of every thickness where it is composed of slabs.

use super::{DesignError, study_at};
use crate::design::recipe::DesignTask;
use crate::design::surface::{Spectra3, spectra};
use crate::evaluate::composed::summary::print::MeanPlates;
use crate::evaluate::numbers::sums_of_ink;
use crate::evaluate::seen::Seen;
use crate::input::study::Study;
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// What the solves of a recipe tell of all papers and thicknesses.
pub(super) enum RecipeLayer {
    /// Solved as a whole.
    Whole(Box<Seen>),
    /// Composed of slabs.
    Slabs(MeanPlates),
}

/// A recipe's layer with the spectra that have been composed from it, by the places of the composed
/// axes.
pub(super) struct Composable {
    layer: RecipeLayer,
    known: Mutex<HashMap<Vec<u64>, Arc<Spectra3>>>,
}

impl fmt::Debug for Composable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("Composable")
    }
}

impl RecipeLayer {
    /// Spectra of the layer under another study, which takes the same solves, and the sums of the
    /// numbers that are wanted.
    pub fn spectra(&self, task: &DesignTask, study: &Study) -> Result<Spectra3, String> {
        let wanted: Vec<_> = task.numbers.iter().map(|wish| &wish.wanted).collect();
        match self {
            Self::Whole(seen) => {
                let ink = seen.ink_on_paper_of(study)?;
                let mut all = spectra(study, &ink).map_err(|error| error.to_string())?;
                for wanted in wanted {
                    all.extend(sums_of_ink(wanted, study, seen, &ink)?);
                }
                Ok(all)
            }
            Self::Slabs(plates) => plates.spectra(study, &wanted),
        }
    }
}

impl Composable {
    pub fn new(layer: RecipeLayer) -> Self {
        Self { layer, known: Mutex::default() }
    }

    /// Spectra of the recipe of which this is the layer, at a place of the box that differs from it
    /// on the composed axes alone.
    pub fn at(&self, task: &DesignTask, places: &[f64]) -> Result<Arc<Spectra3>, DesignError> {
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
