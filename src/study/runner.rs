//! Carries a study out: for each realisation a packing and a coverage, for each wavelength and angle a solve.
//!
//! Every finished solve is in the store before the next begins, so a run that is stopped, or killed, leaves
//! what it finished, and the same study continues there. Solves that are in the store already, from whichever
//! study, are not repeated.

use super::checked::{Point, Study};
use super::crew::work_through;
use super::identity::Key;
use super::optics::{PointError, pack_realisation, solve_point};
use super::resolve::{self, Resolved, resolve};
use super::watch::RunWatch;
use crate::ink::{PackError, Packing};
use crate::report::folder::{FolderError, GRIDS, OutputFolder, PACKINGS, POINTS};
use crate::report::packing_record::PackingRecord;
use crate::report::record::PointRecord;
use crate::report::store::Store;
use crate::solve::accuracy::AccuracyError;
use crate::wave::{Coverage, Mean, Scene, WaveError};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

/// How to run, as opposed to what.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunSettings {
    /// Solves at a time; the number of threads when nothing is said. Fewer need less memory.
    pub jobs: Option<usize>,
}

/// All that a run has, finished or not.
#[derive(Clone, Debug)]
pub struct Collected {
    pub resolved: Resolved,
    pub realisations: Vec<Realisation>,
}

/// One realisation's records, in the order of [`Study::points`]; `None` where a solve is missing.
#[derive(Clone, Debug)]
pub struct Realisation {
    pub packing: PackingRecord,
    pub points: Vec<Option<PointRecord>>,
    pub failures: Vec<Failure>,
}

/// A solve that ended without a result.
#[derive(Clone, Debug)]
pub struct Failure {
    pub point: Point,
    pub reason: String,
}

/// Why a run ended without collecting anything.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error("realisation {}: {source}", realisation + 1)]
    Packing { realisation: usize, source: PackError },
    #[error(transparent)]
    Resolution(#[from] AccuracyError),
    #[error(transparent)]
    Wave(#[from] WaveError),
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error("cannot keep a result: {0}")]
    Store(#[from] io::Error),
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    #[error("stopped before the first solve")]
    Stopped,
}

impl Collected {
    /// Solves that are there.
    pub fn finished(&self) -> usize {
        self.realisations.iter().map(|r| r.points.iter().flatten().count()).sum()
    }

    pub fn failures(&self) -> impl Iterator<Item = &Failure> {
        self.realisations.iter().flat_map(|r| &r.failures)
    }

    /// Realisations of which every solve is there.
    pub fn complete(&self) -> impl Iterator<Item = &Realisation> {
        self.realisations.iter().filter(|r| r.points.iter().all(Option::is_some))
    }
}

/// Runs `study` into `folder` until it is finished, stopped, or nothing more can be done.
///
/// # Errors
/// The first packing or the resolution fails, or records cannot be written. A solve that fails is kept as a
/// [`Failure`] and does not stop the others.
pub fn run(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Collected, RunError> {
    let stores = Stores::open(folder)?;
    let mut packings = Packings { study, watch, first: None };
    let scene = || packings.get(0).map(|packing| Scene::from_packing(&packing));
    let resolved = resolve(study, &stores.grids, watch, scene).map_err(stopped)?;
    let keys = |realisation| point_keys(study, &resolved, realisation);
    let kept = (0..study.realisations).flat_map(keys).filter(|(_, key)| stores.points.has(key.as_str()));
    watch.begins(study, kept.count());
    let mut realisations = Vec::new();
    for realisation in 0..study.realisations {
        if watch.stop() && !realisations.is_empty() {
            break;
        }
        let run =
            RealisationRun { study, resolved: &resolved, stores: &stores, settings, watch, realisation };
        match run.finish(&mut packings).map_err(stopped) {
            Err(RunError::Stopped) => break,
            result => realisations.push(result?),
        }
    }
    if realisations.is_empty() { Err(RunError::Stopped) } else { Ok(Collected { resolved, realisations }) }
}

/// A stop is no failure of packing or grid.
fn stopped(error: RunError) -> RunError {
    match error {
        RunError::Packing { source: PackError::Stopped { .. }, .. } => RunError::Stopped,
        RunError::Resolution(error) if resolve::is_stop(&error) => RunError::Stopped,
        other => other,
    }
}

struct Stores {
    points: Store<PointRecord>,
    packings: Store<PackingRecord>,
    grids: Store<Resolved>,
}

impl Stores {
    fn open(folder: &OutputFolder) -> io::Result<Self> {
        let open = |name| folder.path().join(name);
        Ok(Self {
            points: Store::open(open(POINTS))?,
            packings: Store::open(open(PACKINGS))?,
            grids: Store::open(open(GRIDS))?,
        })
    }
}

/// Packings on demand; the first one serves the choice of the resolution too.
struct Packings<'a> {
    study: &'a Study,
    watch: &'a dyn RunWatch,
    first: Option<Packing>,
}

impl Packings<'_> {
    fn get(&mut self, realisation: usize) -> Result<Packing, RunError> {
        if let (0, Some(first)) = (realisation, &self.first) {
            return Ok(first.clone());
        }
        self.watch.stage(&format!("packing realisation {}/{}", realisation + 1, self.study.realisations));
        let packing = pack_realisation(self.study, realisation, self.watch)
            .map_err(|source| RunError::Packing { realisation, source })?;
        if realisation == 0 {
            self.first = Some(packing.clone());
        }
        Ok(packing)
    }
}

