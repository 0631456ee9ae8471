//! The work on one realisation of one variant: its progress, for the screen and for other
//! processes, and the memory of a process divided among its workers.

use super::{BETWEEN_NEWS, Worker};
use crate::input::study::Study;
use crate::run::realisation::{Packings, RealisationRun};
use crate::run::resolve::{Resolved, kept, resolve};
use crate::run::watch::{Event, RunWatch};
use crate::run::{RunError, RunSettings, Stores};
use crate::solve::accuracy::AccuracyError;
use crate::store::record::FailureRecord;
use crate::wave::Scene;
use crate::work::rounds::stage_key;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Mutex, PoisonError, RwLock};
use std::time::Instant;

/// The work on one realisation of one variant.
pub(super) struct Work<'a> {
    pub worker: &'a Worker<'a>,
    pub study: &'a Study,
    pub realisation: usize,
    /// Labels stages with the variant's name.
    pub watch: NamedWatch<'a>,
}

impl Work<'_> {
    /// Chooses the variant's grid; returns the number of unknowns of the realisation's solves, to
    /// which its time is proportional.
    pub fn choose_grid(&self, packings: &mut Packings) -> Result<usize, RunError> {
        if self.has_failed() {
            return Ok(0);
        }
        match self.resolve(packings) {
            Ok(Resolved { resolution: r, .. }) => {
                Ok(r.nx * r.ny * r.planes() * self.study.solves_of(self.realisation))
            }
            Err(error) => {
                let source = self.study.grid_source();
                self.fail(&source, 0..source.realisations, error).map(|()| 0)
            }
        }
    }

    /// Computes the realisation; returns the number of solves without a result.
    pub fn solve(&self, packings: &mut Packings) -> Result<usize, RunError> {
        if !self.has_failed() {
            match self.realise(packings) {
                Ok(failed) => return Ok(failed),
                Err(error) => self.fail(self.study, self.realisation..self.realisation + 1, error)?,
            }
        }
        let solves = self.study.solves_of(self.realisation);
        self.watch.hear(Event::Dropped(solves));
        Ok(solves)
    }

    /// Whether the lack of a packing or grid is recorded for this realisation.
    fn has_failed(&self) -> bool {
        let failures = &self.worker.stores.failures;
        failures.has(stage_key(self.study, self.realisation).as_str()) || self.lacks_grid()
    }

    /// Whether the grid of a slab is that of another one, for which none was found.
    fn lacks_grid(&self) -> bool {
        let Cow::Owned(source) = self.study.grid_source() else { return false };
        let Stores { grids, failures, .. } = self.worker.stores;
        let has_failed = |realisation| failures.has(stage_key(&source, realisation).as_str());
        kept(&source, grids).is_none() && (0..source.realisations).all(has_failed)
    }

    /// Records that realisations of a study have no packing or no grid; any other failure ends the
    /// run.
    fn fail(&self, study: &Study, realisations: Range<usize>, error: RunError) -> Result<(), RunError> {
        let error = error.stopped();
        let (RunError::Packing { .. } | RunError::Resolution(_) | RunError::Wave(_) | RunError::Memory(_)) =
            error
        else {
            return Err(error);
        };
        if !self.watch.name.is_empty() {
            self.watch.stage(&format!("no result: {error}"));
        }
        for realisation in realisations {
            let record = FailureRecord {
                variant: self.watch.name.to_owned(),
                realisation,
                incidence: None,
                reason: error.to_string(),
            };
            self.worker.stores.failures.put(stage_key(study, realisation).as_str(), &record)?;
        }
        let _ = self.worker.failure.set(error.of_part(self.watch.name));
        Ok(())
    }

    /// The study's grid; `packings` are those of [`Study::grid_source`].
    fn resolve(&self, packings: &mut Packings) -> Result<Resolved, RunError> {
        self.worker.room.within(|memory| {
            resolve(self.study, &self.worker.stores.grids, memory, &self.watch, |r| {
                packings.get(r).map(|packing| Scene::from_packing(&packing))
            })
        })
    }

    fn realise(&self, packings: &mut Packings) -> Result<usize, RunError> {
        let resolved = &match self.study.grid_source() {
            Cow::Borrowed(_) => self.resolve(packings)?,
            Cow::Owned(source) => self.resolve(&mut Packings::new(&source, &self.watch))?,
        };
        let Self { worker: &Worker { stores, settings, ref room, .. }, study, realisation, .. } = *self;
        room.within(|memory| {
            let settings = RunSettings { memory, ..settings };
            let watch = &self.watch;
            RealisationRun { study, resolved, stores, settings, watch, realisation }.finish(packings)
        })
    }
}

