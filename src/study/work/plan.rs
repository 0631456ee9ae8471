//! Estimates the cost of studies before they run, calibrated by a few of their own solves.

mod deadline;
mod scaled;
mod search;
mod trial;
mod usual_grid;

use super::units::{groups, units};
use crate::input::study::{Study, WantedResolution};
use crate::run::realisation::Packings;
use crate::run::resolve::{self, size};
use crate::run::watch::RunWatch;
use crate::run::{RunError, RunSettings};
use crate::solve::demand::memory_in_words;
use crate::solve::{Size, Solver};
use crate::store::identity::Key;
use crate::work::variant::{Variant, solved_for};
use deadline::{Deadline, PlanClock};
use scaled::scaled;
use serde::Serialize;
use std::collections::HashSet;
use trial::{
    MOST_GRAINS, Trial, covers, density, drawn_volume_um3, full_resolution, grains, in_small_cell,
    time_solves, trial,
};

/// Maximum number of trial variants.
const TRIALS: usize = 4;
/// Time limit of the trials, s: a plan takes less than ten seconds where it has the machine for
/// itself, and at most three times as long where other programs take most of it.
const LIMIT: f64 = 7.0;
/// Work that takes longer on the available cores is out of reach: one month.
const REACH_SECONDS: f64 = 30.0 * 24.0 * 3600.0;

/// Largest expected factor between cost and forecast, either way, where every kind of solve was
/// tried: small cells, few packings, and processors whose speed depends on what else they do.
const TRIED_FACTOR: f64 = 2.5;
/// That factor where the grid is what an unfinished search suggests, or the usual one for such
/// waves.
const USUAL_GRID_FACTOR: f64 = 4.0;
/// That factor where a cost follows from unknowns and usual numbers of operator applications.
const BY_SIZE_FACTOR: f64 = 10.0;

/// Size and expected cost of one study or of the variants of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Number of variants.
    pub variants: usize,
    /// Number of different packings; variants may share them.
    pub packings: usize,
    /// Number of different solves; variants may share them.
    pub solves: usize,
    /// Number of units that can be distributed over shards.
    pub units: usize,
    /// Unknowns of the largest solve among the trial variants, at full size.
    pub unknowns: usize,
    /// Maximum memory of one solve, MB.
    pub memory_mb: usize,
    /// Total time on one core, s: of the processor, whatever else the machine does meanwhile.
    pub core_seconds: f64,
    /// Range that `core_seconds` is expected to lie in: a factor of two and a half either way where
    /// solves were tried, of four where their grid is not known, of ten where the size alone is
    /// known.
    pub core_seconds_range: [f64; 2],
    /// Describes the trials.
    pub calibration: String,
    /// Why they cannot be computed here, if time or memory are far from sufficient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out_of_reach: Option<String>,
}

/// Counts solves and times a few of them, `jobs` at a time.
///
/// Trial variants are spread over the densities of grains and run in small cells, with a sample of
/// their solves. One of them is also solved at full size, which gives the ratio of the costs per
/// µm³. Everything else is scaled by volume. For each requested resolution the grid is searched
/// once, for the fewest grains; the other variants use the same grid. Where the search exceeds its
/// time, the errors and the cost of the grids tried tell what the next would need; if there are
/// none, solves are tried on the usual grid for such waves; a trial without any solve in time is
/// replaced by an estimate from unknowns and operator applications.
///
/// # Errors
/// No trial variant can be packed and solved, or the watch requests a stop.
pub fn plan(variants: &[Variant], settings: RunSettings, watch: &dyn RunWatch) -> Result<Plan, RunError> {
    let variants = &*solved_for(variants);
    let jobs = settings.jobs.unwrap_or_else(rayon::current_num_threads);
    let deadline = Deadline { watch, jobs, clock: PlanClock::start(), end: LIMIT };
    let (mut trials, late) = tried(&representatives(variants), &deadline)?;
    let mut calibration = in_words(&trials);
    if let Some((name, factor)) = at_full_size(&trials, &deadline)? {
        calibration += &format!("; at full size {name} takes {factor:.2} times as long per µm³");
        trials.iter_mut().for_each(|t| (t.solve, t.grid) = (t.solve * factor, t.grid * factor));
    }
    calibration += &late_in_words(&late, trials.is_empty());
    let factor = match late.is_empty() {
        true if trials.iter().all(|trial| trial.has_grid) => TRIED_FACTOR,
        true => USUAL_GRID_FACTOR,
        false => BY_SIZE_FACTOR,
    };
    trials.extend(late.into_iter().map(scaled));
    Ok(costed(variants, &trials, calibration, factor, settings))
}

