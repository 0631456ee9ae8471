//! A single study, run as a sweep of one variant; its results are written to the top of the folder.
//! A composed layer is one ordinary study for each of its slabs, in one store.

use super::rounds::collect;
use super::run::{Scope, run};
use super::units::Shard;
use crate::input::study::Study;
use crate::run::watch::RunWatch;
use crate::run::{Collected, RunError, RunSettings, Stores, resolve};
use crate::store::folder::OutputFolder;
use crate::sweep::definition::load::Sweep;

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
    let settings = RunSettings { retry_failed: true, ..settings };
    let sweep = Sweep::of_one("", study.clone());
    let tally = run(&sweep, folder, (Shard::ALL, Scope::Solves), settings, watch)?;
    let stores = Stores::open(folder)?;
    let Some(collected) = collect(study, &stores, tally.known[0]) else {
        if tally.publishes {
            // A folder without any result is removed.
            stores.failures.remove_all()?;
        }
        return Err(tally.failure.unwrap_or(RunError::Stopped));
    };
    Ok(Ran { collected: Collected { damages: tally.damages, ..collected }, publishes: tally.publishes })
}

/// Everything stored for a study; `None` before the first packing and grid.
///
/// # Errors
/// The records cannot be read.
pub fn stored(study: &Study, folder: &OutputFolder) -> std::io::Result<Option<Collected>> {
    Ok(collect(study, &Stores::open(folder)?, 0))
}

/// Runs the portions of a composed layer one after another; all have the grid of the first. Those
/// that a stop left out are missing.
///
/// # Errors
/// As [`run_study`]; stopped before any realisation.
pub fn run_portions(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Vec<(Study, Collected)>, RunError> {
    let mut done: Vec<(Study, Collected)> = Vec::new();
    for portion in study.portions() {
        if let Some((_, first)) = done.first() {
            Stores::open(folder)?.grids.put(resolve::key(&portion).as_str(), &first.resolved)?;
        }
        watch.stage(&portion.title);
        match run_study(&portion, folder, settings, watch) {
            Err(RunError::Stopped) if !done.is_empty() => break,
            result => done.push((portion, result?.collected)),
        }
    }
    Ok(done)
}
