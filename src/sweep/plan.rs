//! What a sweep will cost, said before anything runs; calibrated by a few solves of the sweep itself.

mod trial;

use super::load::Sweep;
use super::units::{groups, units};
use crate::input::study::{Point, Study, WantedResolution};
use crate::run::realisation::Packings;
use crate::run::resolve::size;
use crate::run::runner::{RunError, stopped};
use crate::run::watch::RunWatch;
use crate::store::identity::Key;
use crate::wave::Scene;
use serde::Serialize;
use std::collections::HashSet;
use trial::{Trial, covers, density, full_resolution, time_solves, trial, volume};

/// Most variants that are tried.
const TRIALS: usize = 4;

/// The size of a sweep, and its cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Number of variants.
    pub variants: usize,
    /// Packings to be made; variants share them.
    pub packings: usize,
    /// Different solves; variants share them.
    pub solves: usize,
    /// Units that shards divide among them.
    pub units: usize,
    /// Unknowns of the largest solve among the variants tried, at full size.
    pub unknowns: usize,
    /// For one solve at a time, at most.
    pub memory_mb: usize,
    /// On one core, all in all.
    pub core_seconds: f64,
    /// What was tried, in words.
    pub calibration: String,
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
    let bytes = |t: &Trial| {
        let study = &sweep.variants[t.variant].study;
        size(study, full(t)).bytes(&*study.solver.build())
    };
    let most_bytes = trials.iter().map(bytes).fold(0.0, f64::max);
    let realisations = |g: &Vec<usize>| g.iter().map(|&v| sweep.variants[v].study.realisations).max();
    Ok(Plan {
        variants: sweep.variants.len(),
        packings: groups.iter().filter_map(realisations).sum(),
        solves,
        units: units(sweep).len(),
        unknowns,
        memory_mb: (1e-6 * most_bytes).ceil() as usize,
        core_seconds,
        calibration,
    })
}

fn in_words(sweep: &Sweep, trials: &[Trial]) -> String {
    let widest = trials.iter().map(|t| t.period_um[0].max(t.period_um[1])).fold(0.0, f64::max);
    let names: Vec<&str> = trials.iter().map(|t| sweep.variants[t.variant].name.as_str()).collect();
    format!("{} in cells of up to {widest} µm, scaled by volume", names.join(", "))
}

/// For each wanted resolution, variants with grains in the order of their density of grains, evenly spread over it.
fn representatives(sweep: &Sweep, groups: &[Vec<usize>]) -> Vec<usize> {
    let wanted = resolutions(sweep, &(0..sweep.variants.len()).collect::<Vec<_>>());
    let each = (TRIALS / wanted.len()).max(2);
    let of_resolution = |(n, wanted): (usize, &WantedResolution)| {
        let all = one_of_each(sweep, groups, n, wanted);
        spread(&by_density(sweep, all), each)
    };
    wanted.iter().enumerate().flat_map(of_resolution).collect()
}

/// One variant of each group with the wanted resolution number `n`.
fn one_of_each(sweep: &Sweep, groups: &[Vec<usize>], n: usize, wanted: &WantedResolution) -> Vec<usize> {
    let here = |v: &&usize| sweep.variants[**v].study.resolution == *wanted;
    // The inks of a group take turns, so that not all trials are of the first one.
    let member = |(k, group): (usize, &Vec<usize>)| {
        let members: Vec<usize> = group.iter().filter(here).copied().collect();
        members.get((k + n) % members.len().max(1)).copied()
    };
    groups.iter().enumerate().filter_map(member).collect()
}

/// Those of the variants that have grains, in the order of their density of grains; the first alone where none has.
fn by_density(sweep: &Sweep, all: Vec<usize>) -> Vec<usize> {
    let study = |v: usize| &sweep.variants[v].study;
    let mut some: Vec<usize> = all.iter().copied().filter(|&v| !study(v).pigments.is_empty()).collect();
    if some.is_empty() {
        some = all.into_iter().take(1).collect();
    }
    some.sort_by(|&a, &b| density(study(a)).total_cmp(&density(study(b))));
    some
}

/// So many at most of the variants in a list, evenly spread from its first to its last.
fn spread(list: &[usize], most: usize) -> Vec<usize> {
    let (count, last) = (list.len().min(most), list.len().saturating_sub(1));
    (0..count).map(|k| list[k * last / (count - 1).max(1)]).collect()
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
    let grids = (full_resolution(trial, &variant.study), trial.longer_waves);
    let covers = covers(&variant.study, &scene, grids)?;
    let solve = time_solves(&variant.study, &covers, jobs, watch)? / volume(&variant.study);
    Ok(Some((variant.name.clone(), solve / trial.solve)))
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
                let key = |p: &Point| {
                    let indices = study.indices(p.incidence.wavelength_um);
                    Key::of("solve", &(r, indices, p.incidence, p.polarisation, method))
                };
                solves.extend(study.points(r).iter().map(key));
            }
            let indices: Vec<_> = study.wavelengths_nm.iter().map(|nm| study.indices(1e-3 * nm)).collect();
            let light = (&study.wavelengths_nm, &study.angles, study.wave.is_vector());
            grids.insert(Key::of("grid", &(light, indices, method)));
        }
        Self {
            packings: studies.iter().map(|s| s.realisations).max().unwrap_or(0),
            coverages: studies.iter().map(|s| s.realisations).sum(),
            grids: grids.len(),
            solves: solves.len(),
        }
    }
}
