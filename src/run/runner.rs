//! Carries a study out: for each realisation a packing and a coverage, for each wavelength and angle a solve.
//!
//! Every finished solve is in the store before the next begins, so a run that is stopped, or killed, leaves
//! what it finished, and the same study continues there. Solves that are in the store already, from whichever
//! study, are not repeated.

use super::realisation::{Packings, RealisationRun, point_keys};
use super::resolve;
use super::resolve::{Resolved, resolve};
use super::watch::RunWatch;
use crate::ink::PackError;
use crate::input::study::{Point, Study};
use crate::solve::accuracy::AccuracyError;
use crate::solve::demand::TooLarge;
use crate::store::Store;
use crate::store::damage::Damage;
use crate::store::database::Database;
use crate::store::folder::{FolderError, OutputFolder};
use crate::store::packing_record::PackingRecord;
use crate::store::queue::QueueError;
use crate::store::record::{FailureRecord, PointRecord};
use crate::wave::{Scene, WaveError};
use std::io;
use std::path::Path;
use std::sync::Arc;

/// How to run, as opposed to what.
#[derive(Clone, Copy, Debug)]
pub struct RunSettings {
    /// Most solves at a time; the number of threads when nothing is said. As many run as the memory holds.
    pub jobs: Option<usize>,
    /// Bytes that all solves at a time may take.
    pub memory: f64,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self { jobs: None, memory: super::memory::usable() }
    }
}

/// All that a run has, finished or not.
#[derive(Clone, Debug)]
pub struct Collected {
    /// The grid and what is known about its error.
    pub resolved: Resolved,
    /// All realisations, in their order.
    pub realisations: Vec<Realisation>,
    /// True when the wanted bar was reached before the last realisation asked for.
    pub enough: bool,
    /// What was found damaged in the store, and computed again as far as this study needs it.
    pub damages: Vec<Damage>,
}

/// One realisation's records, in the order of [`Study::points`]; `None` where a solve is missing.
#[derive(Clone, Debug)]
pub struct Realisation {
    /// How the grains were packed.
    pub packing: PackingRecord,
    /// One a solve, in the study's order; `None` where it is missing.
    pub points: Vec<Option<PointRecord>>,
    /// What failed, and why.
    pub failures: Vec<Failure>,
}

/// A solve that ended without a result.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The solve.
    pub point: Point,
    /// The error's message.
    pub reason: String,
}

/// Why a run ended without collecting anything.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A packing was not delivered.
    #[error("realisation {}: {source}", realisation + 1)]
    Packing {
        /// Number of the realisation, from 0.
        realisation: usize,
        /// Why.
        source: PackError,
    },
    /// No grid reaches the accuracy.
    #[error(transparent)]
    Resolution(#[from] AccuracyError),
    /// The work would not fit into memory.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The scene does not make a problem.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The folder of results.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A record could not be kept.
    #[error("cannot keep a result: {0}")]
    Store(#[from] io::Error),
    /// The queue of work.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// Threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Someone asked to stop; what is finished is kept.
    #[error("stopped before the first solve")]
    Stopped,
}

impl Collected {
    /// Solves that are there.
    pub fn finished(&self) -> usize {
        self.realisations.iter().map(|r| r.points.iter().flatten().count()).sum()
    }

    /// All failures of all realisations.
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
    run_until(study, folder, settings, watch, &|_| false)
}

/// Realisations between two looks at the bar.
const BATCH: usize = 8;

/// As [`run`], but ends as soon as `enough` says so, asked whenever a batch of realisations is finished.
///
/// # Errors
/// As [`run`].
pub fn run_until(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
    enough: &dyn Fn(&Collected) -> bool,
) -> Result<Collected, RunError> {
    let stores = Stores::open(folder)?;
    stores.database().prepare()?;
    let mut packings = Packings::new(study, watch);
    let scene = |r: usize| packings.get(r).map(|packing| Scene::from_packing(&packing));
    let resolved = resolve(study, &stores.grids, settings.memory, watch, scene).map_err(stopped)?;
    let keys = |realisation| point_keys(study, &resolved, realisation);
    let kept = (0..study.realisations).flat_map(keys).filter(|(_, key)| stores.points.has(key.as_str()));
    let kept = kept.count();
    if kept < study.solves() {
        folder.begin()?;
    }
    watch.begins(study, kept);
    let mut collected = Collected { resolved, realisations: Vec::new(), enough: false, damages: Vec::new() };
    for realisation in 0..study.realisations {
        collected.enough = realisation > 0 && realisation.is_multiple_of(BATCH) && enough(&collected);
        if collected.enough || watch.stop() && !collected.realisations.is_empty() {
            break;
        }
        let run =
            RealisationRun { study, resolved: &resolved, stores: &stores, settings, watch, realisation };
        match run.finish(&mut packings).map_err(stopped) {
            Err(RunError::Stopped) => break,
            result => collected.realisations.push(result?),
        }
    }
    if collected.realisations.is_empty() {
        return Err(RunError::Stopped);
    }
    Ok(Collected { damages: stores.database().damages(), ..collected })
}

/// A stop is no failure of packing or grid.
pub(crate) fn stopped(error: RunError) -> RunError {
    match error {
        RunError::Packing { source: PackError::Stopped { .. }, .. } => RunError::Stopped,
        RunError::Resolution(error) if resolve::is_stop(&error) => RunError::Stopped,
        other => other,
    }
}

pub(crate) struct Stores {
    database: Arc<Database>,
    pub points: Store<PointRecord>,
    pub packings: Store<PackingRecord>,
    pub grids: Store<Resolved>,
    /// Solves that have failed before and are not tried again; a study of its own tries them anew.
    pub failures: Option<Store<FailureRecord>>,
}

impl Stores {
    pub fn open(folder: &OutputFolder) -> io::Result<Self> {
        Self::at(folder.path())
    }

    /// The stores of a folder that is only read.
    pub fn at(path: &Path) -> io::Result<Self> {
        let database = Arc::new(Database::open(path)?);
        let (points, packings, grids) = (Store::of(&database), Store::of(&database), Store::of(&database));
        Ok(Self { points, packings, grids, failures: None, database })
    }

    /// The same, remembering failures.
    pub fn with_failures(self) -> Self {
        Self { failures: Some(Store::of(&self.database)), ..self }
    }

    /// What all of them are part of.
    pub fn database(&self) -> &Database {
        &self.database
    }
}
