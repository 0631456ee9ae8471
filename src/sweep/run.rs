//! Carries a sweep out, or one shard of it, alone or together with other processes of the same folder.
//!
//! Workers (threads of a process, and processes) take units from a common [`Queue`], the costliest first; a group's
//! grids are chosen before its realisations. Every solve is in the store before the next begins. What fails is recorded
//! there too and does not stop the rest; it is not tried again before that is asked.

use super::folder;
use super::load::Sweep;
use super::units::{Shard, Unit, units};
use crate::input::study::{Point, Study};
use crate::run::crew::Crew;
use crate::run::realisation::{Packings, RealisationRun};
use crate::run::resolve::{Resolved, resolve};
use crate::run::runner::{Realisation, RunError, RunSettings, Stores, stopped};
use crate::run::watch::RunWatch;
use crate::store::damage::Damage;
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::queue::{Claim, Queue, Standing, Task};
use crate::store::record::FailureRecord;
use crate::wave::Scene;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

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
    shard: Shard,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Tally, RunError> {
    let stores = folder::stores(folder)?;
    let jobs = jobs(sweep, shard);
    let tasks: Vec<Task> = jobs.iter().map(|job| job.task(sweep)).collect();
    let queue = stores.database().queue(name(sweep, shard).as_str(), &tasks)?;
    let crew = Crew::new(settings.jobs, jobs.len())?;
    let settings = RunSettings { jobs: Some(crew.jobs_each), ..settings };
    let trouble = Mutex::new(None);
    let worker = Worker { sweep, stores: &stores, queue: &queue, jobs: &jobs, settings, watch, trouble };
    crew.work_off(|| worker.take(), |task| worker.note(worker.go(task)));
    match worker.trouble.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None => {
            let damages = stores.database().damages();
            Ok(Tally { asked: solves(sweep, shard), damages, ..tally(&queue, watch.stop())? })
        }
    }
}

fn tally(queue: &Queue, stopped: bool) -> Result<Tally, RunError> {
    let Standing { workers, solves, failed, .. } = queue.standing()?;
    let publishes = if stopped { workers == 1 } else { queue.publishes()? };
    Ok(Tally { finished: solves - failed, failed, publishes, ..Tally::default() })
}

/// Names the work, so that only processes with the same sweep and shard share it.
fn name(sweep: &Sweep, shard: Shard) -> Key {
    let studies: Vec<Key> = sweep.variants.iter().map(|variant| variant.study.key()).collect();
    Key::of("work", &(studies, shard.index, shard.count))
}

/// A task of the queue in full.
enum Job {
    /// The choice of a group's grids, and the places of the tasks that wait for it.
    Grids(Vec<usize>),
    /// A unit, and the place of its group's grids.
    Unit(Unit, usize),
}

impl Job {
    fn task(&self, sweep: &Sweep) -> Task {
        let volume = |v: &usize| sweep.variants[*v].study.volume_um3();
        match self {
            Self::Grids(variants) => {
                Task { cost: GRIDS_FIRST * variants.iter().map(volume).sum::<f64>(), after: None }
            }
            // Until the grid is known.
            Self::Unit(unit, grids) => Task { cost: solves_of(sweep, unit) as f64, after: Some(*grids) },
        }
    }
}

/// The units of a shard, and before them the grids of their groups.
fn jobs(sweep: &Sweep, shard: Shard) -> Vec<Job> {
    let units = units(sweep);
    let mine = &units[shard.range(units.len())];
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for unit in mine {
        let group = groups.entry(unit.group).or_default();
        group.extend(&unit.variants);
        group.sort_unstable();
        group.dedup();
    }
    let place = |group: usize| groups.keys().position(|&g| g == group).unwrap_or(0);
    let of_unit: Vec<Job> = mine.iter().map(|unit| Job::Unit(unit.clone(), place(unit.group))).collect();
    groups.into_values().map(Job::Grids).chain(of_unit).collect()
}

/// What the threads of a process share.
struct Worker<'a> {
    sweep: &'a Sweep,
    stores: &'a Stores,
    queue: &'a Queue,
    jobs: &'a [Job],
    settings: RunSettings,
    watch: &'a dyn RunWatch,
    trouble: Mutex<Option<RunError>>,
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
                Ok(Claim::Wait) => std::thread::sleep(WAIT),
                Ok(Claim::Finished) => return None,
                Err(error) => self.note(Err(error)),
            }
        }
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
        Work { name, study, stores: self.stores, settings: self.settings, watch, realisation }
    }
}

/// Failures that belong to a variant; all others end the run.
fn is_failure(error: &RunError) -> bool {
    matches!(
        error,
        RunError::Packing { .. } | RunError::Resolution(_) | RunError::Wave(_) | RunError::Memory(_)
    )
}

/// One realisation of one variant.
struct Work<'a> {
    name: &'a str,
    study: &'a Study,
    stores: &'a Stores,
    settings: RunSettings,
    watch: &'a dyn RunWatch,
    realisation: usize,
}