/// The solves of a realisation with the content hashes of all that they depend on.
fn point_keys(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<(Point, Key)> {
    let packing = Key::of("packing", &study.packing_request(realisation));
    let key = |point: &Point| {
        let method = (&resolved.resolution, Mean::default(), &study.solver, &study.goal);
        Key::of("point", &(&packing, study.indices(point.wavelength), &point.incidence, method))
    };
    study.points(realisation).into_iter().map(|point| (point, key(&point))).collect()
}

struct RealisationRun<'a> {
    study: &'a Study,
    resolved: &'a Resolved,
    stores: &'a Stores,
    settings: RunSettings,
    watch: &'a dyn RunWatch,
    realisation: usize,
}

impl RealisationRun<'_> {
    fn finish(&self, packings: &mut Packings) -> Result<Realisation, RunError> {
        let keyed = point_keys(self.study, self.resolved, self.realisation);
        let mut points: Vec<Option<PointRecord>> =
            keyed.iter().map(|(_, key)| self.stores.points.get(key.as_str())).collect();
        let missing: Vec<usize> = (0..points.len()).filter(|&i| points[i].is_none()).collect();
        let packing_key = Key::of("packing", &self.study.packing_request(self.realisation));
        let kept = self.stores.packings.get(packing_key.as_str());
        if let (true, Some(packing)) = (missing.is_empty(), kept) {
            return Ok(Realisation { packing, points, failures: Vec::new() });
        }
        let packing = packings.get(self.realisation)?;
        let record = PackingRecord::new(self.realisation, &packing);
        self.stores.packings.put(packing_key.as_str(), &record)?;
        let todo: Vec<&(Point, Key)> = missing.iter().map(|&i| &keyed[i]).collect();
        let mut failures = Vec::new();
        for (&i, result) in missing.iter().zip(self.solve_all(&packing, &todo)?) {
            match result {
                Some(Ok(point)) => points[i] = Some(point),
                Some(Err(reason)) => failures.push(Failure { point: keyed[i].0, reason }),
                None => {}
            }
        }
        Ok(Realisation { packing: record, points, failures })
    }

    /// Solves side by side; `None` for those that a stop left out.
    fn solve_all(&self, packing: &Packing, todo: &[&(Point, Key)]) -> Result<Vec<Solved>, RunError> {
        let coverage = Arc::new(Coverage::new(&Scene::from_packing(packing), self.resolved.resolution)?);
        let results: Vec<Mutex<Solved>> = todo.iter().map(|_| Mutex::new(None)).collect();
        let trouble: Mutex<Option<io::Error>> = Mutex::new(None);
        let jobs = self.settings.jobs.unwrap_or_else(rayon::current_num_threads);
        let stop = || self.watch.stop() || lock(&trouble).is_some();
        work_through(todo.len(), jobs, stop, |i| {
            let (point, key) = todo[i];
            match self.solve_one(&coverage, point, key) {
                Ok(solved) => *lock(&results[i]) = solved,
                Err(error) => *lock(&trouble) = Some(error),
            }
        })?;
        match trouble.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(RunError::Store(error)),
            None => Ok(results
                .into_iter()
                .map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner))
                .collect()),
        }
    }

    /// One solve, in the store when it returns. The error is the store's alone.
    fn solve_one(&self, coverage: &Arc<Coverage>, point: &Point, key: &Key) -> io::Result<Solved> {
        self.watch.solving(self.study, point);
        match solve_point(self.study, coverage, point, key.as_str(), self.watch) {
            Ok(record) => {
                self.stores.points.put(key.as_str(), &record)?;
                self.watch.solved(self.study, point, None);
                Ok(Some(Ok(record)))
            }
            Err(error) if PointError::is_stop(&error) => Ok(None),
            Err(error) => {
                let reason = error.to_string();
                self.watch.solved(self.study, point, Some(&reason));
                Ok(Some(Err(reason)))
            }
        }
    }
}

/// A record, the reason why there is none, or nothing when the run was stopped before.
type Solved = Option<Result<PointRecord, String>>;

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
