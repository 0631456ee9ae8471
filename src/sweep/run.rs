//! Carries a sweep out, or one shard of it, alone or together with other processes of the same folder.
//!
//! Workers (threads of a process, and processes) take units from a common [`Queue`], the costliest first; a group's
//! grids are chosen before its realisations. Every solve is in the store before the next begins. What fails is recorded
//! there too and does not stop the rest; it is not tried again before that is asked.

mod jobs;
mod news;
mod room;
mod work;

use super::folder;
use super::load::Sweep;
use super::units::{Shard, Unit, units};
use crate::run::crew::Crew;
use crate::run::realisation::Packings;
use crate::run::runner::{RunError, RunSettings, Stores, stopped};
use crate::run::watch::RunWatch;
use crate::store::damage::Damage;
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::queue::{Claim, Queue, Standing, Task};
use jobs::{Job, jobs};
use news::News;
use room::Room;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use work::{Work, is_failure};

pub(crate) use work::stage_key;

/// A worker without work looks again after this time.
const WAIT: Duration = Duration::from_millis(50);
/// Others are told of progress at most so often.
const BETWEEN_NEWS: Duration = Duration::from_millis(500);
/// Grids come before all units.
const GRIDS_FIRST: f64 = 1e30;

/// What a run of a sweep has come to, over all workers of the folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Solves of the shard, those that variants share counted for each of them.
    pub asked: usize,
    /// Solves that are there.
    pub finished: usize,
    /// Solves without a result.
    pub failed: usize,
    /// Whether this process is the one to write the report.
    pub publishes: bool,
    /// What this process found damaged in the store.
    pub damages: Vec<Damage>,
    /// Time that the threads of this process waited for others.
    pub waited: Duration,
}

/// How far the work goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Scope {
    /// The choice of grids alone.
    Grids,
    /// Grids and solves.
    Solves,
}

/// Number of solves of a shard, those that variants share counted for each of them.
pub fn solves(sweep: &Sweep, shard: Shard) -> usize {
    let units = units(sweep);
    units[shard.range(units.len())].iter().map(|unit| solves_of(sweep, unit)).sum()
}

fn solves_of(sweep: &Sweep, unit: &Unit) -> usize {
    unit.variants.iter().map(|&v| sweep.variants[v].study.solves_each()).sum()
}

/// Runs a shard into `folder` until it is finished or stopped.
///
/// # Errors
/// Records that cannot be written, or threads that cannot be started; failures of variants are recorded.
pub fn run(
    sweep: &Sweep,
    folder: &OutputFolder,
    (shard, scope): (Shard, Scope),
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Tally, RunError> {
    let stores = folder::stores(folder)?;
    let mut jobs = jobs(sweep, shard);
    jobs.retain(|job| scope == Scope::Solves || matches!(job, Job::Grids(_)));
    let tasks: Vec<Task> = jobs.iter().map(|job| job.task(sweep)).collect();
    let queue = stores.database().queue(name(sweep, shard, scope).as_str(), &tasks)?;
    let crew = Crew::new(settings.jobs, jobs.len())?;
    let room = Room::new(settings.memory, crew.workers());
    let settings = RunSettings { jobs: Some(crew.jobs_each), ..settings };
    let (trouble, waits) = (Mutex::new(None), AtomicUsize::new(0));
    let (stores, queue, jobs) = (&stores, &queue, &jobs);
    let worker = Worker { sweep, stores, queue, jobs, settings, room, watch, trouble, waits };
    crew.work_off(|| worker.take(), |task| worker.note(worker.go(task)));
    let waited = WAIT * worker.waits.load(Ordering::Relaxed) as u32;
    match worker.trouble.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None => {
            let damages = stores.database().damages();
            Ok(Tally { asked: solves(sweep, shard), damages, waited, ..tally(queue, watch.stop())? })
        }
    }
}

fn tally(queue: &Queue, stopped: bool) -> Result<Tally, RunError> {
    let Standing { workers, solves, failed, .. } = queue.standing()?;
    let publishes = if stopped { workers == 1 } else { queue.publishes()? };
    Ok(Tally { finished: solves - failed, failed, publishes, ..Tally::default() })
}

