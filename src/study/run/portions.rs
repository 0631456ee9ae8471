//! Carries out a composed layer: one ordinary study for each of its slabs, in one store.

use super::runner::{Collected, RunError, RunSettings, run_on};
use super::watch::RunWatch;
use crate::input::study::Study;
use crate::store::folder::OutputFolder;

/// Runs the portions of a composed layer one after another; all have the grid of the first. Those that
/// a stop left out are missing.
///
/// # Errors
/// As [`super::runner::run`]; stopped before any realisation.
pub fn run_portions(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Vec<(Study, Collected)>, RunError> {
    let mut done: Vec<(Study, Collected)> = Vec::new();
    for portion in study.portions() {
        let grid = done.first().map(|(_, first)| first.resolved);
        watch.stage(&portion.title);
        match run_on(&portion, folder, settings, watch, (grid, &|_| false)) {
            Err(RunError::Stopped) if !done.is_empty() => break,
            result => done.push((portion, result?)),
        }
    }
    Ok(done)
}
