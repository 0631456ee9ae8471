//! One realisation of a run: its packing, its coverage, its solves.

use super::collected::{RunSettings, Stores};
use super::crew::work_through;
use super::error::RunError;
use super::grids::{Grids, Wavelength};
use super::point::{PointError, PointSolver, is_physical, pack_realisation};
use super::resolve;
use super::resolve::Resolved;
use super::watch::{Event, RunWatch};
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::Solver;
use crate::store::identity::Key;
use crate::store::packing_record::PackingRecord;
use crate::store::record::FailureRecord;
use crate::wave::{Geometry, Mean, Precision, Resolution, Scene, System, Wave};
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Packings on demand. The first one is kept for the choice of the grid, the latest one for all
/// studies that share it.
pub struct Packings<'a> {
    study: &'a Study,
    watch: &'a dyn RunWatch,
    first: Option<Packing>,
    latest: Option<(usize, Packing)>,
    /// Geometries of the latest realisation, by wave (vector or not), grid and error: inks that
    /// share a packing share them, and so do the polarisations.
    geometries: Vec<((bool, usize, Resolution, f64), Geometry)>,
}

impl<'a> Packings<'a> {
    /// Starts without packings.
    pub fn new(study: &'a Study, watch: &'a dyn RunWatch) -> Self {
        Self { study, watch, first: None, latest: None, geometries: Vec::new() }
    }

    /// The packing of a realisation, computed unless it is kept.
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
        // Geometries of other realisations are no longer needed.
        self.geometries.retain(|((_, r, ..), _)| *r == realisation);
        let scene = Scene::from_packing(&self.get(realisation)?);
        let stop = || self.watch.stop();
        let geometry = Geometry::new(wave, &scene, resolution, Precision { error, stop: &stop })?;
        self.geometries.push((asked, geometry.clone()));
        Ok(geometry)
    }
}

