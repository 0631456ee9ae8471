//! Runs one study, the variants of a sweep, or one shard of them, alone or together with other
//! processes in the same folder.
//!
//! Workers (threads and processes) take units from a shared [`Queue`], most expensive first; the
//! grids of a group are chosen before its realisations. Every solve is stored before the next
//! begins. Failures are recorded and do not stop the rest; they are retried only with
//! `--retry-failed`, and by `inkwave run`.

mod work;

use super::rounds::Rounds;
use super::units::{Shard, Unit, ends_early, units};
use crate::run::crew::Crew;
use crate::run::realisation::Packings;
use crate::run::watch::{Event, RunWatch};
use crate::run::{RunError, RunSettings, Stores};
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::queue::{Assignment, Queue, QueueStanding, QueuedTask};
use crate::store::seal::Damage;
use crate::work::variant::{Variant, solved_for};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Once, OnceLock};
use std::time::Duration;
use work::{NamedWatch, News, Room, Work};

/// Interval at which an idle worker looks for work again.
const WAIT: Duration = Duration::from_millis(50);
/// Minimum time between two progress reports to other processes.
const BETWEEN_NEWS: Duration = Duration::from_millis(500);
/// Offset between the task numbers of consecutive rounds: more than any round has tasks.
const ROUND: usize = 1 << 32;
/// Cost that puts grids before all units.
const GRIDS_FIRST: f64 = 1e30;

/// Result of running them, over all workers of the folder.
#[derive(Debug)]
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
pub fn solves(variants: &[Variant], shard: Shard) -> usize {
    let variants = &*solved_for(variants);
    let units = units(variants);
    units[shard.range(units.len())].iter().map(|unit| solves_of(variants, unit)).sum()
}

fn solves_of(variants: &[Variant], unit: &Unit) -> usize {
    unit.variants.iter().map(|&v| variants[v].study.solves_of(unit.realisation)).sum()
}

/// Runs a shard in `folder` until it is finished or stopped.
///
/// # Errors
/// Records cannot be written, or threads cannot be started; failures of variants are recorded
/// instead.
pub fn run(
    variants: &[Variant],
    folder: &OutputFolder,
    extent: (Shard, Scope),
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Tally, RunError> {
    let solved = solved_for(variants);
    watch.hear(Event::Begun);
    let (shard, scope) = extent;
    let tally = run_to_end(&solved, folder, shard, scope, settings, watch);
    watch.hear(Event::Over);
    tally
}

fn run_to_end(
    variants: &[Variant],
    folder: &OutputFolder,
    shard: Shard,
    scope: Scope,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Tally, RunError> {
    let stores = Stores::open(folder)?;
    let queue = stores.database().queue(name(variants, shard, scope).as_str())?;
    if settings.retry_failed && queue.standing()?.workers == 1 {
        stores.failures.remove_all()?;
    }
    let mut rounds = Rounds::new(variants);
    let mut waits = 0;
    let mut before = None;
    let mut failure = None;
    while let Some((round, units)) = next_round(&mut rounds, &stores, watch) {
        let jobs = jobs(variants, &units[shard.range(units.len())], scope);
        // If the queue is empty but the round is unfinished, stop: repeating it would not help.
        if jobs.is_empty() || before == Some(round) {
            break;
        }
        let groups = jobs.iter().filter(|job| job.grids.is_none()).count();
        // units wait for their grids
        let crew = Crew::new(settings.jobs, groups.max(jobs.len() - groups))?;
        let worker = Worker {
            variants,
            folder,
            begun: Once::new(),
            stores: &stores,
            queue: &queue,
            first: round * ROUND,
            jobs,
            settings: RunSettings { jobs: Some(crew.jobs_each), ..settings },
            room: Room::new(settings.memory, crew.workers()),
            watch,
            trouble: OnceLock::new(),
            failure: OnceLock::new(),
            waits: AtomicUsize::new(0),
            overtaken: AtomicBool::new(false),
            panicked: AtomicBool::new(false),
        };
        queue.enlist(worker.first, &worker.jobs.iter().map(|job| job.task(variants)).collect::<Vec<_>>())?;
        // While the only grids are being chosen, nothing else can be done: all threads take part.
        if groups == 1
            && let Some(task) = worker.take()
        {
            worker.go(task);
        }
        crew.work_off(|| worker.take(), |task| worker.go(task));
        waits += worker.waits.into_inner();
        before = (!worker.overtaken.into_inner()).then_some(round);
        worker.trouble.into_inner().map_or(Ok(()), Err)?;
        failure = failure.or(worker.failure.into_inner());
        if watch.stop() || scope == Scope::Grids || !ends_early(variants) {
            break;
        }
        stores.database().refresh()?;
    }
    let QueueStanding { workers, solves: processed, failed, .. } = queue.standing()?;
    let publishes = if watch.stop() { workers == 1 } else { queue.publishes()? };
    let asked = solves(variants, shard);
    let finished = processed - failed;
    let known = rounds.known();
    let damages = stores.database().damages();
    let waited = WAIT * waits as u32;
    Ok(Tally { asked, finished, failed, publishes, damages, failure, waited, known })
}

/// The next round; whether one is needed may take an evaluation of what is stored.
fn next_round(rounds: &mut Rounds, stores: &Stores, watch: &dyn RunWatch) -> Option<(usize, Vec<Unit>)> {
    watch.hear(Event::Over);
    let next = rounds.next(stores);
    watch.hear(Event::Begun);
    next
}

/// Name of the work, so that only processes with the same studies and shard share it.
fn name(variants: &[Variant], shard: Shard, scope: Scope) -> Key {
    let studies: Vec<Key> = variants.iter().map(|variant| variant.study.key()).collect();
    Key::of("work", &(studies, shard.index, shard.count, scope))
}

/// State shared by the threads of a process in one round.
struct Worker<'a> {
    variants: &'a [Variant],
    folder: &'a OutputFolder,
    /// Set when the first solve begins.
    begun: Once,
    stores: &'a Stores,
    queue: &'a Queue,
    /// Number of the first task.
    first: usize,
    jobs: Vec<Job>,
    settings: RunSettings,
    room: Room,
    watch: &'a dyn RunWatch,
    /// The first error that ends the work.
    trouble: OnceLock<RunError>,
    /// The first failure of a packing or grid, which does not end the work.
    failure: OnceLock<RunError>,
    /// Number of times that a thread found no work.
    waits: AtomicUsize,
    /// Whether other processes have started another round.
    overtaken: AtomicBool,
    /// Whether a thread has panicked. Its task stays claimed as long as this process lives: the
    /// other threads must not wait for it.
    panicked: AtomicBool,
}

/// Tells the other threads if this one panics.
struct TellPanic<'a>(&'a AtomicBool);

