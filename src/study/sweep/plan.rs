//! What a sweep will cost, said before anything runs; calibrated by a few solves of the sweep itself.

use super::load::Sweep;
use super::units::{groups, units};
use crate::ink::PigmentGrains;
use crate::report::store::Store;
use crate::solve::accuracy::smooth_size;
use crate::study::check::largest_extents_nm;
use crate::study::checked::{Point, Study};
use crate::study::crew::work_through;
use crate::study::identity::Key;
use crate::study::optics::solve_point;
use crate::study::realisation::Packings;
use crate::study::resolve::resolve;
use crate::study::runner::{RunError, stopped};
use crate::study::watch::RunWatch;
use crate::wave::{Coverage, Resolution, Scene};
use serde::Serialize;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

/// Most variants that are tried.
const TRIALS: usize = 4;
/// Trials are made in cells of at most this period, µm, or that of twice the longest grain.
const TRIAL_PERIOD_UM: f64 = 1.6;
/// Bytes of a solve for each unknown: the solver's vectors of complex numbers.
const BYTES_PER_UNKNOWN: usize = 50 * 16;

/// The size of a sweep, and its cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    pub variants: usize,
    /// Packings to be made; variants share them.
    pub packings: usize,
    /// Different solves; variants share them.
    pub solves: usize,
    /// Units that shards divide among them.
    pub units: usize,
    /// Unknowns of the largest solve among the variants tried, at full size.
    pub unknowns: usize,
    /// For one solve at a time.
    pub memory_mb: usize,
    /// On one core, all in all.
    pub core_seconds: f64,
    /// What was tried, in words.
    pub calibration: String,
}

/// Cost of one variant that was tried, in core seconds a µm³.
struct Trial {
    variant: usize,
    period_um: [f64; 2],
    density: f64,
    packing: f64,
    coverage: f64,
    grid: f64,
    solve: f64,
    resolution: Resolution,
}

/// Counts, and times some solves with `jobs` at a time.
///
/// Variants spread over the densities of grains are tried in small cells, with a share of their solves; one of them is
/// solved at full size as well, and tells how much more a µm³ costs there. All else is scaled by volume.
///
/// # Errors
/// No variant that was tried can be packed and solved; the watch says stop.
pub fn plan(sweep: &Sweep, jobs: usize, watch: &dyn RunWatch) -> Result<Plan, RunError> {
    let groups = groups(sweep);
    let (mut trials, mut failure) = (Vec::new(), None);
    for v in representatives(sweep, &groups) {
        watch.stage(&format!("calibrating with {} in a small cell", sweep.variants[v].name));
        match trial(v, &sweep.variants[v].study, jobs, watch).map_err(stopped) {
            Ok(trial) => trials.push(trial),
            Err(RunError::Stopped) => return Err(RunError::Stopped),
            Err(error) => failure = Some(error),
        }
    }
    if let (true, Some(error)) = (trials.is_empty(), failure) {
        return Err(error);
    }
    let mut calibration = in_words(sweep, &trials);
    if let Some((name, factor)) = at_full_size(sweep, &trials, jobs, watch)? {
        calibration += &format!("; {name} at full size costs {factor:.2} times as much a µm³");
        trials.iter_mut().for_each(|t| (t.solve, t.grid) = (t.solve * factor, t.grid * factor));
    }
    let (solves, core_seconds) = cost(sweep, &groups, &trials);
    let full = |t: &Trial| full_resolution(t, &sweep.variants[t.variant].study);
    let unknowns = trials.iter().map(full).map(|r| r.nx * r.ny * r.planes()).max().unwrap_or(0);
    let realisations = |g: &Vec<usize>| g.iter().map(|&v| sweep.variants[v].study.realisations).max();
    Ok(Plan {
        variants: sweep.variants.len(),
        packings: groups.iter().filter_map(realisations).sum(),
        solves,
        units: units(sweep).len(),
        unknowns,
        memory_mb: (unknowns * BYTES_PER_UNKNOWN).div_ceil(1_000_000),
        core_seconds,
        calibration,
    })
}

fn in_words(sweep: &Sweep, trials: &[Trial]) -> String {
    let widest = trials.iter().map(|t| t.period_um[0].max(t.period_um[1])).fold(0.0, f64::max);
    let names: Vec<&str> = trials.iter().map(|t| sweep.variants[t.variant].name.as_str()).collect();
    format!("{} in cells of up to {widest} µm, scaled by volume", names.join(", "))
}

fn volume(study: &Study) -> f64 {
    study.layer.period_um[0] * study.layer.period_um[1] * study.layer.thickness_um
}

/// Grains a µm³, about: what packings cost, and how finely light is scattered.
fn density(study: &Study) -> f64 {
    let of = |grains: &PigmentGrains| grains.volume_fraction / (1e-3 * grains.size.largest_nm()).powi(3);
    study.pigments.iter().map(|p| of(&p.grains)).sum()
}

/// Variants with grains, evenly spread over the groups in the order of their density of grains.
fn representatives(sweep: &Sweep, groups: &[Vec<usize>]) -> Vec<usize> {
    let grains = |v: &usize| !sweep.variants[*v].study.pigments.is_empty();
    let mut firsts: Vec<usize> = groups.iter().map(|g| g[0]).filter(grains).collect();
    if firsts.is_empty() {
        firsts = groups.iter().map(|g| g[0]).take(1).collect();
    }
    firsts.sort_by(|&a, &b| density(&sweep.variants[a].study).total_cmp(&density(&sweep.variants[b].study)));
    let (count, last) = (firsts.len().min(TRIALS), firsts.len() - 1);
    let chosen = (0..count).map(|k| firsts[if count > 1 { k * last / (count - 1) } else { 0 }]);
    // The inks take turns, so that not all trials are of the first one.
    let of_group = |v: usize| groups.iter().find(|g| g[0] == v).map_or(&[][..], Vec::as_slice);
    chosen
        .enumerate()
        .map(|(k, v)| of_group(v).get(k % of_group(v).len().max(1)).copied().unwrap_or(v))
        .collect()
}

