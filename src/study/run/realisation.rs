//! One realisation of a run: its packing, its coverage, its solves.

use super::collected::{RunSettings, Stores};
use super::crew::work_through;
use super::point::{Grids, PointSolver, attempt, is_physical, pack_realisation};
use super::resolve::{self, Resolved};
use super::watch::{Event, RunError, RunWatch};
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::Solver;
use crate::store::{FailureRecord, Key, PackingRecord};
use crate::wave::{Mean, Resolution};
use std::borrow::Cow;
use std::cell::OnceCell;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Packings on demand. The first one is kept for the choice of the grid, the latest one for all
/// studies that share it.
pub struct Packings<'a> {
    study: &'a Study,
    watch: &'a dyn RunWatch,
    kept: Vec<(usize, Arc<Grids>)>,
}

impl<'a> Packings<'a> {
    /// Starts without packings.
    pub fn new(study: &'a Study, watch: &'a dyn RunWatch) -> Self {
        Self { study, watch, kept: Vec::new() }
    }

    /// The packing of a realisation, computed unless it is kept.
    pub fn get(&mut self, realisation: usize) -> Result<Packing, RunError> {
        Ok(self.on_grids(realisation)?.packing.clone())
    }

    /// The packing of a realisation on grids.
    pub(super) fn on_grids(&mut self, realisation: usize) -> Result<Arc<Grids>, RunError> {
        if let Some((_, grids)) = self.kept.iter().find(|(kept, _)| *kept == realisation) {
            return Ok(grids.clone());
        }
        self.watch.stage(&format!("packing realisation {}/{}", realisation + 1, self.study.realisations));
        let packing = pack_realisation(self.study, realisation, self.watch)
            .map_err(|source| RunError::Packing { realisation, source })?;
        let grids = Arc::new(Grids::new(packing));
        self.kept.retain(|(kept, _)| *kept == 0 || realisation == 0);
        self.kept.push((realisation, grids.clone()));
        Ok(grids)
    }
}

/// One of the ways in which a realisation is solved.
struct Way<'a> {
    /// The study, or the study with a table of indices moved by its errors.
    study: Cow<'a, Study>,
    /// Its grids.
    resolved: Resolved,
}

/// The ways in which a realisation is solved: on the study's grid, on a finer one if it is checked,
/// and with the tables of indices moved by their errors.
fn ways<'a>(study: &'a Study, resolved: &Resolved, realisation: usize) -> Vec<Way<'a>> {
    let mut ways = vec![Way { study: Cow::Borrowed(study), resolved: *resolved }];
    if study.is_checked(realisation) {
        ways.push(Way { study: Cow::Borrowed(study), resolved: resolved.finer() });
    }
    let moves = study.moves_of(realisation);
    ways.extend(moves.iter().map(|by| Way { study: Cow::Owned(study.moved(by)), resolved: *resolved }));
    ways
}

/// The solves of a realisation in one way, with content hashes of everything that each depends on.
/// The grid of each is that of the study itself, so that
/// differences between ways are not those of grids.
fn keys_of(run_study: &Study, way: &Way, realisation: usize) -> Vec<(Point, Key)> {
    let Way { study, resolved } = way;
    let packing = Key::of_packing(&study.packing_request(realisation));
    let draw = study.draw(realisation);
    let error = study.resolution.coverage_error();
    let mut keyed = Vec::new();
    for point in study.points(realisation) {
        let resolution = resolved.for_wave(run_study, &draw, point.incidence.wavelength_um);
        let method = (resolution, Mean::default(), &study.solver, &study.goal, error);
        let indices = study.indices(point.incidence.wavelength_um);
        let inputs = (&packing, indices, &point.incidence, method);
        keyed.push((point, Key::of_wave("point", &inputs, point.polarisation)));
    }
    keyed
}

/// The solves of a realisation in all ways.
pub fn all_point_keys(study: &Study, resolved: &Resolved, realisation: usize) -> Vec<(Point, Key)> {
    ways(study, resolved, realisation).iter().flat_map(|way| keys_of(study, way, realisation)).collect()
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
        let ways = ways(self.study, self.resolved, self.realisation);
        ways.iter().map(|way| WayRun { run: self, way }.finish(packings)).sum()
    }
}