/// Forwards events, with the variant's name before each stage.
pub(super) struct NamedWatch<'a> {
    /// Name of the variant; empty if it is the only one.
    pub name: &'a str,
    pub watch: &'a dyn RunWatch,
}

impl RunWatch for NamedWatch<'_> {
    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn hear(&self, event: Event) {
        let Self { name, watch } = self;
        match event {
            Event::Stage(what) if !name.is_empty() => watch.stage(&format!("{name}: {what}")),
            other => watch.hear(other),
        }
    }
}

/// Forwards the events of a unit and reports its progress to the queue.
pub(super) struct News<'a> {
    worker: &'a Worker<'a>,
    task: usize,
    /// Number of solves, and when it was last told.
    told: Mutex<(usize, Instant)>,
}

impl<'a> News<'a> {
    pub fn new(worker: &'a Worker<'a>, task: usize) -> Self {
        Self { worker, task, told: Mutex::new((0, Instant::now())) }
    }

    fn advance(&self, solves: usize) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        told.0 += solves;
        if told.1.elapsed() < BETWEEN_NEWS {
            return;
        }
        told.1 = Instant::now();
        let Worker { queue, watch, .. } = self.worker;
        match queue.advance(self.task, told.0).and_then(|()| queue.standing()) {
            Ok(standing) => watch.hear(Event::Standing(&standing)),
            Err(error) => self.worker.note(error),
        }
    }
}

impl RunWatch for News<'_> {
    fn stop(&self) -> bool {
        self.worker.watch.stop()
    }

    fn hear(&self, event: Event) {
        if matches!(event, Event::Solving(..)) {
            self.worker.begin();
        }
        self.worker.watch.hear(event);
        match event {
            Event::Kept(solves) | Event::Dropped(solves) => self.advance(solves),
            Event::Solved(..) => self.advance(1),
            _ => {}
        }
    }
}

/// The memory of a process, bytes.
#[derive(Debug)]
pub(super) struct Room {
    whole: f64,
    workers: usize,
    alone: RwLock<()>,
}

impl Room {
    /// Divides `whole` bytes among `workers`.
    pub fn new(whole: f64, workers: usize) -> Self {
        Self { whole, workers: workers.max(1), alone: RwLock::new(()) }
    }

    /// Runs `work` with an equal share of the memory; if that is too little, runs it again with all
    /// of it while the other workers wait.
    pub fn within<T>(&self, mut work: impl FnMut(f64) -> Result<T, RunError>) -> Result<T, RunError> {
        let together = self.alone.read().unwrap_or_else(PoisonError::into_inner);
        let done = work(self.whole / self.workers as f64);
        drop(together);
        match done {
            Err(error) if self.workers > 1 && lacks_memory(&error) => {
                let _alone = self.alone.write().unwrap_or_else(PoisonError::into_inner);
                work(self.whole)
            }
            done => done,
        }
    }
}

fn lacks_memory(error: &RunError) -> bool {
    use AccuracyError::{Memory, NotReached, TooLarge};
    let RunError::Resolution(error) = error else { return matches!(error, RunError::Memory(_)) };
    matches!(error, Memory(_) | TooLarge { .. } | NotReached { .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::demand::TooLarge;
    use crate::wave::{Resolution, Scheme};
    use std::sync::Mutex;

    #[derive(Default)]
    struct Heard(Mutex<Vec<String>>);

    impl RunWatch for Heard {
        fn hear(&self, event: Event) {
            self.0.lock().unwrap().push(format!("{event:?}"));
        }
    }

    #[test]
    fn a_stage_has_the_name_of_its_variant() {
        let heard = Heard::default();
        let named = NamedWatch { name: "yellow-0.3", watch: &heard };
        named.hear(Event::Stage("packing realisation 4/6"));
        named.hear(Event::Ended);
        assert_eq!(
            heard.0.into_inner().unwrap(),
            [r#"Stage("yellow-0.3: packing realisation 4/6")"#, "Ended"]
        );
    }

    #[test]
    fn what_needs_more_than_its_part_gets_everything_alone() {
        let room = Room::new(8e9, 4);
        let refuse = |memory: f64, need: f64| {
            let resolution = Resolution { nx: 1, ny: 1, cells: 1, scheme: Scheme::default() };
            let too_large = TooLarge { resolution, need_gb: 1e-9 * need, allowed_gb: 1e-9 * memory };
            if memory < need { Err(RunError::Memory(too_large)) } else { Ok(memory) }
        };
        assert_eq!(room.within(|memory| refuse(memory, 1e9)).unwrap(), 2e9);
        assert_eq!(room.within(|memory| refuse(memory, 5e9)).unwrap(), 8e9);
        assert!(room.within(|memory| refuse(memory, 9e9)).is_err());
    }
}
