//! Runs a sweep or one shard of it, alone or together with other processes in the same folder.
//!
//! Workers (threads and processes) take units from a shared [`Queue`], most expensive first; the
//! grids of a group are chosen before its realisations. Every solve is stored before the next
//! begins. Failures are recorded and do not stop the rest; they are retried only with
//! `--retry-failed`, and by `inkwave run`.

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

/// Interval at which an idle worker looks for work again.
const WAIT: Duration = Duration::from_millis(50);
/// Minimum time between two progress reports to other processes.
const BETWEEN_NEWS: Duration = Duration::from_millis(500);
/// Offset between the task numbers of consecutive rounds: more than any round has tasks.
const ROUND: usize = 1 << 32;
/// Cost that puts grids before all units.
const GRIDS_FIRST: f64 = 1e30;

/// Result of running a sweep, over all workers of the folder.
#[derive(Debug, Default)]
pub struct Tally {
    /// Number of solves of the shard; shared solves count once per variant.
    pub asked: usize,
    /// Number of finished solves.
    pub finished: usize,
    /// Number of solves without a result.
    pub failed: usize,
    /// Whether this process has to write the report.
    pub publishes: bool,
    /// Damage that this process found in the store.
    pub damages: Vec<Damage>,
    /// The first failure of a packing or grid in this process.
    pub failure: Option<RunError>,
    /// Total time that threads of this process waited for others.
    pub waited: Duration,
    /// The number of realisations with which each variant is known to miss its target.
    pub known: Vec<usize>,
}

/// Extent of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Scope {
    /// Only choose the grids.
    Grids,
    /// Choose the grids and solve.
    Solves,
}

/// Number of solves of a shard; shared solves count once per variant.
pub fn solves(sweep: &Sweep, shard: Shard) -> usize {
    let units = units(sweep);
    units[shard.range(units.len())].iter().map(|unit| solves_of(sweep, unit)).sum()
}

fn solves_of(sweep: &Sweep, unit: &Unit) -> usize {
    unit.variants.iter().map(|&v| sweep.variants[v].study.solves_of(unit.realisation)).sum()
}

/// Runs a shard in `folder` until it is finished or stopped.
///
/// # Errors
/// Records cannot be written, or threads cannot be started; failures of variants are recorded
/// instead.
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
        // If the queue is empty but the round is unfinished, stop: repeating it would not help.
        let Some(turn) = WorkTurn::new((round, units), scope).filter(|_| before != Some(round)) else {
            break;
        };
        let crew = Crew::new(settings.jobs, turn.at_a_time())?;
        let room = Room::new(settings.memory, crew.workers());
        let settings = RunSettings { jobs: Some(crew.jobs_each), ..settings };
        let worker = Worker::new((sweep, folder), (&stores, &queue), &turn, (settings, room), watch);
        queue.enlist(turn.first, &turn.tasks(sweep))?;
        // While the only grids are being chosen, nothing else can be done: all threads take part.
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
    let (asked, known) = (solves(sweep, shard), rounds.known());
    Ok(Tally { asked, damages, failure, waited, known, ..tally(&queue, watch.stop())? })
}

fn tally(queue: &Queue, stopped: bool) -> Result<Tally, RunError> {
    let QueueStanding { workers, solves, failed, .. } = queue.standing()?;
    let publishes = if stopped { workers == 1 } else { queue.publishes()? };
    Ok(Tally { finished: solves - failed, failed, publishes, ..Tally::default() })
}

fn taken<T>(mutex: Mutex<Option<T>>) -> Option<T> {
    mutex.into_inner().unwrap_or_else(PoisonError::into_inner)
}

/// The jobs of a round, and the number of its first task.
struct WorkTurn {
    first: usize,
    jobs: Vec<Job>,
}

impl WorkTurn {
    /// `None` if there are no jobs.
    fn new((round, units): (usize, &[Unit]), scope: Scope) -> Option<Self> {
        let mut jobs = jobs(units);
        jobs.retain(|job| scope == Scope::Solves || matches!(job, Job::Grids(_)));
        (!jobs.is_empty()).then_some(Self { first: round * ROUND, jobs })
    }

    /// Number of groups whose grids are chosen.
    fn groups(&self) -> usize {
        self.jobs.iter().filter(|job| matches!(job, Job::Grids(_))).count()
    }

    /// Maximum number of concurrent tasks: units wait for their grids.
    fn at_a_time(&self) -> usize {
        self.groups().max(self.jobs.len() - self.groups())
    }

    fn tasks(&self, sweep: &Sweep) -> Vec<QueuedTask> {
        self.jobs.iter().map(|job| job.task(sweep)).collect()
    }
}

/// Name of the work, so that only processes with the same sweep and shard share it.
fn name(sweep: &Sweep, shard: Shard, scope: Scope) -> Key {
    let studies: Vec<Key> = sweep.variants.iter().map(|variant| variant.study.key()).collect();
    Key::of("work", &(studies, shard.index, shard.count, scope))
}

/// State shared by the threads of a process.
struct Worker<'a> {
    sweep: &'a Sweep,
    /// Prefixes of the stages of each variant.
    prefixes: Vec<String>,
    folder: &'a OutputFolder,
    /// Set when the first solve begins.
    begun: Once,
    stores: &'a Stores,
    queue: &'a Queue,
    turn: &'a WorkTurn,
    settings: RunSettings,
    room: Room,
    watch: &'a dyn RunWatch,
    /// The first error that ends the work.
    trouble: Mutex<Option<RunError>>,
    /// The first failure of a packing or grid, which does not end the work.
    failure: Mutex<Option<RunError>>,
    /// Number of times that a thread found no work.
    waits: AtomicUsize,
    /// Whether other processes have started another round.
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

    /// Claims the next task; `None` if there is none, or the run should stop.
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

    /// Removes earlier results before the first solve.
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

    /// Chooses the grids of a group and sets the cost of its units.
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

    /// Computes a unit.
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
