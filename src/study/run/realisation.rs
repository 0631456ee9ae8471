//! One realisation of a run: its packing, its coverage, its solves.

use super::collected::{Failure, Realisation, RunSettings, Stores};
use super::crew::work_through;
use super::error::RunError;
use super::grids::{Grids, Wavelength};
use super::point::{PointError, PointSolver, is_physical, pack_realisation};
use super::resolve;
use super::resolve::Resolved;
use super::watch::RunWatch;
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::Solver;
use crate::store::identity::Key;
use crate::store::packing_record::PackingRecord;
use crate::store::record::{FailureRecord, PointRecord};
use crate::wave::{Geometry, Mean, Precision, Resolution, Scene, System, Wave};
use std::io;
use std::sync::{Mutex, PoisonError};

/// Packings on demand; the first one serves the choice of the resolution too, and the latest one all studies
/// that share it.
pub struct Packings<'a> {
    study: &'a Study,
    watch: &'a dyn RunWatch,
    first: Option<Packing>,
    latest: Option<(usize, Packing)>,
    /// Of the latest realisation, by wave (vector or not), grid and error: inks that share a packing
    /// share them too, and so do their waves that take turns.
    geometries: Vec<((bool, usize, Resolution, f64), Geometry)>,
}

impl<'a> Packings<'a> {
    /// No packing yet.
    pub fn new(study: &'a Study, watch: &'a dyn RunWatch) -> Self {
        Self { study, watch, first: None, latest: None, geometries: Vec::new() }
    }

    /// The packing of a realisation, made where it is not at hand.
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

    fn geometry(
        &mut self,
        wave: Wave,
        realisation: usize,
        resolution: Resolution,
        error: f64,
    ) -> Result<Geometry, RunError> {
        let asked = (wave.is_vector(), realisation, resolution, error);
        if let Some((_, geometry)) = self.geometries.iter().find(|(kept, _)| *kept == asked) {
            return Ok(geometry.clone());
        }
        // Those of another realisation are of no use any more.
        self.geometries.retain(|((_, r, ..), _)| *r == realisation);
        let scene = Scene::from_packing(&self.get(realisation)?);
        let stop = || self.watch.stop();
        let geometry = Geometry::new(wave, &scene, resolution, Precision { error, stop: &stop })?;
        self.geometries.push((asked, geometry.clone()));
        Ok(geometry)
    }
}

