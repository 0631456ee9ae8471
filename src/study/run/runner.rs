//! Carries a study out: for each realisation a packing and a coverage, for each wavelength and angle a solve.
//!
//! Every finished solve is in the store before the next begins, so a run that is stopped, or killed, leaves
//! what it finished, and the same study continues there. Solves that are in the store already, from whichever
//! study, are not repeated.

use super::realisation::{Packings, RealisationRun, point_keys};
use super::resolve::{Resolved, resolve};
use super::watch::RunWatch;
use crate::ink::PackError;
use crate::input::study::Study;
use crate::store::folder::OutputFolder;
use crate::wave::{Scene, WaveError};

pub use super::collected::Stores;
pub use super::collected::{Collected, Failure, Realisation, Refused, RunSettings};
pub use super::error::RunError;

/// Runs `study` into `folder` until it is finished, stopped, or nothing more can be done.
///
/// # Errors
/// No packing comes about, the resolution fails, or records cannot be written. A solve that fails is kept as a
/// [`Failure`], a packing that does as a [`Refused`]: neither stops the others.
pub fn run(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Collected, RunError> {
    run_until(study, folder, settings, watch, &|_| false)
}

/// Realisations between two looks at the bar: the same for everybody, so that a study ends at the same realisation again.
pub const BATCH: usize = 8;

/// As [`run`], but ends as soon as `enough` says so, asked after every realisation but the last.
///
/// # Errors
/// As [`run`].
pub fn run_until(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
    enough: &dyn Fn(&Collected) -> bool,
) -> Result<Collected, RunError> {
    run_on(study, folder, settings, watch, (None, enough))
}

/// As [`run_until`], on a grid that is known already.
///
/// # Errors
/// As [`run`].
pub fn run_on(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
    (grid, enough): (Option<Resolved>, &dyn Fn(&Collected) -> bool),
) -> Result<Collected, RunError> {
    let stores = Stores::open(folder)?;
    stores.database().prepare()?;
    let mut packings = Packings::new(study, watch);
    let scene = |r: usize| packings.get(r).map(|packing| Scene::from_packing(&packing));
    let chosen = || resolve(study, &stores.grids, settings.memory, watch, scene).map_err(stopped);
    let resolved = grid.map_or_else(chosen, Ok)?;
    let keys = |realisation| point_keys(study, &resolved, realisation);
    let kept = (0..study.realisations).flat_map(keys).filter(|(_, key)| stores.points.has(key.as_str()));
    let kept = kept.count();
    if kept < study.solves() {
        folder.begin()?;
    }
    watch.begins(study, kept);
    let mut collected = Collected {
        resolved,
        realisations: Vec::new(),
        refused: Vec::new(),
        enough: false,
        damages: Vec::new(),
    };
    let mut refusal = None;
    for realisation in 0..study.realisations {
        collected.enough = realisation > 0 && enough(&collected);
        if collected.enough || watch.stop() && !collected.realisations.is_empty() {
            break;
        }
        let run =
            RealisationRun { study, resolved: &resolved, stores: &stores, settings, watch, realisation };
        match run.finish(&mut packings).map_err(stopped) {
            Err(RunError::Stopped) => break,
            // A seed reproduces: what found no room never will, and the others are as good without it.
            Err(error) if error.has_no_room() => {
                collected.refused.push(Refused { realisation, reason: error.to_string() });
                refusal.get_or_insert(error);
            }
            result => collected.realisations.push(result?),
        }
    }
    if collected.realisations.is_empty() {
        return Err(refusal.unwrap_or(RunError::Stopped));
    }
    Ok(Collected { damages: stores.database().damages(), ..collected })
}

/// A stop is no failure of packing or grid.
pub fn stopped(error: RunError) -> RunError {
    match error {
        RunError::Packing { source: PackError::Stopped { .. }, .. } => RunError::Stopped,
        RunError::Resolution(error) if error.is_stop() => RunError::Stopped,
        RunError::Wave(WaveError::Stopped) => RunError::Stopped,
        other => other,
    }
}