/// The study in a cell as small as a trial's.
fn in_small_cell(study: &Study) -> Study {
    let longest =
        study.pigments.iter().map(|p| 2e-3 * largest_extents_nm(&p.grains).1).fold(TRIAL_PERIOD_UM, f64::max);
    let mut small = study.clone();
    small.layer.period_um = study.layer.period_um.map(|period| period.min(longest));
    small.packing.period_um = small.layer.period_um;
    small
}

fn trial(variant: usize, study: &Study, jobs: usize, watch: &dyn RunWatch) -> Result<Trial, RunError> {
    let (full, study) = (study, in_small_cell(study));
    let folder = tempfile::tempdir()?;
    let threads = rayon::current_num_threads() as f64;
    let mut packings = Packings::new(&study, watch);
    let clock = Instant::now();
    let scene = Scene::from_packing(&packings.get(0)?);
    // Nothing else runs while grains are packed or the grid is sought: all cores wait.
    let packing = clock.elapsed().as_secs_f64() * threads;
    let clock = Instant::now();
    let store = Store::open(folder.path())?;
    let resolved = resolve::<RunError>(&study, &store, watch, || Ok(scene.clone()))?;
    let grid = clock.elapsed().as_secs_f64() * threads;
    let clock = Instant::now();
    let cover = Arc::new(Coverage::new(&scene, resolved.resolution)?);
    let coverage = clock.elapsed().as_secs_f64() * threads;
    let solve = time_solves(&study, &cover, jobs, watch)?;
    let each = 1.0 / volume(&study);
    Ok(Trial {
        variant,
        period_um: study.layer.period_um,
        density: density(full),
        packing: packing * each,
        coverage: coverage * each,
        grid: grid * each,
        solve: solve * each,
        resolution: resolved.resolution,
    })
}

/// Core seconds of one solve, the mean over a few that are spread over wavelengths and angles.
fn time_solves(
    study: &Study,
    coverage: &Arc<Coverage>,
    jobs: usize,
    watch: &dyn RunWatch,
) -> Result<f64, RunError> {
    let chosen: Vec<Point> = spread(&study.points(0), 3 * jobs);
    let clock = Instant::now();
    work_through(
        chosen.len(),
        jobs,
        || watch.stop(),
        |i| {
            // A failure costs about what a success does.
            let _ = solve_point(study, coverage, &chosen[i], "trial", watch);
        },
    )?;
    if watch.stop() {
        return Err(RunError::Stopped);
    }
    let cores = jobs.min(rayon::current_num_threads());
    Ok(clock.elapsed().as_secs_f64() * cores as f64 / chosen.len() as f64)
}

/// The points and cells a µm of a trial in the whole cell.
fn full_resolution(trial: &Trial, study: &Study) -> Resolution {
    let scaled = |n: usize, axis: usize| match n {
        1 => 1,
        n => smooth_size((n as f64 * study.layer.period_um[axis] / trial.period_um[axis]).ceil() as usize),
    };
    let r = trial.resolution;
    Resolution { nx: scaled(r.nx, 0), ny: scaled(r.ny, 1), ..r }
}

/// The variant that was packed fastest, solved at full size: its name, and what a µm³ costs there over the small cell.
fn at_full_size(
    sweep: &Sweep,
    trials: &[Trial],
    jobs: usize,
    watch: &dyn RunWatch,
) -> Result<Option<(String, f64)>, RunError> {
    let Some(trial) = trials.iter().min_by(|a, b| a.packing.total_cmp(&b.packing)) else { return Ok(None) };
    let variant = &sweep.variants[trial.variant];
    if variant.study.layer.period_um == trial.period_um {
        return Ok(None);
    }
    watch.stage(&format!("calibrating with {} at full size", variant.name));
    let scene = Scene::from_packing(&Packings::new(&variant.study, watch).get(0).map_err(stopped)?);
    let cover = Arc::new(Coverage::new(&scene, full_resolution(trial, &variant.study))?);
    let solve = time_solves(&variant.study, &cover, jobs, watch)? / volume(&variant.study);
    Ok(Some((variant.name.clone(), solve / trial.solve)))
}

fn spread(points: &[Point], count: usize) -> Vec<Point> {
    let count = count.clamp(1, points.len());
    (0..count).map(|k| points[(2 * k + 1) * points.len() / (2 * count)]).collect()
}

/// Different solves, and core seconds: each group at the rates of the trial with the nearest density of grains.
fn cost(sweep: &Sweep, groups: &[Vec<usize>], trials: &[Trial]) -> (usize, f64) {
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
        let distance = |t: &&Trial| (t.density / density(study(&group[0]))).ln().abs();
        let nearest = trials.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let (false, Some(trial)) = (study(&group[0]).pigments.is_empty(), nearest) {
            let covers: usize = group.iter().map(|v| study(v).realisations).sum();
            let once = trial.packing * packings as f64 + trial.coverage * covers as f64;
            seconds += size * (once + trial.grid * grids.len() as f64 + trial.solve * seen.len() as f64);
        }
    }
    (solves, seconds)
}
