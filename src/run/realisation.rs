//! One realisation of a run: its packing, its coverage, its solves.

use super::collected::{Failure, Realisation, RunError, RunSettings, Stores};
use super::crew::work_through;
use super::point::{PointError, is_physical, pack_realisation, solve_point};
use super::resolve;
use super::resolve::Resolved;
use super::watch::RunWatch;
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::Solver;
use crate::store::identity::Key;
use crate::store::packing_record::PackingRecord;
use crate::store::record::{FailureRecord, PointRecord};
use crate::wave::{Coverage, Mean, Resolution, Scene};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

/// Packings on demand; the first one serves the choice of the resolution too, and the latest one all studies
/// that share it.
pub(crate) struct Packings<'a> {
    study: &'a Study,
    watch: &'a dyn RunWatch,
    first: Option<Packing>,
    latest: Option<(usize, Packing)>,
    /// Of the realisation, grid and error that were last asked for: inks that share a packing share it too.
    coverage: Option<((usize, Resolution, f64), Arc<Coverage>)>,
}

impl<'a> Packings<'a> {
    pub fn new(study: &'a Study, watch: &'a dyn RunWatch) -> Self {
        Self { study, watch, first: None, latest: None, coverage: None }
    }

    pub fn get(&mut self, realisation: usize) -> Result<Packing, RunError> {
        match (&self.first, &self.latest) {
            (Some(first), _) if realisation == 0 => return Ok(first.clone()),
            (_, Some((latest, packing))) if *latest == realisation => return Ok(packing.clone()),
            _ => {}
        }
        self.watch.stage(&format!("packing realisation {}/{}", realisation + 1, self.study.realisations));
        let packing = pack_realisation(self.study, realisation, self.watch)
            .map_err(|source| RunError::Packing { realisation, source })?;
        if realisation == 0 {
            self.first = Some(packing.clone());
        } else {
            self.latest = Some((realisation, packing.clone()));
        }
        Ok(packing)
    }

    fn coverage(
        &mut self,
        realisation: usize,
        resolution: Resolution,
        error: f64,
    ) -> Result<Arc<Coverage>, RunError> {
        let asked = (realisation, resolution, error);
        if let Some((_, coverage)) = self.coverage.as_ref().filter(|(kept, _)| *kept == asked) {
            return Ok(coverage.clone());
        }
        self.coverage = None;
        let scene = Scene::from_packing(&self.get(realisation)?);
        let coverage = Arc::new(Coverage::within(&scene, resolution, error)?);
        self.coverage = Some((asked, coverage.clone()));
        Ok(coverage)
    }
}

/// The solves of a realisation with the content hashes of all that they depend on.
pub(crate) fn point_keys(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<(Point, Key)> {
    let packing = Key::of("packing", &study.packing_request(realisation));
    let resolution = resolved.for_cell(&study.draw(realisation));
    let key = |point: &Point| {
        let error = study.resolution.coverage_error();
        let method = (&resolution, Mean::default(), &study.solver, &study.goal, error);
        Key::of("point", &(&packing, study.indices(point.incidence.wavelength_um), &point.incidence, method))
    };
    study.points(realisation).into_iter().map(|point| (point, key(&point))).collect()
}

/// What one realisation needs.
pub(crate) struct RealisationRun<'a> {
    pub study: &'a Study,
    pub resolved: &'a Resolved,
    pub stores: &'a Stores,
    pub settings: RunSettings,
    pub watch: &'a dyn RunWatch,
    pub realisation: usize,
}

