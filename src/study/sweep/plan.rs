//! What a sweep will cost, said before anything runs; calibrated by a few solves of the sweep itself.

use super::load::Sweep;
use super::units::{groups, units};
use crate::report::store::Store;
use crate::study::checked::{Point, Study};
use crate::study::crew::work_through;
use crate::study::identity::Key;
use crate::study::optics::solve_point;
use crate::study::realisation::Packings;
use crate::study::resolve::resolve;
use crate::study::runner::RunError;
use crate::study::watch::RunWatch;
use crate::wave::{Coverage, Scene};
use serde::Serialize;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

/// Most variants that are tried.
const TRIALS: usize = 3;
/// Bytes of a solve for each unknown: the solver's vectors of complex numbers.
const BYTES_PER_UNKNOWN: usize = 50 * 16;

/// The size of a sweep, and its cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plan {
    pub variants: usize,
    /// Packings to be made; variants share them.
    pub packings: usize,
    /// Different solves; variants share them.
    pub solves: usize,
    /// Units that shards divide among them.
    pub units: usize,
    /// Unknowns of the largest solve tried.
    pub unknowns: usize,
    /// For one solve at a time.
    pub memory_mb: usize,
    /// On one core, all in all.
    pub core_seconds: f64,
}

/// Cost of one variant that was tried, in core seconds.
struct Trial {
    volume_um3: f64,
    packing: f64,
    grid: f64,
    solve: f64,
    unknowns: usize,
}

/// Counts, and times some solves with `jobs` at a time.
///
/// # Errors
/// A variant that is tried cannot be packed, or its grid not found; the watch says stop.
pub fn plan(sweep: &Sweep, jobs: usize, watch: &dyn RunWatch) -> Result<Plan, RunError> {
    let groups = groups(sweep);
    let mut trials = Vec::new();
    for v in representatives(sweep, &groups) {
        watch.stage(&format!("calibrating with {}", sweep.variants[v].name));
        trials.push(trial(&sweep.variants[v].study, jobs, watch)?);
    }
    let mean = |of: &dyn Fn(&Trial) -> f64| {
        trials.iter().map(|t| of(t) / t.volume_um3).sum::<f64>() / trials.len().max(1) as f64
    };
    let rates = [mean(&|t| t.packing), mean(&|t| t.grid), mean(&|t| t.solve)];
    let (solves, core_seconds) = cost(sweep, &groups, rates);
    let unknowns = trials.iter().map(|t| t.unknowns).max().unwrap_or(0);
    let realisations = |g: &Vec<usize>| g.iter().map(|&v| sweep.variants[v].study.realisations).max();
    Ok(Plan {
        variants: sweep.variants.len(),
        packings: groups.iter().filter_map(realisations).sum(),
        solves,
        units: units(sweep).len(),
        unknowns,
        memory_mb: (unknowns * BYTES_PER_UNKNOWN).div_ceil(1_000_000),
        core_seconds,
    })
}

fn volume(study: &Study) -> f64 {
    study.layer.period_um[0] * study.layer.period_um[1] * study.layer.thickness_um
}

/// Variants with grains, evenly spread over the groups in the order of volume and strongest absorption.
fn representatives(sweep: &Sweep, groups: &[Vec<usize>]) -> Vec<usize> {
    let grains = |v: &usize| !sweep.variants[*v].study.pigments.is_empty();
    let mut firsts: Vec<usize> = groups.iter().map(|g| g[0]).filter(grains).collect();
    if firsts.is_empty() {
        firsts = groups.iter().map(|g| g[0]).take(1).collect();
    }
    firsts.sort_by(|&a, &b| volume(&sweep.variants[a].study).total_cmp(&volume(&sweep.variants[b].study)));
    let count = firsts.len().min(TRIALS);
    let last = firsts.len() - 1;
    (0..count).map(|k| firsts[if count > 1 { k * last / (count - 1) } else { 0 }]).collect()
}

fn trial(study: &Study, jobs: usize, watch: &dyn RunWatch) -> Result<Trial, RunError> {
    let folder = tempfile::tempdir()?;
    let threads = rayon::current_num_threads();
    let mut packings = Packings::new(study, watch);
    let clock = Instant::now();
    let packing = packings.get(0)?;
    let packed = clock.elapsed().as_secs_f64();
    let scene = Scene::from_packing(&packing);
    let clock = Instant::now();
    let store = Store::open(folder.path())?;
    let resolved = resolve::<RunError>(study, &store, watch, || Ok(Scene::from_packing(&packing)))?;
    let grid = clock.elapsed().as_secs_f64() * threads as f64;
    let coverage = Arc::new(Coverage::new(&scene, resolved.resolution)?);
    let points = study.points(0);
    let chosen: Vec<Point> = spread(&points, 2 * jobs);
    let clock = Instant::now();
    work_through(
        chosen.len(),
        jobs,
        || watch.stop(),
        |i| {
            // A failure costs about what a success does.
            let _ = solve_point(study, &coverage, &chosen[i], "trial", watch);
        },
    )?;
    let solve = clock.elapsed().as_secs_f64() * jobs.min(threads) as f64 / chosen.len() as f64;
    if watch.stop() {
        return Err(RunError::Stopped);
    }
    let grid_of = resolved.resolution;
    let unknowns = grid_of.nx * grid_of.ny * grid_of.planes();
    Ok(Trial { volume_um3: volume(study), packing: packed, grid, solve, unknowns })
}

fn spread(points: &[Point], count: usize) -> Vec<Point> {
    let count = count.clamp(1, points.len());
    (0..count).map(|k| points[(2 * k + 1) * points.len() / (2 * count)]).collect()
}

/// Different solves, and core seconds at the given rates (packing, grid, solve; per µm³).
fn cost(sweep: &Sweep, groups: &[Vec<usize>], [packing, grid, solve]: [f64; 3]) -> (usize, f64) {
    let (mut solves, mut seconds) = (0, 0.0);
    for group in groups {
        let mut seen = HashSet::new();
        let mut grids = HashSet::new();
        let size = volume(&sweep.variants[group[0]].study);
        for study in group.iter().map(|&v| &sweep.variants[v].study) {
            let method = (&study.resolution, &study.solver, &study.goal);
            for r in 0..study.realisations {
                let key =
                    |p: &Point| Key::of("solve", &(r, study.indices(p.wavelength), p.incidence, method));
                seen.extend(study.points(r).iter().map(key));
            }
            let indices: Vec<_> = (0..study.wavelengths_nm.len()).map(|w| study.indices(w)).collect();
            grids.insert(Key::of("grid", &(&study.wavelengths_nm, &study.angles, indices, method)));
        }
        let study = |v: &usize| &sweep.variants[*v].study;
        let packings = group.iter().map(|v| study(v).realisations).max().unwrap_or(0);
        solves += seen.len();
        // A layer without grains has no contrast to iterate on.
        if !study(&group[0]).pigments.is_empty() {
            let work = packing * packings as f64 + grid * grids.len() as f64 + solve * seen.len() as f64;
            seconds += size * work;
        }
    }
    (solves, seconds)
}
