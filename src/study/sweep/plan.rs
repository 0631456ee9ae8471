//! What a sweep will cost, said before anything runs; calibrated by a few solves of the sweep itself.

use super::load::Sweep;
use super::units::{groups, units};
use crate::ink::PigmentGrains;
use crate::report::store::Store;
use crate::solve::accuracy::smooth_size;
use crate::study::check::largest_extents_nm;
use crate::study::checked::{Point, Study, WantedResolution};
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
    thickness_um: f64,
    wanted: WantedResolution,
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
/// solved at full size as well, and tells how much more a µm³ costs there. All else is scaled by volume. For each wanted
/// resolution the grid is sought once, for the fewest grains; the other variants are tried on the same grid.
///
/// # Errors
/// No variant that was tried can be packed and solved; the watch says stop.
pub fn plan(sweep: &Sweep, jobs: usize, watch: &dyn RunWatch) -> Result<Plan, RunError> {
    let groups = groups(sweep);
    let (mut trials, mut failure) = (Vec::new(), None);
    for v in representatives(sweep, &groups) {
        watch.stage(&format!("calibrating with {} in a small cell", sweep.variants[v].name));
        let study = &sweep.variants[v].study;
        let alike = trials.iter().find(|t: &&Trial| t.wanted == study.resolution);
        match trial(v, study, alike, jobs, watch).map_err(stopped) {
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

/// For each wanted resolution, variants with grains in the order of their density of grains, evenly spread over it.
fn representatives(sweep: &Sweep, groups: &[Vec<usize>]) -> Vec<usize> {
    let study = |v: usize| &sweep.variants[v].study;
    let wanted = resolutions(sweep, &(0..sweep.variants.len()).collect::<Vec<_>>());
    let each = (TRIALS / wanted.len()).max(2);
    let of_resolution = |(n, wanted): (usize, &WantedResolution)| {
        let here = |v: &&usize| study(**v).resolution == *wanted;
        // The inks of a group take turns, so that not all trials are of the first one.
        let member = |(k, group): (usize, &Vec<usize>)| {
            let members: Vec<usize> = group.iter().filter(here).copied().collect();
            members.get((k + n) % members.len().max(1)).copied()
        };
        let all: Vec<usize> = groups.iter().enumerate().filter_map(member).collect();
        let mut some: Vec<usize> = all.iter().copied().filter(|&v| !study(v).pigments.is_empty()).collect();
        if some.is_empty() {
            some = all.into_iter().take(1).collect();
        }
        some.sort_by(|&a, &b| density(study(a)).total_cmp(&density(study(b))));
        let (count, last) = (some.len().min(each), some.len().saturating_sub(1));
        (0..count).map(move |k| some[k * last / (count - 1).max(1)]).collect::<Vec<_>>()
    };
    wanted.iter().enumerate().flat_map(of_resolution).collect()
}

/// Different wanted resolutions among variants.
fn resolutions(sweep: &Sweep, variants: &[usize]) -> Vec<WantedResolution> {
    let mut found: Vec<WantedResolution> = Vec::new();
    for &v in variants {
        let wanted = sweep.variants[v].study.resolution;
        if !found.contains(&wanted) {
            found.push(wanted);
        }
    }
    found
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

/// Tries a variant; `alike` is an earlier trial that wanted the same resolution, and has found a grid for it.
fn trial(
    variant: usize,
    full: &Study,
    alike: Option<&Trial>,
    jobs: usize,
    watch: &dyn RunWatch,
) -> Result<Trial, RunError> {
    let study = in_small_cell(full);
    let mut packings = Packings::new(&study, watch);
    // Grains are packed on one core, while the others wait.
    let (packing, scene) = timed(|| packings.get(0).map(|packing| Scene::from_packing(&packing)))?;
    let packing = packing * rayon::current_num_threads() as f64;
    let (found, resolution) = match alike {
        Some(trial) => (0.0, full_resolution(trial, &study)),
        None => timed(|| {
            let folder = tempfile::tempdir()?;
            let store = Store::open(folder.path())?;
            Ok(resolve::<RunError>(&study, &store, watch, || Ok(scene.clone()))?.resolution)
        })?,
    };
    let (coverage, cover) = timed(|| Ok(Arc::new(Coverage::new(&scene, resolution)?)))?;
    let solve = time_solves(&study, &cover, jobs, watch)?;
    // The search makes coverages and solves, as many as that of the earlier trial.
    let grid = alike.map_or(found, |t| t.grid / (t.coverage + t.solve) * (coverage + solve));
    let each = 1.0 / volume(&study);
    Ok(Trial {
        variant,
        period_um: study.layer.period_um,
        thickness_um: study.layer.thickness_um,
        wanted: study.resolution,
        density: density(full),
        packing: packing * each,
        coverage: coverage * each,
        grid: grid * each,
        solve: solve * each,
        resolution,
    })
}

/// Core seconds, and what was made.
fn timed<T>(make: impl FnOnce() -> Result<T, RunError>) -> Result<(f64, T), RunError> {
    let (clock, before) = (Instant::now(), processor_seconds());
    let made = make()?;
    let wall = clock.elapsed().as_secs_f64();
    // Ticks of a hundredth of a second say nothing of less than a few of them.
    let used = processor_seconds().zip(before).map(|(after, before)| after - before).filter(|&s| s > 0.1);
    Ok((used.unwrap_or(wall), made))
}

/// Processor time of this process where the system tells it (Linux): other programs on the machine do not count.
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field, the name in brackets, may hold spaces; user and system ticks are the 14th and 15th.
    let mut ticks = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut next = || ticks.next()?.parse::<f64>().ok();
    Some((next()? + next()?) / 100.0)
}

/// Core seconds of one solve, the mean over a few that are spread over wavelengths and angles.
fn time_solves(
    study: &Study,
    coverage: &Arc<Coverage>,
    jobs: usize,
    watch: &dyn RunWatch,
) -> Result<f64, RunError> {
    let chosen: Vec<Point> = spread(&study.points(0), 6.max(2 * jobs));
    let solve = |i: usize| {
        // A failure costs about what a success does.
        let _ = solve_point(study, coverage, &chosen[i], "trial", watch);
    };
    let (seconds, ()) = timed(|| Ok(work_through(chosen.len(), jobs, || watch.stop(), solve)?))?;
    if watch.stop() {
        return Err(RunError::Stopped);
    }
    Ok(seconds / chosen.len() as f64)
}

/// The points and cells a µm of a trial in another cell.
fn full_resolution(trial: &Trial, study: &Study) -> Resolution {
    let scaled = |n: usize, axis: usize| match n {
        1 => 1,
        n => smooth_size((n as f64 * study.layer.period_um[axis] / trial.period_um[axis]).ceil() as usize),
    };
    let r = trial.resolution;
    let cells = (r.cells as f64 * study.layer.thickness_um / trial.thickness_um).ceil() as usize;
    Resolution { nx: scaled(r.nx, 0), ny: scaled(r.ny, 1), cells, ..r }
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

/// Different solves, and core seconds: each group at the rates of the trials with the nearest density of grains.
fn cost(sweep: &Sweep, groups: &[Vec<usize>], trials: &[Trial]) -> (usize, f64) {
    let (mut solves, mut seconds) = (0, 0.0);
    for group in groups {
        for (n, wanted) in resolutions(sweep, group).iter().enumerate() {
            let here = |v: &&usize| sweep.variants[**v].study.resolution == *wanted;
            let studies: Vec<&Study> = group.iter().filter(here).map(|&v| &sweep.variants[v].study).collect();
            let counts = Counts::of(&studies);
            solves += counts.solves;
            let distance = |t: &&Trial| (t.density / density(studies[0])).ln().abs();
            let alike = trials.iter().filter(|t| t.wanted == *wanted);
            let nearest = alike.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            // A layer without grains has no contrast to iterate on.
            if let (false, Some(trial)) = (studies[0].pigments.is_empty(), nearest) {
                // Resolutions share the packings of their group.
                let packings = if n == 0 { counts.packings } else { 0 };
                let once = trial.packing * packings as f64 + trial.coverage * counts.coverages as f64;
                let work = once + trial.grid * counts.grids as f64 + trial.solve * counts.solves as f64;
                seconds += volume(studies[0]) * work;
            }
        }
    }
    (solves, seconds)
}

/// What variants with the same packings and the same wanted resolution have to compute.
struct Counts {
    packings: usize,
    coverages: usize,
    grids: usize,
    solves: usize,
}

impl Counts {
    fn of(studies: &[&Study]) -> Self {
        let (mut solves, mut grids) = (HashSet::new(), HashSet::new());
        for study in studies {
            let method = (&study.solver, &study.goal);
            for r in 0..study.realisations {
                let key =
                    |p: &Point| Key::of("solve", &(r, study.indices(p.wavelength), p.incidence, method));
                solves.extend(study.points(r).iter().map(key));
            }
            let indices: Vec<_> = (0..study.wavelengths_nm.len()).map(|w| study.indices(w)).collect();
            grids.insert(Key::of("grid", &(&study.wavelengths_nm, &study.angles, indices, method)));
        }
        Self {
            packings: studies.iter().map(|s| s.realisations).max().unwrap_or(0),
            coverages: studies.iter().map(|s| s.realisations).sum(),
            grids: grids.len(),
            solves: solves.len(),
        }
    }
}
