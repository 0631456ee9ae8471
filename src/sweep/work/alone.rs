//! A study alone: a sweep of one variant, with its results at the top of the folder.

use super::run::{Scope, run};
use super::stored::collect;
use super::units::Shard;
use crate::input::study::Study;
use crate::run::watch::RunWatch;
use crate::run::{Collected, RunError, RunSettings, Stores};
use crate::store::folder::OutputFolder;
use crate::sweep::definition::load::Sweep;

/// What a run of a study has come to, over all processes of its folder.
#[derive(Debug)]
pub struct Ran {
    /// All that the folder has of the study.
    pub collected: Collected,
    /// Whether this process is the one to write the results.
    pub publishes: bool,
}

/// Runs `study` into `folder` until it is finished or stopped, together with other processes that do the same. What failed
/// before is tried again.
///
/// # Errors
/// No packing or grid comes about, or records cannot be written. A solve or a packing that fails is part of what is collected.
pub fn run_study(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Ran, RunError> {
    let settings = RunSettings { retry_failed: true, ..settings };
    let sweep = Sweep::of_one("", study.clone());
    let tally = run(&sweep, folder, (Shard::ALL, Scope::Solves), settings, watch)?;
    match stored(study, folder)? {
        Some(collected) => {
            let collected = Collected { damages: tally.damages, ..collected };
            Ok(Ran { collected, publishes: tally.publishes })
        }
        None => {
            if tally.publishes {
                // A folder without a result of any kind is not kept.
                Stores::open(folder)?.failures.remove_all()?;
            }
            Err(tally.failure.unwrap_or(RunError::Stopped))
        }
    }
}

/// What a folder has of a study; `None` before the first packing and grid.
///
/// # Errors
/// The records cannot be read.
pub fn stored(study: &Study, folder: &OutputFolder) -> std::io::Result<Option<Collected>> {
    Ok(collect(study, &Stores::open(folder)?))
}