impl Drop for TellPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.store(true, Ordering::Relaxed);
        }
    }
}

impl Worker<'_> {
    /// Claims the next task; `None` if there is none, or the run should stop.
    fn take(&self) -> Option<usize> {
        while !self.watch.stop() && self.trouble.get().is_none() && !self.panicked.load(Ordering::Relaxed) {
            let refreshed = self.stores.database().refresh().map_err(RunError::Store);
            match refreshed.and_then(|()| Ok(self.queue.claim()?)) {
                Ok(Assignment::Task(task)) if self.job(task).is_some() => return Some(task),
                Ok(Assignment::Task(task)) => {
                    self.overtaken.store(true, Ordering::Relaxed);
                    self.queue.give_back(task).unwrap_or_else(|error| self.note(error));
                    return None;
                }
                Ok(Assignment::Wait) => {
                    std::thread::sleep(WAIT);
                    self.waits.fetch_add(1, Ordering::Relaxed);
                }
                Ok(Assignment::Finished) => return None,
                Err(error) => self.note(error),
            }
        }
        None
    }

    /// The job of a task; `None` if it is of another round.
    fn job(&self, task: usize) -> Option<&Job> {
        self.jobs.get(task.checked_sub(self.first)?)
    }

    /// Removes earlier results before the first solve.
    fn begin(&self) {
        self.begun.call_once(|| self.folder.begin().unwrap_or_else(|error| self.note(error)));
    }

    /// Notes an error that ends the work.
    fn note(&self, error: impl Into<RunError>) {
        let _ = self.trouble.set(error.into());
    }

    fn go(&self, task: usize) {
        let _told = TellPanic(&self.panicked);
        if let Some(Err(error)) = self.job(task).map(|job| self.carry_out(task, job)) {
            self.note(error);
        }
    }

    /// Computes a unit; or chooses the grids of a group and sets the cost of its units.
    fn carry_out(&self, task: usize, Job { unit, grids }: &Job) -> Result<(), RunError> {
        let news = News::new(self, task);
        let work = |v: usize| {
            let Variant { name, study, .. } = &self.variants[v];
            let watch = NamedWatch { name, watch: &news };
            Work { worker: self, study, realisation: unit.realisation, watch }
        };
        let first = work(unit.variants[0]);
        let grid_source = first.study.grid_source();
        let packed = if grids.is_none() { &*grid_source } else { first.study };
        let mut packings = Packings::new(packed, &first.watch);
        let mut sum = 0;
        for &v in unit.variants.iter().take_while(|_| !self.watch.stop()) {
            let done = match grids {
                None => work(v).choose_grid(&mut packings),
                Some(_) => work(v).solve(&mut packings),
            };
            match done {
                Ok(count) => sum += count,
                Err(RunError::Stopped) => break,
                Err(error) => return Err(error),
            }
        }
        if self.watch.stop() {
            return Ok(self.queue.give_back(task)?);
        }
        if grids.is_some() {
            return Ok(self.queue.finish(task, solves_of(self.variants, unit), sum)?);
        }
        self.queue.reckon(task, sum as f64)?;
        Ok(self.queue.finish(task, 0, 0)?)
    }
}

