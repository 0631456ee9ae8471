//! The inputs and outputs of a run.

use super::resolve::Resolved;
use super::watch::RunWatch;
use crate::input::study::{Point, Study};
use crate::solve::Size;
use crate::solve::Solver;
use crate::solve::demand::{Admitted, TooLarge};
use crate::store::{
    Damage, Database, FailureRecord, Key, OutputFolder, PackingRecord, PointRecord, Record, Store,
};
use std::io;
use std::path::Path;
use std::sync::Arc;

/// How to run, as opposed to what to compute.
#[derive(Clone, Copy, Debug)]
pub struct RunSettings {
    /// Maximum number of parallel solves, as far as the memory suffices (default: number of
    /// threads).
    pub jobs: Option<usize>,
    /// Memory for all parallel solves, bytes.
    pub memory: f64,
    /// Retry what failed before, unless other processes are working.
    pub retry_failed: bool,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self { jobs: None, memory: super::memory::usable(), retry_failed: false }
    }
}

impl RunSettings {
    /// The strategy with its share of the memory, into which it may grow, and the number of
    /// parallel solves: as requested, as far as the memory suffices. Each solve holds `systems`
    /// problems.
    pub(super) fn admit<'s>(
        &self,
        size: &Size,
        solver: &'s dyn Solver,
        systems: f64,
        watch: &dyn RunWatch,
    ) -> Result<(Admitted<'s>, usize), TooLarge> {
        let memory = self.memory / systems;
        let bytes_each = systems * size.admit(solver, memory)?.bytes;
        let requested = self.jobs.unwrap_or_else(rayon::current_num_threads).max(1);
        let jobs = requested.min((self.memory / bytes_each) as usize).max(1);
        if jobs < requested {
            let most = 1e-9 * bytes_each;
            watch.stage(&format!(
                "{jobs} solves at a time instead of {requested}: each may take {most:.2} GB"
            ));
        }
        Ok((size.admit(solver, memory / jobs as f64)?, jobs))
    }
}

/// Everything a run has computed, finished or not.
#[derive(Clone, Debug)]
pub struct Collected {
    /// The grid and its error.
    pub resolved: Resolved,
    /// All realisations that could be packed, in order.
    pub realisations: Vec<Realisation>,
    /// The realisations without a packing or a grid.
    pub refused: Vec<Refused>,
    /// True if `run.target_delta_e` was reached before the last realisation.
    pub enough: bool,
    /// What is computed of the parts of a stack, in the order of [`Study::substacks`]; `None` of
    /// those without a packing and a grid, and empty where none are asked for.
    pub substacks: Vec<Option<Collected>>,
    /// Damage found in the store; what this study needs has been recomputed.
    pub damages: Vec<Damage>,
}

/// The solves of a few realisations as they are, and with tables of indices moved by their errors.
#[derive(Clone, Debug)]
pub struct MovedSolves {
    /// As they are.
    pub unmoved: Collected,
    /// \[move\] ([`Study::input_moves`](crate::input::study::Study::input_moves))
    pub moved: Vec<Collected>,
}

/// Records of one realisation.
#[derive(Clone, Debug)]
pub struct Realisation {
    /// The packing.
    pub packing: PackingRecord,
    /// One record per solve, in the order of [`Study::points`](crate::input::study::Study::points);
    /// `None` if it is missing.
    pub points: Vec<Option<PointRecord>>,
    /// These solves on the finer grid ([`Study::is_checked`]); empty if there are none.
    ///
    /// [`Study::is_checked`]: crate::input::study::Study::is_checked
    pub finer: Vec<Option<PointRecord>>,
    /// These solves with the tables of indices moved by their errors, move by move
    /// ([`Study::moves_of`]).
    ///
    /// [`Study::moves_of`]: crate::input::study::Study::moves_of
    pub moved: Vec<Vec<Option<PointRecord>>>,
    /// Failed solves with their reasons.
    pub failures: Vec<Failure>,
}

/// A realisation without a packing or a grid.
#[derive(Clone, Debug)]
pub struct Refused {
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// The error's message.
    pub reason: String,
}

/// A solve without a result.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The solve.
    pub point: Point,
    /// The error's message.
    pub reason: String,
}

impl Collected {
    /// Number of finished solves, those of parts of a stack included.
    pub fn finished(&self) -> usize {
        self.own_finished() + self.substacks.iter().flatten().map(Self::finished).sum::<usize>()
    }

