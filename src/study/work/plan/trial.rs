//! Trials of single variants: the cost of packing, coverage, grid search and solves.

use super::deadline::Deadline;
use super::search::{SearchWatch, WITH_ESTIMATE};
use super::usual_grid::usual_grid;
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
use crate::run::resolve::{packings_compared, probed_solves, resolve};
use crate::run::watch::RunWatch;
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
/// Further solves are tried until they have taken this long in total.
const LEAST_SECONDS: f64 = 0.5;
const MOST_SOLVES: usize = 60;
/// Least number of problems that are tried, if there are as many.
const LEAST_PROBLEMS: usize = 8;
/// Distance between two tried problems in the list of all: the golden section, which spreads any
/// number of them over wavelengths and directions.
const SPREAD: f64 = 0.618;
/// Part of the work on an unfinished solve that counts where a deadline cuts it short.
const CUT_SHORT: f64 = 0.5;
/// Work on a test solve and on the same one on four fifths of points and cells, in solves.
const WITH_COARSER: f64 = 1.5;
/// Work on the search of a grid of which no search has ended, in test solves with their companions.
const SEARCHES: f64 = 2.0;
/// Cells with more grains cannot be packed in time.
pub(super) const MOST_GRAINS: f64 = 5e4;

/// Cost of a trial variant, in core seconds per µm³.
pub(crate) struct Trial<'a> {
    pub variant: &'a Variant,
    /// What was tried: the variant in a small cell.
    pub study: Study,
    pub packing: f64,
    pub coverage: f64,
    /// The choice of the grid, with all its test solves.
    pub grid: f64,
    /// Cost of the grid search on one packing, in solves including their coverages.
    pub search: f64,
    /// Whether the grid is known; otherwise it is the usual one for such waves.
    pub has_grid: bool,
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
pub(super) fn in_small_cell(study: &Study) -> Study {
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

/// Volume of the cell of a realisation, µm³.
pub(crate) fn drawn_volume_um3(study: &Study, realisation: usize) -> f64 {
    let draw = study.draw(realisation);
    draw.period_um[0] * draw.period_um[1] * draw.thickness_um
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
    let (packing, placed) = timed(|| packings.get(0))?;
    let chosen = choose_grid(&study, &Scene::from_packing(&placed), alike, watch)?;
    let (coverage, solve) = match chosen.solve_seconds {
        Some(solve) => (0.0, solve),
        None => {
            let (coverage, covers) = timed(|| covers(&study, placed, chosen.grids, watch))?;
            (coverage, time_solves(&study, &covers, watch)?)
        }
    };
    let measured = chosen.seconds.map(|seconds| seconds / (coverage + solve).max(1e-9));
    let search = measured.or(alike.map(|trial| trial.search)).unwrap_or_else(|| {
        let searches = if chosen.is_known { 1.0 } else { SEARCHES };
        probed_solves(&study) as f64 * (searches * WITH_ESTIMATE + WITH_COARSER)
    });
    // the search compares two grids on one packing, a run on others too
    let others = (packings_compared(&variant.study) - 1) as f64;
    let comparison = packing + WITH_COARSER * (coverage + probed_solves(&study) as f64 * solve);
    let grid = search * (coverage + solve) + others * comparison;
    let each = 1.0 / drawn_volume_um3(&study, 0);
    let (resolution, longer_waves) = chosen.grids;
    Ok(Trial {
        variant,
        study,
        packing: packing * each,
        coverage: coverage * each,
        grid: grid * each,
        search,
        has_grid: chosen.is_known,
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

/// The grid of a trial.
struct ChosenGrid {
    /// Core seconds of the search, where one has ended.
    seconds: Option<f64>,
    /// Whether it is the grid of a run; otherwise one that an unfinished search suggests, or the
    /// usual one for such waves.
    is_known: bool,
    /// The grid, and its coarsening for longer waves.
    grids: (Resolution, f64),
    /// Core seconds of a solve with its coverage, where an unfinished search suggests them.
    solve_seconds: Option<f64>,
}

impl ChosenGrid {
    fn known(seconds: Option<f64>, grids: (Resolution, f64)) -> Self {
        Self { seconds, is_known: true, grids, solve_seconds: None }
    }
}

/// The requested grid, that of an earlier trial, or the one that a search finds in half of the time
/// that is left; otherwise what the search suggests, or the usual one for such waves.
fn choose_grid(
    study: &Study,
    scene: &Scene,
    alike: Option<&Trial>,
    watch: &Deadline,
) -> Result<ChosenGrid, RunError> {
    if let Some(given) = study.given_grid(&study.draw(0)) {
        return Ok(ChosenGrid::known(None, (given, 0.0)));
    }
    if let Some(trial) = alike {
        let grids = (full_resolution(trial, study), trial.longer_waves);
        return Ok(ChosenGrid { is_known: trial.has_grid, ..ChosenGrid::known(None, grids) });
    }
    let search = SearchWatch::new(watch.part(2));
    let store = Store::in_memory()?;
    let searched = timed(|| resolve(study, &store, memory::usable(), &search, |_| Ok(scene.clone())));
    match searched.map_err(RunError::stopped) {
        Ok((seconds, found)) => {
            let grids = (found.for_cell(&study.draw(0)), found.longer_waves);
            Ok(ChosenGrid::known(Some(seconds), grids))
        }
        Err(RunError::Stopped) if !watch.stop() => {
            let suggested = search.suggestion(study);
            let grid = suggested.map_or_else(|| usual_grid(study), |(grid, _)| grid);
            let solve_seconds = suggested.map(|(_, seconds)| seconds);
            Ok(ChosenGrid { is_known: false, solve_seconds, ..ChosenGrid::known(None, (grid, 0.0)) })
        }
        Err(error) => Err(error),
    }
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

/// Mean core seconds of a few solves, spread over wavelengths and directions. As in a run, the
/// polarisations of one wavelength and direction share what is set up for them.
pub fn time_solves(study: &Study, covers: &Covers, watch: &Deadline) -> Result<f64, RunError> {
    let points = study.points(0);
    let problems: Vec<&[Point]> = points.chunk_by(|a, b| a.incidence == b.incidence).collect();
    let at_a_time = problems.len().min(LEAST_PROBLEMS.max(2 * watch.jobs));
    let begun = AtomicUsize::new(0);
    let ended = AtomicUsize::new(0);
    let mut seconds = 0.0;
    let mut tried = 0;
    while seconds < LEAST_SECONDS && ended.load(Ordering::Relaxed) < MOST_SOLVES && !watch.stop() {
        let solve = |i: usize| {
            let place = ((tried + i) as f64 + 0.5) * SPREAD;
            let points = problems[(place.fract() * problems.len() as f64) as usize];
            begun.fetch_add(points.len(), Ordering::Relaxed);
            let solved = try_solves(study, &*study.solver.build(), covers, points, watch);
            Ok(_ = ended.fetch_add(solved, Ordering::Relaxed))
        };
        seconds += timed(|| work_through(at_a_time, watch.jobs, watch, solve))?.0;
        tried += at_a_time;
    }
    let ended = ended.into_inner();
    let cut_short = begun.into_inner() - ended;
    match ended {
        0 => Err(RunError::Stopped),
        _ => Ok(seconds / (ended as f64 + CUT_SHORT * cut_short as f64)),
    }
}

/// Runs the solves of one wavelength and direction and ignores their results: a failure costs about
/// as much as a success. Returns the number of those that ended in time.
fn try_solves(
    study: &Study,
    solver: &dyn Solver,
    covers: &Covers,
    points: &[Point],
    watch: &dyn RunWatch,
) -> usize {
    let grid = grid_of(covers, study, &points[0]);
    let problems = covers.0.problems(study, grid, &points[0], watch);
    let mut ended = 0;
    for point in points {
        if let Ok((systems, _)) = &problems {
            let grid = GridError::default();
            let _ = PointSolver { study, solver, grid, watch }.solve(systems, point, "trial");
        }
        ended += usize::from(!watch.stop());
    }
    ended
}

/// The points and cells per µm of a trial, applied to the first cell of another study.
pub(crate) fn full_resolution(trial: &Trial, study: &Study) -> Resolution {
    let tried = trial.study.draw(0);
    let wanted = study.draw(0);
    // rounding errors do not ask for another point
    let needed = |n: usize, ratio: f64| (n as f64 * ratio * (1.0 - 1e-9)).ceil() as usize;
    let points = |n: usize, axis: usize| match n {
        1 => 1,
        n => smooth_size(needed(n, wanted.period_um[axis] / tried.period_um[axis])),
    };
    let r = trial.resolution;
    let cells = needed(r.cells, wanted.thickness_um / tried.thickness_um);
    Resolution { nx: points(r.nx, 0), ny: points(r.ny, 1), cells, ..r }
}