/// Estimates the cost from the size alone, without trials.
pub fn by_size(variants: &[Variant], settings: RunSettings) -> Plan {
    let variants = &*solved_for(variants);
    let all = representatives(variants);
    let trials: Vec<Trial> = all.iter().copied().map(scaled).collect();
    costed(variants, &trials, late_in_words(&all, true), BY_SIZE_FACTOR, settings)
}

fn variants_of_groups(variants: &[Variant]) -> Vec<Vec<&Variant>> {
    groups(variants).iter().map(|group| group.iter().map(|&v| &variants[v]).collect()).collect()
}

/// Trials that finished in time, and the variants whose trials did not.
type Tried<'a> = (Vec<Trial<'a>>, Vec<&'a Variant>);

/// Tries one variant after another.
fn tried<'a>(variants: &[&'a Variant], deadline: &Deadline) -> Result<Tried<'a>, RunError> {
    let mut trials = Vec::new();
    let mut late = Vec::new();
    let mut failure = None;
    // a part of the time for a solve at full size, where the trials are smaller
    let periods_differ = |study: &Study| in_small_cell(study).layer.period_um != study.layer.period_um;
    let at_full_size = usize::from(variants.iter().any(|variant| periods_differ(&variant.study)));
    for (place, &variant) in variants.iter().enumerate() {
        let part = deadline.part(variants.len() - place + at_full_size);
        part.stage(&format!("calibrating with {} in a small cell", variant.name));
        let alike = trials.iter().find(|t: &&Trial| t.study.resolution == variant.study.resolution);
        match trial(variant, alike, &part).map_err(RunError::stopped) {
            Ok(trial) => trials.push(trial),
            Err(RunError::Stopped) if deadline.watch.stop() => return Err(RunError::Stopped),
            Err(RunError::Stopped) => late.push(variant),
            Err(error) => failure = Some(error),
        }
    }
    match failure {
        Some(error) if trials.is_empty() && late.is_empty() => Err(error),
        _ => Ok((trials, late)),
    }
}

/// The plan based on the trials, described in words, with the factor by which it may be wrong.
fn costed(
    variants: &[Variant],
    trials: &[Trial],
    calibration: String,
    factor: f64,
    settings: RunSettings,
) -> Plan {
    let groups = variants_of_groups(variants);
    let (solves, core_seconds) = cost(&groups, trials);
    let mut unknowns = 0;
    let mut most_bytes = 0.0_f64;
    for trial in trials {
        let study = &trial.variant.study;
        let r = full_resolution(trial, study);
        unknowns = unknowns.max(r.nx * r.ny * r.planes());
        most_bytes = most_bytes.max(bytes(&size(study, r), &*study.solver.build(), settings));
    }
    let packings = groups.iter().filter_map(|group| group.iter().map(|v| v.study.realisations).max()).sum();
    let units = units(variants).len();
    let variants = variants.len();
    let memory_mb = (1e-6 * most_bytes).ceil() as usize;
    let out_of_reach = out_of_reach(core_seconds, most_bytes, settings.memory);
    let core_seconds_range = [core_seconds / factor, core_seconds * factor];
    Plan {
        variants,
        packings,
        solves,
        units,
        unknowns,
        memory_mb,
        core_seconds,
        core_seconds_range,
        calibration,
        out_of_reach,
    }
}

/// Memory of a solve beside others at a time, or alone; if neither is enough, what it would need.
fn bytes(size: &Size, solver: &dyn Solver, settings: RunSettings) -> f64 {
    let jobs = settings.jobs.unwrap_or_else(rayon::current_num_threads).max(1) as f64;
    let within = |bytes: f64| size.admit(solver, bytes).map(|admitted| admitted.bytes);
    let alone = within(settings.memory / jobs).or_else(|_| within(settings.memory));
    alone.unwrap_or_else(|too_large| 1e9 * too_large.need_gb)
}

