//! What a run needs, and what it has in the end.

use super::resolve::Resolved;
use crate::input::study::Point;
use crate::store::Store;
use crate::store::damage::Damage;
use crate::store::database::Database;
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::packing_record::PackingRecord;
use crate::store::record::{FailureRecord, PointRecord};
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
    /// Tries again what has failed before, unless other processes are at work.
    pub retry_failed: bool,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self { jobs: None, memory: super::memory::usable(), retry_failed: false }
    }
}

/// All that a run has, finished or not.
#[derive(Clone, Debug)]
pub struct Collected {
    /// The grid and what is known about its error.
    pub resolved: Resolved,
    /// All realisations whose packings came about, in their order.
    pub realisations: Vec<Realisation>,
    /// The others.
    pub refused: Vec<Refused>,
    /// True when the wanted bar was reached before the last realisation asked for.
    pub enough: bool,
    /// What was found damaged in the store, and computed again as far as this study needs it.
    pub damages: Vec<Damage>,
}

/// One realisation's records, in the order of [`Study::points`](crate::input::study::Study::points); `None` where a solve is missing.
#[derive(Clone, Debug)]
pub struct Realisation {
    /// How the grains were packed.
    pub packing: PackingRecord,
    /// One a solve, in the study's order; `None` where it is missing.
    pub points: Vec<Option<PointRecord>>,
    /// What failed, and why.
    pub failures: Vec<Failure>,
}

/// A realisation whose grains found no room.
#[derive(Clone, Debug)]
pub struct Refused {
    /// Its number, from 0.
    pub realisation: usize,
    /// The error's message.
    pub reason: String,
}

/// A solve that ended without a result.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The solve.
    pub point: Point,
    /// The error's message.
    pub reason: String,
}

impl Collected {
    /// Solves that are there.
    pub fn finished(&self) -> usize {
        self.realisations.iter().map(|r| r.points.iter().flatten().count()).sum()
    }

    /// Realisations that were tried.
    pub fn tried(&self) -> usize {
        self.realisations.len() + self.refused.len()
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

/// What a folder keeps, one store a kind of record.
pub struct Stores {
    database: Arc<Database>,
    /// Solves.
    pub points: Store<PointRecord>,
    /// Packings.
    pub packings: Store<PackingRecord>,
    /// Grids that were searched.
    pub grids: Store<Resolved>,
    /// Solves, packings and grids that have failed, and are not tried again before that is asked.
    pub failures: Store<FailureRecord>,
}

impl Stores {
    /// The stores of a folder that is written to.
    pub fn open(folder: &OutputFolder) -> io::Result<Self> {
        Self::at(folder.path())
    }

    /// The stores of a folder that is only read.
    pub fn at(path: &Path) -> io::Result<Self> {
        let database = Arc::new(Database::open(path)?);
        let (points, packings) = (Store::of(&database), Store::of(&database));
        let (grids, failures) = (Store::of(&database), Store::of(&database));
        Ok(Self { points, packings, grids, failures, database })
    }

    /// How a solve has failed before; `None` where it has not.
    pub fn failure(&self, (point, key): &(Point, Key)) -> Option<Failure> {
        let record = self.failures.get(key.as_str())?;
        Some(Failure { point: *point, reason: record.reason })
    }

    /// What all of them are part of.
    pub fn database(&self) -> &Database {
        &self.database
    }
}