/// The solves of a realisation with the content hashes of their inputs.
pub fn point_keys(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<(Point, Key)> {
    let packing = Key::of_packing(&study.packing_request(realisation));
    let draw = study.draw(realisation);
    let key = |point: &Point| {
        let resolution = resolved.for_wave(study, &draw, point.incidence.wavelength_um);
        point_key(study, &packing, &resolution, point)
    };
    study.points(realisation).into_iter().map(|point| (point, key(&point))).collect()
}

/// The solves of a realisation on all its grids.
pub fn all_point_keys(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<(Point, Key)> {
    let levels = levels(study, resolved, realisation);
    levels.iter().flat_map(|level| point_keys(study, level, realisation)).collect()
}

/// The grids on which a realisation is solved: the study's, and a finer one if it is checked.
fn levels(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<Resolved> {
    let finer = study.is_checked(realisation).then(|| resolved.finer());
    [*resolved].into_iter().chain(finer).collect()
}

/// Content hash of everything that one solve depends on.
fn point_key(study: &Study, packing: &Key, resolution: &Resolution, point: &Point) -> Key {
    let error = study.resolution.coverage_error();
    let method = (resolution, Mean::default(), &study.solver, &study.goal, error);
    let indices = study.indices(point.incidence.wavelength_um);
    Key::of_wave("point", &(packing, indices, &point.incidence, method), point.polarisation)
}

/// The work on one realisation.
pub struct RealisationRun<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its grids.
    pub resolved: &'a Resolved,
    /// Where records are stored.
    pub stores: &'a Stores,
    /// How to run.
    pub settings: RunSettings,
    /// Follows the progress.
    pub watch: &'a dyn RunWatch,
    /// Number of the realisation, from 0.
    pub realisation: usize,
}

impl RealisationRun<'_> {
    /// Computes the solves missing in the store; returns the number of solves without a result.
    pub fn finish(&self, packings: &mut Packings) -> Result<usize, RunError> {
        let mut failed = 0;
        for resolved in &levels(self.study, self.resolved, self.realisation) {
            failed += RealisationRun { resolved, ..*self }.finish_level(packings)?;
        }
        Ok(failed)
    }

    /// Computes the missing solves on one grid.
    fn finish_level(&self, packings: &mut Packings) -> Result<usize, RunError> {
        let keyed = point_keys(self.study, self.resolved, self.realisation);
        let lacking: Vec<&(Point, Key)> = keyed.iter().filter(|keyed| !self.is_kept(keyed)).collect();
        let (failed, todo): (Vec<_>, Vec<_>) =
            lacking.iter().partition(|keyed| self.stores.failure(keyed).is_some());
        let kept = keyed.len() - lacking.len();
        let packing_key = Key::of_packing(&self.study.packing_request(self.realisation));
        if todo.is_empty() && self.stores.packings.has(packing_key.as_str()) {
            return Ok(self.pass(kept, failed.len()));
        }
        let packing = packings.get(self.realisation)?;
        self.stores.packings.put(packing_key.as_str(), &PackingRecord::new(self.realisation, &packing))?;
        let finest = self.resolved.for_cell(&self.study.draw(self.realisation));
        let size = resolve::size(self.study, finest);
        let solver = self.study.solver.build();
        let jobs = self.jobs(size.admit(&*solver, self.settings.memory)?.bytes);
        let solver = size.admit(&*solver, self.settings.memory / jobs as f64)?;
        let grids = Grids::new(self.study, &packing, self.geometries(packings, &todo)?);
        Ok(self.pass(kept, failed.len()) + self.solve_all(solver.solver(), jobs, &grids, &todo)?)
    }

    /// Reports the solves that need no work; returns the number of those without a result.
    fn pass(&self, kept: usize, failed: usize) -> usize {
        self.watch.hear(Event::Kept(kept));
        self.watch.hear(Event::Dropped(failed));
        failed
    }

    /// Whether the store has a valid result of this solve.
    fn is_kept(&self, (_, key): &(Point, Key)) -> bool {
        let record = self.stores.points.get(key.as_str());
        record.is_some_and(|record| is_physical(&record, self.resolved.grid_error))
    }

    /// The packing on the grids of these solves.
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

    /// Number of parallel solves: as requested, as far as the memory suffices.
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

    /// Records that a solve has no result.
    fn note_failure(&self, (point, key): &(Point, Key), reason: String) -> io::Result<()> {
        let (variant, realisation) = (self.study.title.clone(), point.realisation);
        let record = FailureRecord { variant, realisation, incidence: Some(point.incidence), reason };
        self.stores.failures.put(key.as_str(), &record)
    }

    /// Runs the solves in parallel, those of one problem in sequence; returns the number of solves
    /// without a result.
    fn solve_all(
        &self,
        solver: &dyn Solver,
        jobs: usize,
        grids: &Grids,
        todo: &[&(Point, Key)],
    ) -> Result<usize, RunError> {
        let (failed, trouble) = (AtomicUsize::new(0), Mutex::new(None));
        let stop = || self.watch.stop() || lock(&trouble).is_some();
        let groups: Vec<&[&(Point, Key)]> =
            todo.chunk_by(|(a, _), (b, _)| a.incidence == b.incidence).collect();
        work_through(groups.len(), jobs, stop, |g| match self.solve_group(solver, grids, groups[g]) {
            Ok(more) => _ = failed.fetch_add(more, Ordering::Relaxed),
            Err(error) => *lock(&trouble) = Some(error),
        })?;
        match trouble.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(RunError::Store(error)),
            None => Ok(failed.into_inner()),
        }
    }

    /// Solves for one wavelength and direction, which share their problem. Errors are those of the
    /// store.
    fn solve_group(&self, solver: &dyn Solver, grids: &Grids, group: &[&(Point, Key)]) -> io::Result<usize> {
        let (mut systems, mut failed) = (None, 0);
        for keyed in group {
            if self.watch.stop() {
                break;
            }
            failed += usize::from(!self.solve_one(solver, (grids, &mut systems), keyed)?);
        }
        Ok(failed)
    }

    /// Runs one solve and stores its record; the first of a group sets up the problems. Returns
    /// false if the solve fails. Errors are those of the store.
    fn solve_one(
        &self,
        solver: &dyn Solver,
        (grids, shared): (&Grids, &mut Option<Vec<Box<dyn System>>>),
        keyed @ (point, key): &(Point, Key),
    ) -> io::Result<bool> {
        self.watch.hear(Event::Solving(self.study, point));
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
        self.watch.hear(Event::Ended);
        match solved {
            Ok(record) => {
                self.stores.points.put(key.as_str(), &record)?;
                self.watch.hear(Event::Solved(point, None));
                Ok(true)
            }
            Err(error) if PointError::is_stop(&error) => Ok(true),
            Err(error) => {
                let reason = error.to_string();
                self.watch.hear(Event::Solved(point, Some(&reason)));
                self.note_failure(keyed, reason)?;
                Ok(false)
            }
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