/// Why the available cores and memory do not suffice; `None` if they do.
fn out_of_reach(core_seconds: f64, bytes: f64, memory: f64) -> Option<String> {
    let cores = rayon::current_num_threads() as f64;
    let need = memory_in_words(1e-9 * bytes);
    let free = memory_in_words(1e-9 * memory);
    if bytes > memory {
        return Some(format!("estimated {need} for one solve, of {free}"));
    }
    let days = core_seconds / cores / (24.0 * 3600.0);
    (core_seconds / cores > REACH_SECONDS).then(|| format!("estimated {days:.0} days on {cores} cores"))
}

fn names<'a>(variants: impl IntoIterator<Item = &'a Variant>) -> String {
    variants.into_iter().map(|variant| variant.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Reports the variants whose trials did not finish in time.
fn late_in_words(late: &[&Variant], alone: bool) -> String {
    if late.is_empty() {
        return String::new();
    }
    let start = if alone { "" } else { "; " };
    let names = names(late.iter().copied());
    format!(
        "{start}the number of unknowns and the usual number of operator applications ({names}: no trial finished in time)"
    )
}

fn in_words(trials: &[Trial]) -> String {
    if trials.is_empty() {
        return String::new();
    }
    let widest = trials.iter().flat_map(|t| t.study.layer.period_um).fold(0.0, f64::max);
    let names = names(trials.iter().map(|trial| trial.variant));
    let unsearched = trials.iter().filter(|trial| !trial.has_grid).map(|trial| trial.variant);
    let usual = match self::names(unsearched) {
        none if none.is_empty() => String::new(),
        some => format!(" (on a likely grid, as no search of one ended in time: {some})"),
    };
    format!("trial solves of {names} in cells of up to {widest} µm{usual}, scaled by volume")
}

/// For each requested resolution, variants evenly spread over the densities of grains.
fn representatives(variants: &[Variant]) -> Vec<&Variant> {
    let groups = variants_of_groups(variants);
    let requested = resolutions(&variants.iter().collect::<Vec<_>>());
    let each = (TRIALS / requested.len()).max(2);
    let mut chosen = Vec::new();
    for (n, requested) in requested.into_iter().enumerate() {
        let mut all = Vec::new();
        for (k, group) in groups.iter().enumerate() {
            let members = with_resolution(group, requested);
            // takes the inks of a group in turn, so that the trials do not all use the first
            all.extend(members.get((k + n) % members.len().max(1)));
        }
        chosen.extend(spread(&by_density(all), each));
    }
    chosen
}

/// Those variants of a group that request this resolution.
fn with_resolution<'a>(group: &[&'a Variant], requested: WantedResolution) -> Vec<&'a Variant> {
    group.iter().copied().filter(|variant| variant.study.resolution == requested).collect()
}

/// The variants with grains, ordered by their density; the first variant if none has grains.
fn by_density(all: Vec<&Variant>) -> Vec<&Variant> {
    let first = all.first().copied();
    let mut some: Vec<&Variant> = all.into_iter().filter(|v| !v.study.pigments.is_empty()).collect();
    some.sort_by(|a, b| density(&a.study).total_cmp(&density(&b.study)));
    if some.is_empty() { first.into_iter().collect() } else { some }
}

/// At most `most` variants of a list, evenly spread from the first to the last.
fn spread<'a>(list: &[&'a Variant], most: usize) -> Vec<&'a Variant> {
    let count = list.len().min(most);
    let last = list.len().saturating_sub(1);
    (0..count).map(|k| list[k * last / (count - 1).max(1)]).collect()
}

/// The different requested resolutions of the variants.
fn resolutions(variants: &[&Variant]) -> Vec<WantedResolution> {
    let mut different = Vec::new();
    for requested in variants.iter().map(|variant| variant.study.resolution) {
        if !different.contains(&requested) {
            different.push(requested);
        }
    }
    different
}

/// Solves the variant with the fastest packing at full size; returns its name and the cost per µm³
/// relative to the small cell.
fn at_full_size<'a>(trials: &[Trial<'a>], deadline: &Deadline) -> Result<Option<(&'a str, f64)>, RunError> {
    let Some(trial) = trials.iter().min_by(|a, b| a.packing.total_cmp(&b.packing)) else { return Ok(None) };
    let Variant { name, study, .. } = trial.variant;
    if study.layer.period_um == trial.study.layer.period_um || grains(study) > MOST_GRAINS {
        return Ok(None);
    }
    deadline.stage(&format!("calibrating with {name} at full size"));
    match full_solve(trial, study, deadline).map_err(RunError::stopped) {
        Ok(solve) => Ok(Some((name, solve / trial.solve))),
        Err(RunError::Stopped) if !deadline.watch.stop() => Ok(None),
        Err(error) => Err(error),
    }
}

