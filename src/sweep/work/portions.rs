//! Carries out a composed layer: one ordinary study for each of its slabs, in one store.

use super::alone::run_study;
use crate::input::study::Study;
use crate::run::watch::RunWatch;
use crate::run::{Collected, RunError, RunSettings, Stores, resolve};
use crate::store::folder::OutputFolder;

/// Runs the portions of a composed layer one after another; all have the grid of the first. Those that
/// a stop left out are missing.
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