/// A task: to compute a unit, or to choose the grids of a group.
struct Job {
    /// The unit; if grids are chosen, the first realisation of all variants whose grids are chosen
    /// on the same packings.
    pub unit: Unit,
    /// Number of the task that chooses the grids; `None` if this one does.
    pub grids: Option<usize>,
}

impl Job {
    pub fn task(&self, variants: &[Variant]) -> QueuedTask {
        let studies = self.unit.variants.iter().map(|v| &variants[*v].study);
        let cost = match self.grids {
            None => GRIDS_FIRST * studies.map(|study| study.volume_um3()).sum::<f64>(),
            // an estimate until the grid is known
            Some(_) => solves_of(variants, &self.unit) as f64,
        };
        QueuedTask { cost, after: self.grids }
    }
}

/// The choices of grids, followed by the units if these are to be solved. A choice serves all units
/// whose grids are chosen on the same packings: those of a group, and all slabs of a layer.
fn jobs(variants: &[Variant], units: &[Unit], scope: Scope) -> Vec<Job> {
    let mut packings_of_group: BTreeMap<usize, Key> = BTreeMap::new();
    let mut choices: BTreeMap<Key, BTreeSet<usize>> = BTreeMap::new();
    for unit in units {
        let packings_key = || variants[unit.variants[0]].study.grid_source().packings_key();
        let packings = packings_of_group.entry(unit.group).or_insert_with(packings_key);
        choices.entry(packings.clone()).or_default().extend(&unit.variants);
    }
    let mut jobs = Vec::new();
    for (group, chosen_for) in choices.values().enumerate() {
        let unit = Unit { group, variants: chosen_for.iter().copied().collect(), realisation: 0 };
        jobs.push(Job { unit, grids: None });
    }
    for unit in units.iter().filter(|_| scope == Scope::Solves) {
        let packings = &packings_of_group[&unit.group];
        jobs.push(Job { unit: unit.clone(), grids: choices.keys().position(|key| key == packings) });
    }
    jobs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::check::check;
    use crate::run::resolve;
    use crate::work::variant::of_one;
    use std::path::Path;

    fn composed(index: f64) -> Variant {
        let text = format!(
            "[layer]\nthickness_um = 4\nbinder.index = 1.5\n[layer.composed]\nslab_um = 1\n[[pigment]]\nname = 'p'\n\
             diameter_nm = 200\nvolume_fraction = 0.1\nindex = {index}\n[light]\nwavelengths_nm = [550]\n\
             [run]\nrealisations = 2\n"
        );
        let study = check(&toml::from_str(&text).expect("a study file"), Path::new("."), "test");
        of_one(&format!("{index}"), study.expect("a study")).remove(0)
    }

    /// *Planted*: every group chooses grids of its own.
    #[test]
    fn one_choice_of_grid_serves_all_slabs_of_a_layer() {
        let layers = [composed(2.0), composed(2.2)];
        let variants = solved_for(&layers);
        assert_eq!(variants.len(), 8, "inner and outer slabs, whole and halved");
        let keys: BTreeSet<_> = variants[..4].iter().map(|v| resolve::key(&v.study)).collect();
        assert_eq!(keys.len(), 1, "the slabs of a layer have one grid");
        let all = jobs(&variants, &units(&variants), Scope::Solves);
        let (choices, solves): (Vec<_>, Vec<_>) = all.iter().partition(|job| job.grids.is_none());
        // both layers have the same packings, and their grids are chosen on those of the first slab
        assert_eq!(choices.len(), 1);
        assert_eq!(choices[0].unit.variants, (0..8).collect::<Vec<_>>());
        assert_eq!(solves.len(), 8, "2 realisations of 4 groups");
        assert!(solves.iter().all(|job| job.grids == Some(0) && job.unit.variants.len() == 2));
    }
}
