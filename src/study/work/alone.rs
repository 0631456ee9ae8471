//! A single study, worked off as one variant; its results are written to the top of the folder.
//! Of a composed layer the slabs are worked off, which share one store.

use super::rounds::collect;
use super::run::{Scope, Tally, run};
use super::units::Shard;
use crate::evaluate::composed::level::SolvedPortion;
use crate::evaluate::evaluated::FinishedSolves;
use crate::input::study::Study;
use crate::run::watch::RunWatch;
use crate::run::{Collected, RunError, RunSettings, Stores};
use crate::store::folder::OutputFolder;
use crate::store::seal::Damage;
use crate::work::variant::of_one;

/// Result of running a study, over all processes of the folder.
#[derive(Debug)]
pub struct Ran {
    /// Everything computed for the study.
    pub collected: Collected,
    /// Whether this process has to write the results.
    pub publishes: bool,
}

/// Runs `study` in `folder` until it is finished or stopped, sharing the work with other processes
/// that run it there. What failed before is retried.
///
/// # Errors
/// No realisation could be packed, no grid was found, or records cannot be written. A single failed
/// solve or packing is not an error: it is part of what is collected.
pub fn run_study(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Ran, RunError> {
    let tally = run_alone(study, folder, settings, watch)?;
    let stores = Stores::open(folder)?;
    let Some(collected) = collect(study, &stores, tally.known[0]) else {
        return Err(no_result(tally, &stores));
    };
    Ok(Ran { collected: Collected { damages: tally.damages, ..collected }, publishes: tally.publishes })
}

/// Everything stored for a study, or for the slabs of a composed one; `None` before the first
/// packing and grid.
pub fn stored(study: &Study, stores: &Stores) -> Option<FinishedSolves> {
    if study.composed().is_none() {
        return collect(study, stores, 0).map(|collected| FinishedSolves::Whole(Box::new(collected)));
    }
    Some(stored_portions(study, stores)).filter(|slabs| !slabs.is_empty()).map(FinishedSolves::Slabs)
}

/// Result of running any study, over all processes of the folder.
#[derive(Debug)]
pub struct RanStudy {
    /// Everything computed for the study.
    pub solved: FinishedSolves,
    /// Damage that this process found in the store; what is needed has been recomputed.
    pub damages: Vec<Damage>,
    /// Whether this process has to write the results.
    pub publishes: bool,
}

/// Runs a layer as a whole with [`run_study`], or the slabs of a composed one with
/// [`run_portions`].
///
/// # Errors
/// As these.
pub fn run_any_study(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<RanStudy, RunError> {
    if study.composed().is_some() {
        let RanPortions { solved, damages, publishes } = run_portions(study, folder, settings, watch)?;
        return Ok(RanStudy { solved: FinishedSolves::Slabs(solved), damages, publishes });
    }
    let Ran { collected, publishes } = run_study(study, folder, settings, watch)?;
    let damages = collected.damages.clone();
    Ok(RanStudy { solved: FinishedSolves::Whole(Box::new(collected)), damages, publishes })
}

/// Result of running the slabs of a composed layer, over all processes of the folder.
#[derive(Debug)]
pub struct RanPortions {
    /// Every slab with what was computed for it; those that a stop left out are missing.
    pub solved: Vec<SolvedPortion>,
    /// Damage that this process found in the store; what the layer needs has been recomputed.
    pub damages: Vec<Damage>,
    /// Whether this process has to write the results.
    pub publishes: bool,
}

/// Runs the slabs of a composed layer in `folder`, like [`run_study`].
///
/// # Errors
/// As [`run_study`]: of one slab, no realisation could be packed, or no grid was found; stopped
/// before the first realisation of any slab.
pub fn run_portions(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<RanPortions, RunError> {
    let tally = run_alone(study, folder, settings, watch)?;
    let stores = Stores::open(folder)?;
    let solved = stored_portions(study, &stores);
    let is_cut_short = watch.stop() && !solved.is_empty();
    if solved.len() < study.portions().len() && !is_cut_short {
        return Err(no_result(tally, &stores));
    }
    Ok(RanPortions { solved, damages: tally.damages, publishes: tally.publishes })
}

/// Every slab of a composed layer with everything that is stored for it; those of which nothing is
/// stored are left out.
pub fn stored_portions(study: &Study, stores: &Stores) -> Vec<SolvedPortion> {
    let mut solved = Vec::new();
    for portion in study.portions() {
        if let Some(collected) = collect(&portion, stores, 0) {
            solved.push((portion, collected));
        }
    }
    solved
}

/// Works off a single study; what failed before is retried.
fn run_alone(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Tally, RunError> {
    let settings = RunSettings { retry_failed: true, ..settings };
    run(&of_one("", study.clone()), folder, (Shard::ALL, Scope::Solves), settings, watch)
}

/// Why a study has no result at all; the process that would publish removes the recorded failures,
/// because a folder without any result is removed.
fn no_result(tally: Tally, stores: &Stores) -> RunError {
    let removed = if tally.publishes { stores.failures.remove_all() } else { Ok(()) };
    removed.err().map_or_else(|| tally.failure.unwrap_or(RunError::Stopped), RunError::Store)
}
