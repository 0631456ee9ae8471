//! A single study, run as a sweep of one variant; its results are written to the top of the folder.

use super::rounds::collect;
use super::run::{Scope, run};
use super::units::Shard;
use crate::input::study::Study;
use crate::run::watch::RunWatch;
use crate::run::{Collected, RunError, RunSettings, Stores};
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
    let known = tally.known.first().copied().unwrap_or(0);
    match collect(study, &Stores::open(folder)?, known) {
        Some(collected) => {
            let collected = Collected { damages: tally.damages, ..collected };
            Ok(Ran { collected, publishes: tally.publishes })
        }
        None => {
            if tally.publishes {
                // A folder without any result is removed.
                Stores::open(folder)?.failures.remove_all()?;
            }
            Err(tally.failure.unwrap_or(RunError::Stopped))
        }
    }
}

/// Everything stored for a study; `None` before the first packing and grid.
///
/// # Errors
/// The records cannot be read.
pub fn stored(study: &Study, folder: &OutputFolder) -> std::io::Result<Option<Collected>> {
    Ok(collect(study, &Stores::open(folder)?, 0))
}