    /// Number of finished solves of the layer or stack itself.
    fn own_finished(&self) -> usize {
        let solves = |r: &Realisation| {
            r.points.iter().chain(&r.finer).chain(r.moved.iter().flatten()).flatten().count()
        };
        self.realisations.iter().map(solves).sum()
    }

    /// Number of the study's solves that are not needed: those of packings without room, and all
    /// that are left once the target is reached.
    pub fn spared(&self, study: &Study) -> usize {
        let refused: usize = self.refused.iter().map(|refused| study.solves_of(refused.realisation)).sum();
        let own = if self.enough { study.own_solves() - self.own_finished() } else { refused };
        let parts = study.substacks().into_iter().zip(&self.substacks);
        let of_parts = parts.filter_map(|(part, solved)| Some(solved.as_ref()?.spared(&part.study)));
        own + of_parts.sum::<usize>()
    }

    /// Records of all solves, those of parts of a stack included.
    pub fn records(&self) -> Vec<&PointRecord> {
        let own = self.realisations.iter().flat_map(|r| r.points.iter().flatten());
        own.chain(self.substacks.iter().flatten().flat_map(Self::records)).collect()
    }

    /// The failures of all realisations.
    pub fn failures(&self) -> impl Iterator<Item = &Failure> {
        self.realisations.iter().flat_map(|r| &r.failures)
    }

    /// The solves of the realisations that are finished with all of these `moves` of tables, too;
    /// `None` without any.
    pub fn moved_solves(&self, moves: usize) -> Option<MovedSolves> {
        let is_finished = |points: &Vec<Option<PointRecord>>| points.iter().all(Option::is_some);
        let is_complete = |r: &&Realisation| r.moved.len() == moves && r.moved.iter().all(is_finished);
        let few: Vec<&Realisation> = self.complete().filter(is_complete).collect();
        if moves == 0 || few.is_empty() {
            return None;
        }
        let with = |points: &dyn Fn(&Realisation) -> Vec<Option<PointRecord>>| {
            let realisation = |r: &&Realisation| Realisation {
                packing: r.packing.clone(),
                points: points(r),
                finer: Vec::new(),
                moved: Vec::new(),
                failures: Vec::new(),
            };
            Collected {
                resolved: self.resolved,
                realisations: few.iter().map(realisation).collect(),
                refused: Vec::new(),
                enough: false,
                substacks: Vec::new(),
                damages: Vec::new(),
            }
        };
        Some(MovedSolves {
            unmoved: with(&|r| r.points.clone()),
            moved: (0..moves).map(|i| with(&|r| r.moved[i].clone())).collect(),
        })
    }

    /// Realisations in which every solve is finished.
    pub fn complete(&self) -> impl Iterator<Item = &Realisation> {
        self.realisations.iter().filter(|r| r.points.iter().all(Option::is_some))
    }
}

/// The records of a folder, one store per kind.
pub struct Stores {
    database: Arc<Database>,
    /// Solves.
    pub points: Store<PointRecord>,
    /// Packings.
    pub packings: Store<PackingRecord>,
    /// Chosen grids.
    pub grids: Store<Resolved>,
    /// Failed solves, packings and grids; they are retried only on request.
    pub failures: Store<FailureRecord>,
}

impl Stores {
    /// Opens the stores of a folder for writing.
    pub fn open(folder: &OutputFolder) -> io::Result<Self> {
        Self::at(folder.path())
    }

    /// Opens the stores of a folder for reading.
    pub fn at(path: &Path) -> io::Result<Self> {
        let database = Arc::new(Database::open(path)?);
        let points = Store::of(&database);
        let packings = Store::of(&database);
        let grids = Store::of(&database);
        let failures = Store::of(&database);
        Ok(Self { points, packings, grids, failures, database })
    }

    /// The recorded failure of a solve; `None` if it has not failed.
    pub fn failure(&self, (point, key): &(Point, Key)) -> Option<Failure> {
        Some(Failure { point: *point, reason: self.failures.get(key.as_str())?.reason })
    }

    /// Records of another kind in the same database.
    pub fn of<R: Record>(&self) -> Store<R> {
        Store::of(&self.database)
    }

    /// The database that holds all stores.
    pub fn database(&self) -> &Database {
        &self.database
    }
}
