//! The work on one realisation of one variant.

use super::super::stored::stage_key;
use super::room::Room;
use crate::input::study::Study;
use crate::run::realisation::{Packings, RealisationRun};
use crate::run::resolve::{Resolved, resolve};
use crate::run::watch::{Event, RunWatch};
use crate::run::{RunError, RunSettings, Stores};
use crate::store::record::FailureRecord;
use crate::wave::Scene;

/// The work on one realisation of one variant.
pub(super) struct Work<'a> {
    pub name: &'a str,
    pub study: &'a Study,
    pub stores: &'a Stores,
    pub settings: RunSettings,
    pub room: &'a Room,
    /// Labels stages with the variant's name.
    pub watch: &'a dyn RunWatch,
    pub realisation: usize,
}

impl Work<'_> {
    /// Computes the realisation; returns the number of solves without a result.
    pub fn go(&self, packings: &mut Packings) -> Result<usize, RunError> {
        if self.has_failed() {
            return Ok(self.drop_all());
        }
        self.realise(packings)
    }

    /// Reports that no solve of the realisation can be computed; returns their number.
    pub fn drop_all(&self) -> usize {
        let solves = self.study.solves_of(self.realisation);
        self.watch.hear(Event::Dropped(solves));
        solves
    }

    /// Whether the lack of a packing or grid is recorded for this realisation.
    pub fn has_failed(&self) -> bool {
        let key = stage_key(self.study, self.realisation);
        self.stores.failures.has(key.as_str())
    }

    /// Records that realisations have no packing or no grid.
    pub fn note_failure(
        &self,
        realisations: std::ops::Range<usize>,
        error: &RunError,
    ) -> Result<(), RunError> {
        let (variant, reason) = (self.name.to_owned(), error.to_string());
        if !variant.is_empty() {
            self.watch.stage(&format!("no result: {reason}"));
        }
        for realisation in realisations {
            let (variant, reason) = (variant.clone(), reason.clone());
            let record = FailureRecord { variant, realisation, incidence: None, reason };
            self.stores.failures.put(stage_key(self.study, realisation).as_str(), &record)?;
        }
        Ok(())
    }

    pub fn resolve(&self, packings: &mut Packings) -> Result<Resolved, RunError> {
        self.room.within(|memory| {
            resolve(self.study, &self.stores.grids, memory, self.watch, |r| {
                packings.get(r).map(|packing| Scene::from_packing(&packing))
            })
        })
    }

    fn realise(&self, packings: &mut Packings) -> Result<usize, RunError> {
        let resolved = &self.resolve(packings)?;
        let Self { study, stores, watch, realisation, .. } = *self;
        self.room.within(|memory| {
            let settings = RunSettings { memory, ..self.settings };
            RealisationRun { study, resolved, stores, settings, watch, realisation }.finish(packings)
        })
    }

    /// Number of unknowns of a realisation's solves, to which its time is proportional.
    pub fn cost(&self, resolved: &Resolved) -> f64 {
        let r = resolved.resolution;
        (r.nx * r.ny * r.planes() * self.study.solves_of(self.realisation)) as f64
    }
}

/// Whether the failure belongs to a variant; all others end the run.
pub(super) fn is_failure(error: &RunError) -> bool {
    matches!(
        error,
        RunError::Packing { .. } | RunError::Resolution(_) | RunError::Wave(_) | RunError::Memory(_)
    )
}
