//! Trials of single variants: the cost of packing, coverage, grid search and solves.

use crate::ink::{Packing, PigmentGrains};
use crate::input::check::largest_extents_nm;
use crate::input::study::{Point, Study};
use crate::input::variation::CellRule;
use crate::run::RunError;
use crate::run::crew::{processor_seconds, work_through};
use crate::run::longer_waves::{Finest, coarsened};
use crate::run::memory;
use crate::run::point::{Grids, PointSolver};
use crate::run::realisation::Packings;
use crate::run::resolve::resolve;
use crate::run::watch::{Event, RunWatch};
use crate::solve::Solver;
use crate::solve::accuracy::grid_error::GridError;
use crate::solve::accuracy::smooth_size;
use crate::store::store::Store;
use crate::wave::{Resolution, Scene};
use crate::work::variant::Variant;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Maximum period of a trial cell, µm, unless the longest grain needs more: then twice its length.
const TRIAL_PERIOD_UM: f64 = 1.6;
/// Solves are repeated until they have taken this long in total.
const LEAST_SECONDS: f64 = 0.5;
const MOST_SOLVES: usize = 60;
/// Cells with more grains cannot be packed in time.
pub(super) const MOST_GRAINS: f64 = 5e4;

/// Cost of a trial variant, in core seconds per µm³.
pub(crate) struct Trial<'a> {
    pub variant: &'a Variant,
    /// What was tried: the variant in a small cell.
    pub study: Study,
    pub packing: f64,
    pub coverage: f64,
    pub grid: f64,
    /// Cost of the grid search, in solves.
    pub search: f64,
    pub solve: f64,
    pub resolution: Resolution,
    /// Coarsening for longer waves, as in [`Resolved`](crate::run::resolve::Resolved).
    pub longer_waves: f64,
}

/// Approximate number of grains per µm³, which determines the cost of packing and the scale of
/// scattering.
pub(crate) fn density(study: &Study) -> f64 {
    let per_um3 = |grains: &PigmentGrains| grains.volume_fraction / (1e-3 * grains.size.largest_nm()).powi(3);
    study.pigments.iter().map(|p| per_um3(&p.grains)).sum()
}

/// The study in the small cell of a trial.
fn in_small_cell(study: &Study) -> Study {
    let longest =
        study.pigments.iter().map(|p| 2e-3 * largest_extents_nm(&p.grains).1).fold(TRIAL_PERIOD_UM, f64::max);
    let [x, y] = study.layer.period_um;
    if study.variation.cell == CellRule::Varied && x.max(y) <= 2.0 * longest {
        // Varied cells already have their minimum size, unless a larger period was requested.
        return study.clone();
    }
    let mut small = study.clone();
    small.layer.period_um = study.layer.period_um.map(|period| period.min(longest));
    small.packing.period_um = small.layer.period_um;
    small
}

/// Approximate number of grains of a cell.
pub(crate) fn grains(study: &Study) -> f64 {
    let in_layers = study.pigments.iter().zip(study.volumes_of_pigments_um3());
    in_layers.map(|(p, um3)| p.grains.expected(um3)).sum()
}

/// Runs the trial of a variant; `alike` is an earlier trial with the same requested resolution,
/// whose grid is reused.
pub fn trial<'a>(
    variant: &'a Variant,
    alike: Option<&Trial>,
    watch: &Deadline,
) -> Result<Trial<'a>, RunError> {
    let mut study = in_small_cell(&variant.study);
    study.realisations = 1;
    if grains(&study) > MOST_GRAINS {
        return Err(RunError::Stopped);
    }
    let mut packings = Packings::new(&study, watch);
    // Packing uses one core, the others are idle.
    let (packing, placed) = timed(|| packings.get(0))?;
    let packing = packing * rayon::current_num_threads() as f64;
    let (searched, grids) = grid_for(&study, &Scene::from_packing(&placed), alike, watch)?;
    let (coverage, covers) = timed(|| covers(&study, placed, grids, watch))?;
    let solve = time_solves(&study, &covers, watch)?;
    // Cost of the search in solves including their coverages; taken from an earlier trial if there
    // is one.
    let search = match (searched, alike) {
        (None, Some(trial)) => trial.search,
        (seconds, _) => seconds.unwrap_or(0.0) / (coverage + solve).max(1e-9),
    };
    let grid = search * (coverage + solve);
    let each = 1.0 / study.volume_um3();
    let (resolution, longer_waves) = grids;
    Ok(Trial {
        variant,
        study,
        packing: packing * each,
        coverage: coverage * each,
        grid: grid * each,
        search,
        solve: solve * each,
        resolution,
        longer_waves,
    })
}

/// A packing on grids; the grid of the shortest wave, and the coarsening for longer ones.
pub(crate) type Covers = (Grids, (Resolution, f64));

