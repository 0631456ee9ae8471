//! Carries a sweep out, or one shard of it, alone or together with other processes of the same folder.
//!
//! Workers (threads of a process, and processes) take units from a common [`Queue`], the costliest first; a group's
//! grids are chosen before its realisations. Every solve is in the store before the next begins. What fails is recorded
//! there too and does not stop the rest; it is not tried again before that is asked.

mod jobs;
mod named;
mod news;
mod room;
mod work;

use super::rounds::Rounds;
use super::units::{Shard, Unit, units};
use crate::run::crew::Crew;
use crate::run::realisation::Packings;
use crate::run::watch::RunWatch;
use crate::run::{RunError, RunSettings, Stores};
use crate::store::damage::Damage;
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::queue::{Assignment, Queue, QueueStanding, QueuedTask};
use crate::sweep::definition::load::Sweep;
use jobs::{Job, jobs};
use named::NamedWatch;
use news::News;
use room::Room;
use serde::Serialize;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;
use work::{Work, is_failure};

/// A worker without work looks again after this time.
const WAIT: Duration = Duration::from_millis(50);
/// Others are told of progress at most so often.
const BETWEEN_NEWS: Duration = Duration::from_millis(500);
/// Tasks of a round are numbered from a multiple of this: more than any round has.
const ROUND: usize = 1 << 32;
/// Grids come before all units.
const GRIDS_FIRST: f64 = 1e30;

/// What a run of a sweep has come to, over all workers of the folder.
#[derive(Debug, Default)]
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
    /// The first packing or grid that failed in this process.
    pub failure: Option<RunError>,
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
    let stores = Stores::open(folder)?;
    let queue = stores.database().queue(name(sweep, shard, scope).as_str())?;
    if settings.retry_failed && queue.standing()?.workers == 1 {
        stores.failures.remove_all()?;
    }
    let (mut rounds, mut waited) = (Rounds::new(sweep), Duration::ZERO);
    let (mut before, mut failure) = (None, None);
    while let Some((round, units)) = rounds.next(&stores) {
        let units = &units[shard.range(units.len())];
        // A round that has not come to its end although the queue has nothing left is no work for another turn.
        let Some(turn) = WorkTurn::new((round, units), scope).filter(|_| before != Some(round)) else {
            break;
        };
        let crew = Crew::new(settings.jobs, turn.at_a_time())?;
        let room = Room::new(settings.memory, crew.workers());
        let settings = RunSettings { jobs: Some(crew.jobs_each), ..settings };
        let worker = Worker::new((sweep, folder), (&stores, &queue), &turn, (settings, room), watch);
        queue.enlist(turn.first, &turn.tasks(sweep))?;
        // Nothing can be done beside the choice of the only grids: all threads take part in it.
        if turn.groups() == 1
            && let Some(task) = worker.take()
        {
            worker.note(worker.go(task));
        }
        crew.work_off(|| worker.take(), |task| worker.note(worker.go(task)));
        waited += WAIT * worker.waits.load(Ordering::Relaxed) as u32;
        before = (!worker.overtaken.load(Ordering::Relaxed)).then_some(round);
        let Worker { trouble, failure: failed, .. } = worker;
        taken(trouble).map_or(Ok(()), Err)?;
        failure = failure.or(taken(failed));
        if watch.stop() || scope == Scope::Grids || !Rounds::wanted(sweep) {
            break;
        }
        stores.database().refresh()?;
    }
    let damages = stores.database().damages();
    Ok(Tally { asked: solves(sweep, shard), damages, failure, waited, ..tally(&queue, watch.stop())? })
}

fn tally(queue: &Queue, stopped: bool) -> Result<Tally, RunError> {
    let QueueStanding { workers, solves, failed, .. } = queue.standing()?;
    let publishes = if stopped { workers == 1 } else { queue.publishes()? };
    Ok(Tally { finished: solves - failed, failed, publishes, ..Tally::default() })
}

fn taken<T>(mutex: Mutex<Option<T>>) -> Option<T> {
    mutex.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// The jobs of a round, and the number of the first of their tasks.
struct WorkTurn {
    first: usize,
    jobs: Vec<Job>,
}

impl WorkTurn {
    /// `None` without a job.
    fn new((round, units): (usize, &[Unit]), scope: Scope) -> Option<Self> {
        let mut jobs = jobs(units);
        jobs.retain(|job| scope == Scope::Solves || matches!(job, Job::Grids(_)));
        (!jobs.is_empty()).then_some(Self { first: round * ROUND, jobs })
    }

    /// Groups whose grids are chosen.
    fn groups(&self) -> usize {
        self.jobs.iter().filter(|job| matches!(job, Job::Grids(_))).count()
    }

    /// Most tasks that can be under way together: units wait for their grids.
    fn at_a_time(&self) -> usize {
        self.groups().max(self.jobs.len() - self.groups())
    }

    fn tasks(&self, sweep: &Sweep) -> Vec<QueuedTask> {
        self.jobs.iter().map(|job| job.task(sweep)).collect()
    }
}

/// Names the work, so that only processes with the same sweep and shard share it.
fn name(sweep: &Sweep, shard: Shard, scope: Scope) -> Key {
    let studies: Vec<Key> = sweep.variants.iter().map(|variant| variant.study.key()).collect();
    Key::of("work", &(studies, shard.index, shard.count, scope))
}

/// What the threads of a process share.
struct Worker<'a> {
    sweep: &'a Sweep,
    /// What stands before the stages of each variant.
    prefixes: Vec<String>,
    folder: &'a OutputFolder,
    /// Solves have begun.
    begun: Once,
    stores: &'a Stores,
    queue: &'a Queue,
    turn: &'a WorkTurn,
    settings: RunSettings,
    room: Room,
    watch: &'a dyn RunWatch,
    /// The first error that ends the work.
    trouble: Mutex<Option<RunError>>,
    /// The first error of a packing or grid, which does not.
    failure: Mutex<Option<RunError>>,
    /// How often a thread found nothing to do.
    waits: AtomicUsize,
    /// Others are in another round already.
    overtaken: AtomicBool,
}