impl Work<'_> {
    /// Gives the number of solves without a result.
    fn go(&self, packings: &mut Packings) -> Result<usize, RunError> {
        if self.has_failed() {
            self.watch.kept(self.study, self.study.solves_each());
            return Ok(self.study.solves_each());
        }
        match self.realise(packings).map_err(stopped) {
            Ok(realisation) => Ok(realisation.failures.len()),
            Err(RunError::Stopped) => Ok(0),
            Err(error) if is_failure(&error) => {
                self.watch.kept(self.study, self.study.solves_each());
                self.note_failure(self.realisation..self.realisation + 1, &error)?;
                Ok(self.study.solves_each())
            }
            Err(error) => Err(error),
        }
    }

    /// Whether it is recorded that this realisation has no packing or no grid.
    fn has_failed(&self) -> bool {
        let key = stage_key(self.study, self.realisation);
        self.stores.failures.as_ref().is_some_and(|store| store.has(key.as_str()))
    }

    /// Records that realisations have no packing or no grid.
    fn note_failure(&self, realisations: std::ops::Range<usize>, error: &RunError) -> Result<(), RunError> {
        let (variant, reason) = (self.name.to_owned(), error.to_string());
        self.watch.stage(&format!("{variant}: no result: {reason}"));
        let Some(failures) = &self.stores.failures else { return Ok(()) };
        for realisation in realisations {
            let (variant, reason) = (variant.clone(), reason.clone());
            let record = FailureRecord { variant, realisation, incidence: None, reason };
            failures.put(stage_key(self.study, realisation).as_str(), &record)?;
        }
        Ok(())
    }

    fn resolve(&self, packings: &mut Packings) -> Result<Resolved, RunError> {
        let scene = |r: usize| packings.get(r).map(|packing| Scene::from_packing(&packing));
        resolve(self.study, &self.stores.grids, self.settings.memory, self.watch, scene)
    }

    fn realise(&self, packings: &mut Packings) -> Result<Realisation, RunError> {
        let resolved = self.resolve(packings)?;
        let Self { study, stores, settings, watch, realisation, .. } = *self;
        RealisationRun { study, resolved: &resolved, stores, settings, watch, realisation }.finish(packings)
    }

    /// Unknowns of a realisation's solves, which its time goes with.
    fn cost(&self, resolved: &Resolved) -> f64 {
        let r = resolved.resolution;
        (r.nx * r.ny * r.planes() * self.study.solves_each()) as f64
    }
}

/// Passes on what a unit does, and tells the other workers how far it is.
struct News<'a> {
    worker: &'a Worker<'a>,
    task: usize,
    solves: AtomicUsize,
    told: Mutex<Instant>,
}

impl<'a> News<'a> {
    fn new(worker: &'a Worker<'a>, task: usize) -> Self {
        Self { worker, task, solves: AtomicUsize::new(0), told: Mutex::new(Instant::now()) }
    }

    fn advance(&self, solves: usize) {
        let solves = self.solves.fetch_add(solves, Ordering::Relaxed) + solves;
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.elapsed() < BETWEEN_NEWS {
            return;
        }
        *told = Instant::now();
        let Worker { queue, watch, .. } = self.worker;
        match queue.advance(self.task, solves).and_then(|()| queue.standing()) {
            Ok(standing) => watch.standing(&standing),
            Err(error) => self.worker.note(Err(error.into())),
        }
    }
}

impl RunWatch for News<'_> {
    fn stop(&self) -> bool {
        self.worker.watch.stop()
    }

    fn stage(&self, what: &str) {
        self.worker.watch.stage(what);
    }

    fn solving(&self, study: &Study, point: &Point) {
        self.worker.watch.solving(study, point);
    }

    fn kept(&self, study: &Study, solves: usize) {
        self.worker.watch.kept(study, solves);
        self.advance(solves);
    }

    fn ended(&self) {
        self.worker.watch.ended();
    }

    fn solved(&self, study: &Study, point: &Point, failure: Option<&str>) {
        self.worker.watch.solved(study, point, failure);
        self.advance(1);
    }
}

/// Forgets all failures, so that they are tried again.
///
/// # Errors
/// The store cannot be written to.
pub fn forget_failures(folder: &OutputFolder) -> std::io::Result<()> {
    folder::stores(folder)?.failures.map_or(Ok(()), |failures| failures.remove_all())
}

/// What a realisation's packing and grid depend on.
pub(crate) fn stage_key(study: &Study, realisation: usize) -> Key {
    let indices: Vec<_> = study.wavelengths_nm.iter().map(|nm| study.indices(1e-3 * nm)).collect();
    let light = (&study.wavelengths_nm, &study.angles, indices);
    let method = (&study.resolution, &study.solver, &study.goal);
    Key::of("stage", &(study.packing_request(realisation), light, method))
}