/// The solves of a realisation with the content hashes of all that they depend on.
pub fn point_keys(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<(Point, Key)> {
    let packing = Key::of_packing(&study.packing_request(realisation));
    let draw = study.draw(realisation);
    let key = |point: &Point| {
        let resolution = resolved.for_wave(study, &draw, point.incidence.wavelength_um);
        point_key(study, &packing, &resolution, point)
    };
    study.points(realisation).into_iter().map(|point| (point, key(&point))).collect()
}

/// Content hash of all that one solve depends on.
fn point_key(study: &Study, packing: &Key, resolution: &Resolution, point: &Point) -> Key {
    let error = study.resolution.coverage_error();
    let method = (resolution, Mean::default(), &study.solver, &study.goal, error);
    let indices = study.indices(point.incidence.wavelength_um);
    Key::of_wave("point", &(packing, indices, &point.incidence, method), point.polarisation)
}

/// What one realisation needs.
pub struct RealisationRun<'a> {
    /// What is asked.
    pub study: &'a Study,
    /// On which grids.
    pub resolved: &'a Resolved,
    /// Where results go.
    pub stores: &'a Stores,
    /// How it is carried out.
    pub settings: RunSettings,
    /// Who is told of the work.
    pub watch: &'a dyn RunWatch,
    /// Which one, from 0.
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
        let (mut missing, mut failures) = (Vec::new(), Vec::new());
        for i in (0..points.len()).filter(|&i| points[i].is_none()) {
            match self.stores.failure(&keyed[i]) {
                Some(failure) => failures.push(failure),
                None => missing.push(i),
            }
        }
        self.watch.kept(self.study, points.len() - missing.len());
        let packing_key = Key::of_packing(&self.study.packing_request(self.realisation));
        let kept = self.stores.packings.get(packing_key.as_str());
        if let (true, Some(packing)) = (missing.is_empty(), kept) {
            return Ok(Realisation { packing, points, failures });
        }
        let packing = packings.get(self.realisation)?;
        let record = PackingRecord::new(self.realisation, &packing);
        self.stores.packings.put(packing_key.as_str(), &record)?;
        let finest = self.resolved.for_cell(&self.study.draw(self.realisation));
        let todo: Vec<&(Point, Key)> = missing.iter().map(|&i| &keyed[i]).collect();
        let size = resolve::size(self.study, finest);
        let solver = self.study.solver.build();
        let jobs = self.jobs(size.admit(&*solver, self.settings.memory)?.bytes);
        let solver = size.admit(&*solver, self.settings.memory / jobs as f64)?;
        let grids = Grids::new(self.study, &packing, self.geometries(packings, &todo)?);
        for (&i, result) in missing.iter().zip(self.solve_all(solver.solver(), jobs, &grids, &todo)?) {
            match result {
                Some(Ok(point)) => points[i] = Some(point),
                Some(Err(reason)) => failures.push(self.note_failure(&keyed[i], reason)?),
                None => {}
            }
        }
        Ok(Realisation { packing: record, points, failures })
    }

    /// The packing on the grids of all these solves.
    fn geometries(
        &self,
        packings: &mut Packings,
        todo: &[&(Point, Key)],
    ) -> Result<Vec<Wavelength>, RunError> {
        let (study, draw) = (self.study, self.study.draw(self.realisation));
        let waves = todo.iter().map(|(point, _)| point.incidence.wavelength_um);
        let grid = |wavelength_um: f64| self.resolved.for_wave(study, &draw, wavelength_um);
        let error = study.resolution.coverage_error();
        Wavelength::all(waves, grid, |resolution| {
            packings.geometry(study.wave, self.realisation, resolution, error)
        })
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

    /// Solves side by side, those of one problem after one another; `None` for those that a stop left out.
    fn solve_all(
        &self,
        solver: &dyn Solver,
        jobs: usize,
        grids: &Grids,
        todo: &[&(Point, Key)],
    ) -> Result<Vec<RealisationSolved>, RunError> {
        let results: Vec<Mutex<RealisationSolved>> = todo.iter().map(|_| Mutex::new(None)).collect();
        let trouble: Mutex<Option<io::Error>> = Mutex::new(None);
        let stop = || self.watch.stop() || lock(&trouble).is_some();
        let groups: Vec<&[&(Point, Key)]> =
            todo.chunk_by(|(a, _), (b, _)| a.incidence == b.incidence).collect();
        let places: Vec<usize> = starts(&groups);
        work_through(groups.len(), jobs, stop, |g| {
            let own = &results[places[g]..places[g] + groups[g].len()];
            let ended = self.solve_group(solver, grids, groups[g], own);
            ended.unwrap_or_else(|error| *lock(&trouble) = Some(error));
        })?;
        match trouble.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(RunError::Store(error)),
            None => Ok(results
                .into_iter()
                .map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner))
                .collect()),
        }
    }

    /// The solves of one wavelength and direction, whose problem they share. The error is the store's alone.
    fn solve_group(
        &self,
        solver: &dyn Solver,
        grids: &Grids,
        group: &[&(Point, Key)],
        results: &[Mutex<RealisationSolved>],
    ) -> io::Result<()> {
        let mut systems = None;
        for ((point, key), result) in group.iter().zip(results) {
            if self.watch.stop() {
                break;
            }
            *lock(result) = self.solve_one(solver, (grids, &mut systems), point, key)?;
        }
        Ok(())
    }

    /// One solve, in the store when it returns; the problems are made for the first of a group. The error is the store's alone.
    fn solve_one(
        &self,
        solver: &dyn Solver,
        (grids, shared): (&Grids, &mut Option<Vec<Box<dyn System>>>),
        point: &Point,
        key: &Key,
    ) -> io::Result<RealisationSolved> {
        self.watch.solving(self.study, point);
        let point_solver =
            PointSolver { study: self.study, solver, grid: self.resolved.grid_error, watch: self.watch };
        let made = match shared.take() {
            Some(systems) => Ok(systems),
            None => grids.systems(point).map_err(PointError::Wave),
        };
        let solved = made.and_then(|made| {
            let systems = shared.insert(made);
            point_solver.solve(systems, point, key.as_str())
        });
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
type RealisationSolved = Option<Result<PointRecord, String>>;

/// Places of the first members of groups that lie one after another.
fn starts<T>(groups: &[&[T]]) -> Vec<usize> {
    let mut next = 0;
    let place = |group: &&[T]| {
        let start = next;
        next += group.len();
        start
    };
    groups.iter().map(place).collect()
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