impl<'a> Worker<'a> {
    fn new(
        (sweep, folder): (&'a Sweep, &'a OutputFolder),
        (stores, queue): (&'a Stores, &'a Queue),
        turn: &'a WorkTurn,
        (settings, room): (RunSettings, Room),
        watch: &'a dyn RunWatch,
    ) -> Self {
        let prefix = |name: &str| if name.is_empty() { String::new() } else { format!("{name}: ") };
        Self {
            sweep,
            prefixes: sweep.variants.iter().map(|variant| prefix(&variant.name)).collect(),
            folder,
            begun: Once::new(),
            stores,
            queue,
            turn,
            settings,
            room,
            watch,
            trouble: Mutex::default(),
            failure: Mutex::default(),
            waits: AtomicUsize::new(0),
            overtaken: AtomicBool::new(false),
        }
    }

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
                Ok(Assignment::Task(task)) if self.is_of_this_round(task) => return Some(task),
                Ok(Assignment::Task(task)) => {
                    self.overtaken.store(true, Ordering::Relaxed);
                    self.note(self.queue.give_back(task).map_err(RunError::from));
                    return None;
                }
                Ok(Assignment::Wait) => self.wait(),
                Ok(Assignment::Finished) => return None,
                Err(error) => self.note(Err(error)),
            }
        }
    }

    fn is_of_this_round(&self, task: usize) -> bool {
        (self.turn.first..self.turn.first + self.turn.jobs.len()).contains(&task)
    }

    fn wait(&self) {
        std::thread::sleep(WAIT);
        self.waits.fetch_add(1, Ordering::Relaxed);
    }

    /// Takes the results of earlier runs away before the first solve.
    fn begin(&self) {
        self.begun.call_once(|| self.note(self.folder.begin().map_err(RunError::from)));
    }

    fn go(&self, task: usize) -> Result<(), RunError> {
        match &self.turn.jobs[task - self.turn.first] {
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
        let first = self.named(variants[0], self.watch);
        let mut packings = Packings::new(&self.sweep.variants[variants[0]].study, &first);
        let mut cost = 0.0;
        for &v in variants {
            let named = self.named(v, self.watch);
            let work = self.work(v, 0, &named);
            if work.has_failed() {
                continue;
            }
            match work.resolve(&mut packings).map_err(RunError::stopped) {
                Ok(resolved) => cost += work.cost(&resolved),
                Err(RunError::Stopped) => return Ok(self.queue.give_back(task)?),
                Err(error) if is_failure(&error) => self.failed(&work, 0..work.study.realisations, error)?,
                Err(error) => return Err(error),
            }
        }
        self.queue.reckon(task, cost)?;
        Ok(self.queue.finish(task, 0, 0)?)
    }

    /// Solves a unit.
    fn unit(&self, task: usize, unit: &Unit) -> Result<(), RunError> {
        let news = News::new(self, task);
        let first = self.named(unit.variants[0], &news);
        let mut packings = Packings::new(&self.sweep.variants[unit.variants[0]].study, &first);
        let mut failed = 0;
        for &v in &unit.variants {
            if self.watch.stop() {
                break;
            }
            let named = self.named(v, &news);
            let work = self.work(v, unit.realisation, &named);
            failed += match work.go(&mut packings).map_err(RunError::stopped) {
                Ok(failed) => failed,
                Err(RunError::Stopped) => break,
                Err(error) if is_failure(&error) => {
                    self.failed(&work, unit.realisation..unit.realisation + 1, error)?;
                    work.drop_all()
                }
                Err(error) => return Err(error),
            };
        }
        if self.watch.stop() {
            return Ok(self.queue.give_back(task)?);
        }
        Ok(self.queue.finish(task, solves_of(self.sweep, unit), failed)?)
    }

    /// Records that realisations of a variant have no packing or no grid.
    fn failed(&self, work: &Work, realisations: Range<usize>, error: RunError) -> Result<(), RunError> {
        work.note_failure(realisations, &error)?;
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        Ok(())
    }

    fn named<'b>(&'b self, variant: usize, watch: &'b dyn RunWatch) -> NamedWatch<'b> {
        NamedWatch { prefix: &self.prefixes[variant], watch }
    }

    fn work<'b>(&'b self, variant: usize, realisation: usize, watch: &'b dyn RunWatch) -> Work<'b> {
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