/// The work on one realisation in one way.
struct WayRun<'a> {
    run: &'a RealisationRun<'a>,
    way: &'a Way<'a>,
}

impl WayRun<'_> {
    /// Computes the missing solves.
    fn finish(&self, packings: &mut Packings) -> Result<usize, RunError> {
        let &RealisationRun { stores, settings, watch, realisation, study: run_study, .. } = self.run;
        let Way { study, resolved } = self.way;
        let keyed = keys_of(run_study, self.way, realisation);
        let lacking: Vec<&(Point, Key)> = keyed.iter().filter(|keyed| !self.is_kept(keyed)).collect();
        let kept = keyed.len() - lacking.len();
        let (failed, todo): (Vec<_>, Vec<_>) =
            lacking.into_iter().partition(|keyed| stores.failure(keyed).is_some());
        let packing_key = Key::of_packing(&study.packing_request(realisation));
        if todo.is_empty() && stores.packings.has(packing_key.as_str()) {
            return Ok(self.pass(kept, failed.len()));
        }
        let grids = packings.on_grids(realisation)?;
        let requested = study.solver.build();
        let record = PackingRecord::new(realisation, &grids.packing);
        stores.packings.put(packing_key.as_str(), &record)?;
        let size = resolve::size(study, resolved.for_cell(&study.draw(realisation)));
        let (solver, jobs) = settings.admit(&size, &*requested, 1.0, watch)?;
        for (point, _) in &todo {
            grids.geometry(study, self.grid(point), watch)?;
        }
        Ok(self.pass(kept, failed.len()) + self.solve_all(solver.solver(), jobs, &grids, &todo)?)
    }

    /// The grid of a point's wave.
    fn grid(&self, point: &Point) -> Resolution {
        let study = self.run.study;
        self.way.resolved.for_wave(study, &study.draw(self.run.realisation), point.incidence.wavelength_um)
    }

    /// Reports the solves that need no work; returns the number of those without a result.
    fn pass(&self, kept: usize, failed: usize) -> usize {
        self.run.watch.hear(Event::Kept(kept));
        self.run.watch.hear(Event::Dropped(failed));
        failed
    }

    /// Whether the store has a valid result of this solve.
    fn is_kept(&self, (_, key): &(Point, Key)) -> bool {
        let record = self.run.stores.points.get(key.as_str());
        record.is_some_and(|record| is_physical(&record, self.way.resolved.grid_error))
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
        let failed = AtomicUsize::new(0);
        let groups: Vec<_> = todo.chunk_by(|(a, _), (b, _)| a.incidence == b.incidence).collect();
        work_through(groups.len(), jobs, self.run.watch, |g| {
            Ok(_ = failed.fetch_add(self.solve_group(solver, grids, groups[g])?, Ordering::Relaxed))
        })?;
        Ok(failed.into_inner())
    }

    /// Solves for one wavelength and direction, which share the problems set up by the first;
    /// returns the number of solves without a result. Errors are those of the store.
    fn solve_group(&self, solver: &dyn Solver, grids: &Grids, group: &[&(Point, Key)]) -> io::Result<usize> {
        let study = &*self.way.study;
        let stores = self.run.stores;
        let watch = self.run.watch;
        let point_solver = PointSolver { study, solver, grid: self.way.resolved.grid_error, watch };
        let shared = OnceCell::new();
        let mut failed = 0;
        for keyed @ (point, key) in group {
            if watch.stop() {
                break;
            }
            let solved = attempt(study, &stores.points, watch, keyed, || {
                let made = shared.get_or_init(|| grids.problems(study, self.grid(point), point, watch));
                let (systems, _) = made.as_ref().map_err(Clone::clone)?;
                point_solver.solve(systems, point, key.as_str())
            })?;
            if let Err(Some(reason)) = solved {
                let variant = study.title.clone();
                let realisation = point.realisation;
                let record = FailureRecord { variant, realisation, incidence: Some(point.incidence), reason };
                stores.failures.put(key.as_str(), &record)?;
                failed += 1;
            }
        }
        Ok(failed)
    }
}