impl RealisationRun<'_> {
    /// Solves what the store lacks, and gives all records.
    pub fn finish(&self, packings: &mut Packings) -> Result<Realisation, RunError> {
        let keyed = point_keys(self.study, self.resolved, self.realisation);
        let mut points: Vec<Option<PointRecord>> =
            keyed.iter().map(|(_, key)| self.stores.points.get(key.as_str())).collect();
        for point in &mut points {
            *point = point.take().filter(|record| is_physical(record, self.resolved.grid_error));
        }
        let mut failures = Vec::new();
        let mut missing: Vec<usize> = (0..points.len()).filter(|&i| points[i].is_none()).collect();
        missing.retain(|&i| match self.failed_before(&keyed[i].1) {
            Some(reason) => {
                failures.push(Failure { point: keyed[i].0, reason });
                false
            }
            None => true,
        });
        self.watch.kept(self.study, points.len() - missing.len());
        let packing_key = Key::of("packing", &self.study.packing_request(self.realisation));
        let kept = self.stores.packings.get(packing_key.as_str());
        if let (true, Some(packing)) = (missing.is_empty(), kept) {
            return Ok(Realisation { packing, points, failures });
        }
        let packing = packings.get(self.realisation)?;
        let record = PackingRecord::new(self.realisation, &packing);
        self.stores.packings.put(packing_key.as_str(), &record)?;
        let resolution = self.resolved.for_cell(&self.study.draw(self.realisation));
        let todo: Vec<&(Point, Key)> = missing.iter().map(|&i| &keyed[i]).collect();
        let size = resolve::size(self.study, resolution);
        let solver = self.study.solver.build();
        let solver = size.admit(&*solver, self.settings.memory)?;
        let jobs = self.jobs(size.bytes(solver.solver()));
        let error = self.study.resolution.coverage_error();
        let coverage = packings.coverage(self.realisation, resolution, error)?;
        for (&i, result) in missing.iter().zip(self.solve_all(solver.solver(), jobs, &coverage, &todo)?) {
            match result {
                Some(Ok(point)) => points[i] = Some(point),
                Some(Err(reason)) => failures.push(self.note_failure(&keyed[i], reason)?),
                None => {}
            }
        }
        Ok(Realisation { packing: record, points, failures })
    }

    /// Solves at a time: as many as were asked for, and the memory holds.
    fn jobs(&self, bytes_each: f64) -> usize {
        let asked = self.settings.jobs.unwrap_or_else(rayon::current_num_threads);
        let fitting = (self.settings.memory / bytes_each) as usize;
        if fitting < asked {
            let most = 1e-9 * bytes_each;
            let held = fitting.max(1);
            self.watch
                .stage(&format!("{held} solves at a time instead of {asked}: each may take {most:.2} GB"));
        }
        asked.min(fitting.max(1))
    }

    fn failed_before(&self, key: &Key) -> Option<String> {
        Some(self.stores.failures.as_ref()?.get(key.as_str())?.reason)
    }

    fn note_failure(&self, (point, key): &(Point, Key), reason: String) -> io::Result<Failure> {
        if let Some(store) = &self.stores.failures {
            let (variant, realisation) = (self.study.title.clone(), point.realisation);
            let incidence = Some(point.incidence);
            store.put(
                key.as_str(),
                &FailureRecord { variant, realisation, incidence, reason: reason.clone() },
            )?;
        }
        Ok(Failure { point: *point, reason })
    }

    /// Solves side by side; `None` for those that a stop left out.
    fn solve_all(
        &self,
        solver: &dyn Solver,
        jobs: usize,
        coverage: &Arc<Coverage>,
        todo: &[&(Point, Key)],
    ) -> Result<Vec<Solved>, RunError> {
        let results: Vec<Mutex<Solved>> = todo.iter().map(|_| Mutex::new(None)).collect();
        let trouble: Mutex<Option<io::Error>> = Mutex::new(None);
        let stop = || self.watch.stop() || lock(&trouble).is_some();
        work_through(todo.len(), jobs, stop, |i| {
            let (point, key) = todo[i];
            match self.solve_one(solver, coverage, point, key) {
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
    fn solve_one(
        &self,
        solver: &dyn Solver,
        coverage: &Arc<Coverage>,
        point: &Point,
        key: &Key,
    ) -> io::Result<Solved> {
        self.watch.solving(self.study, point);
        let solved = solve_point(
            self.study,
            solver,
            coverage,
            point,
            self.resolved.grid_error,
            key.as_str(),
            self.watch,
        );
        self.watch.ended();
        match solved {
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