/// Names the work, so that only processes with the same sweep and shard share it.
fn name(sweep: &Sweep, shard: Shard, scope: Scope) -> Key {
    let studies: Vec<Key> = sweep.variants.iter().map(|variant| variant.study.key()).collect();
    Key::of("work", &(studies, shard.index, shard.count, scope))
}

/// What the threads of a process share.
struct Worker<'a> {
    sweep: &'a Sweep,
    stores: &'a Stores,
    queue: &'a Queue,
    jobs: &'a [Job],
    settings: RunSettings,
    room: Room,
    watch: &'a dyn RunWatch,
    trouble: Mutex<Option<RunError>>,
    /// How often a thread found nothing to do.
    waits: AtomicUsize,
}

impl Worker<'_> {
    /// The next task; `None` when there is no more, or no more shall be done.
    fn take(&self) -> Option<usize> {
        loop {
            if self.watch.stop() || self.has_trouble() {
                return None;
            }
            let claim = self
                .stores
                .database()
                .refresh()
                .map_err(RunError::Store)
                .and_then(|()| Ok(self.queue.claim()?));
            match claim {
                Ok(Claim::Task(task)) => return Some(task),
                Ok(Claim::Wait) => self.wait(),
                Ok(Claim::Finished) => return None,
                Err(error) => self.note(Err(error)),
            }
        }
    }

    fn wait(&self) {
        std::thread::sleep(WAIT);
        self.waits.fetch_add(1, Ordering::Relaxed);
    }

    fn go(&self, task: usize) -> Result<(), RunError> {
        match &self.jobs[task] {
            Job::Grids(variants) => self.grids(task, variants),
            Job::Unit(unit, _) => self.unit(task, unit),
        }
    }

    fn note(&self, done: Result<(), RunError>) {
        if let Err(error) = done {
            self.trouble.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }

    fn has_trouble(&self) -> bool {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Chooses the grids of a group and tells what its units cost.
    fn grids(&self, task: usize, variants: &[usize]) -> Result<(), RunError> {
        let mut packings = Packings::new(&self.sweep.variants[variants[0]].study, self.watch);
        let mut cost = 0.0;
        for &v in variants {
            let work = self.work(v, 0, self.watch);
            if work.has_failed() {
                continue;
            }
            match work.resolve(&mut packings).map_err(stopped) {
                Ok(resolved) => cost += work.cost(&resolved),
                Err(RunError::Stopped) => return Ok(self.queue.give_back(task)?),
                Err(error) if is_failure(&error) => work.note_failure(0..work.study.realisations, &error)?,
                Err(error) => return Err(error),
            }
        }
        self.queue.reckon(task, cost)?;
        Ok(self.queue.finish(task, 0, 0)?)
    }

    /// Solves a unit.
    fn unit(&self, task: usize, unit: &Unit) -> Result<(), RunError> {
        let news = News::new(self, task);
        let mut packings = Packings::new(&self.sweep.variants[unit.variants[0]].study, &news);
        let mut failed = 0;
        for &v in &unit.variants {
            if self.watch.stop() {
                break;
            }
            failed += self.work(v, unit.realisation, &news).go(&mut packings)?;
        }
        if self.watch.stop() {
            return Ok(self.queue.give_back(task)?);
        }
        Ok(self.queue.finish(task, solves_of(self.sweep, unit), failed)?)
    }

    fn work<'a>(&'a self, variant: usize, realisation: usize, watch: &'a dyn RunWatch) -> Work<'a> {
        let variant = &self.sweep.variants[variant];
        let (name, study) = (&variant.name, &variant.study);
        Work {
            name,
            study,
            stores: self.stores,
            settings: self.settings,
            room: &self.room,
            watch,
            realisation,
        }
    }
}

/// Forgets all failures, so that they are tried again.
///
/// # Errors
/// The store cannot be written to.
pub fn forget_failures(folder: &OutputFolder) -> std::io::Result<()> {
    folder::stores(folder)?.failures.map_or(Ok(()), |failures| failures.remove_all())
}