/// Core seconds per µm³ of a solve at full size.
fn full_solve(trial: &Trial, study: &Study, watch: &Deadline) -> Result<f64, RunError> {
    let grids = (full_resolution(trial, study), trial.longer_waves);
    let covers = covers(study, Packings::new(study, watch).get(0)?, grids, watch)?;
    Ok(time_solves(study, &covers, watch)? / drawn_volume_um3(study, 0))
}

/// Number of different solves, and core seconds: each group at the rates of the trials with the
/// nearest density of grains and thickness.
fn cost(groups: &[Vec<&Variant>], trials: &[Trial]) -> (usize, f64) {
    let mut solves = 0;
    let mut seconds = 0.0;
    // layers of different packings may share the choice of their grid, as slabs of one layer do
    let mut chosen = HashSet::new();
    for group in groups {
        for (n, requested) in resolutions(group).into_iter().enumerate() {
            let studies: Vec<&Study> =
                with_resolution(group, requested).into_iter().map(|variant| &variant.study).collect();
            let work = PlannedWork::of(&studies);
            solves += work.solves;
            let grids = studies.iter().filter(|study| chosen.insert(resolve::key(study))).count();
            let alike = trials.iter().filter(|t| t.study.resolution == requested);
            let nearest = alike.min_by(|a, b| apart(a, studies[0]).total_cmp(&apart(b, studies[0])));
            // without grains there is no contrast to iterate on
            if let (false, Some(trial)) = (studies[0].pigments.is_empty(), nearest) {
                let realisations = studies.iter().map(|study| study.realisations);
                // resolutions share the packings of their group
                let packings = if n == 0 { realisations.max().unwrap_or(0) } else { 0 };
                let once = trial.packing * packings as f64 + trial.coverage * work.coverages;
                let all = once + trial.grid * grids as f64 + trial.solve * work.in_solves;
                seconds += mean_volume_um3(studies[0]) * all;
            }
        }
    }
    (solves, seconds)
}

/// How far a trial is from a study: the logarithms of the ratios of their densities of grains and
/// of their thicknesses.
fn apart(trial: &Trial, study: &Study) -> f64 {
    // without grains in both there is nothing to compare
    let densities =
        if density(study) > 0.0 { (density(&trial.study) / density(study)).ln().abs() } else { 0.0 };
    densities + (trial.study.layer.thickness_um / study.layer.thickness_um).ln().abs()
}

/// Realisations whose cells are drawn for the mean of their volumes.
const CELLS_DRAWN: usize = 64;

/// Mean volume of the cells of the realisations, µm³.
fn mean_volume_um3(study: &Study) -> f64 {
    let count = study.realisations.clamp(1, CELLS_DRAWN);
    (0..count).map(|realisation| drawn_volume_um3(study, realisation)).sum::<f64>() / count as f64
}

/// Cost of a solve or a coverage on the finer grid of a realisation that is checked, relative to
/// the study's grid: the ratio of their unknowns.
const FINER_COST: f64 = 2.4;

/// The work on variants with the same packings and the same requested resolution.
struct PlannedWork {
    /// Number of different solves.
    solves: usize,
    /// The work on them, in solves on the study's grid.
    in_solves: f64,
    /// The work on coverages, in those of the study's grid.
    coverages: f64,
}

impl PlannedWork {
    fn of(studies: &[&Study]) -> Self {
        let mut plain = HashSet::new();
        let mut moved = 0;
        let mut finer = 0;
        let mut coverages = 0.0;
        for study in studies {
            let method = (&study.solver, &study.goal);
            for r in 0..study.realisations {
                plain.extend(study.points(r).iter().map(|p| {
                    let indices = study.indices(p.incidence.wavelength_um);
                    Key::of("solve", &(r, indices, p.incidence, p.polarisation, method))
                }));
                let is_checked = study.is_checked(r);
                finer += if is_checked { study.solves_each() } else { 0 };
                moved += study.solves_each() * study.moves_of(r).len();
                coverages += if is_checked { 1.0 + FINER_COST } else { 1.0 };
            }
        }
        let solves = plain.len() + moved + finer;
        let in_solves = (plain.len() + moved) as f64 + FINER_COST * finer as f64;
        Self { solves, in_solves, coverages }
    }
}