/// The packing on the grids of all wavelengths.
pub(crate) fn covers(
    study: &Study,
    packing: Packing,
    grids: (Resolution, f64),
    watch: &dyn RunWatch,
) -> Result<Covers, RunError> {
    let covers = (Grids::new(packing), grids);
    for point in study.points(0) {
        covers.0.geometry(study, grid_of(&covers, study, &point), watch)?;
    }
    Ok(covers)
}

fn grid_of((_, (finest, longer_waves)): &Covers, study: &Study, point: &Point) -> Resolution {
    coarsened(study, *finest, point.incidence.wavelength_um, Finest::of(study), *longer_waves)
}

/// A grid of the requested resolution with its coarsening for longer waves, and the core seconds of
/// the search, if any.
fn grid_for(
    study: &Study,
    scene: &Scene,
    alike: Option<&Trial>,
    watch: &dyn RunWatch,
) -> Result<(Option<f64>, (Resolution, f64)), RunError> {
    if let Some(trial) = alike {
        return Ok((None, (full_resolution(trial, study), trial.longer_waves)));
    }
    let store = Store::in_memory()?;
    let (seconds, resolved) =
        timed(|| resolve(study, &store, memory::usable(), watch, |_| Ok(scene.clone())))?;
    Ok((Some(seconds), (resolved.resolution, resolved.longer_waves)))
}

/// Processor seconds, and the result. The clock on the wall, which other programs' work on the
/// machine lengthens, counts only where the system does not tell the processor's.
fn timed<T>(make: impl FnOnce() -> Result<T, RunError>) -> Result<(f64, T), RunError> {
    let clock = Instant::now();
    let before = processor_seconds();
    let made = make()?;
    let used = processor_seconds().zip(before).map(|(after, before)| after - before);
    Ok((used.unwrap_or_else(|| clock.elapsed().as_secs_f64()), made))
}

/// Mean core seconds of a few solves, spread over wavelengths and angles.
pub fn time_solves(study: &Study, covers: &Covers, watch: &Deadline) -> Result<f64, RunError> {
    let chosen: Vec<Point> = spread(&study.points(0), 6.max(2 * watch.jobs));
    let ended = AtomicUsize::new(0);
    let solve = |i: usize| {
        try_solve(study, &*study.solver.build(), covers, &chosen[i], watch);
        Ok(_ = ended.fetch_add(usize::from(!watch.stop()), Ordering::Relaxed))
    };
    let mut seconds = 0.0;
    while seconds < LEAST_SECONDS && ended.load(Ordering::Relaxed) < MOST_SOLVES && !watch.stop() {
        seconds += timed(|| work_through(chosen.len(), watch.jobs, watch, solve))?.0;
    }
    match ended.into_inner() {
        0 => Err(RunError::Stopped),
        solves => Ok(seconds / solves as f64),
    }
}

/// Runs a solve and ignores its result: a failure costs about as much as a success.
fn try_solve(study: &Study, solver: &dyn Solver, covers: &Covers, point: &Point, watch: &dyn RunWatch) {
    if let Ok((systems, _)) = covers.0.problems(study, grid_of(covers, study, point), point, watch) {
        let grid = GridError::default();
        let _ = PointSolver { study, solver, grid, watch }.solve(&systems, point, "trial");
    }
}

/// The points and cells per µm of a trial, applied to another cell.
pub(crate) fn full_resolution(trial: &Trial, study: &Study) -> Resolution {
    let scaled = |n: usize, axis: usize| match n {
        1 => 1,
        n => smooth_size(
            (n as f64 * study.layer.period_um[axis] / trial.study.layer.period_um[axis]).ceil() as usize
        ),
    };
    let r = trial.resolution;
    let cells = (r.cells as f64 * study.layer.thickness_um / trial.study.layer.thickness_um).ceil() as usize;
    Resolution { nx: scaled(r.nx, 0), ny: scaled(r.ny, 1), cells, ..r }
}

fn spread(points: &[Point], count: usize) -> Vec<Point> {
    let count = count.clamp(1, points.len());
    (0..count).map(|k| points[(2 * k + 1) * points.len() / (2 * count)]).collect()
}

/// Forwards the events of a trial and stops it in time.
pub(super) struct Deadline<'a> {
    /// Stops on the user's request alone.
    pub watch: &'a dyn RunWatch,
    /// Solves at a time.
    pub jobs: usize,
    pub end: Instant,
}

impl Deadline<'_> {
    /// A deadline after an equal share of the time left, for the next of several trials.
    pub fn part(&self, trials: usize) -> Self {
        let now = Instant::now();
        Self { end: now + self.end.saturating_duration_since(now) / trials.max(1) as u32, ..*self }
    }
}

impl RunWatch for Deadline<'_> {
    fn stop(&self) -> bool {
        Instant::now() >= self.end || self.watch.stop()
    }

    fn hear(&self, event: Event) {
        self.watch.hear(event);
    }
}
