//! A single study, worked off as one variant; its results are written to the top of the folder.
//! A composed layer is one ordinary study for each of its slabs, in one store.

use super::rounds::collect;
use super::run::{Scope, name, run};
use super::units::Shard;
use crate::input::study::Study;
use crate::run::resolve::Resolved;
use crate::run::watch::{Event, RunWatch};
use crate::run::{Collected, RunError, RunSettings, Stores, resolve};
use crate::solve::accuracy::grid_error::JUDGEMENT;
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::queue::QueueError;
use crate::work::variant::of_one;
use std::time::Duration;

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
    let variants = of_one("", study.clone());
    let tally = run(&variants, folder, (Shard::ALL, Scope::Solves), settings, watch)?;
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

/// Pause between two looks at what other processes have done.
const BETWEEN_LOOKS: Duration = Duration::from_millis(500);

/// Result of running the portions of a composed layer, over all processes of the folder.
#[derive(Debug)]
pub struct RanPortions {
    /// Every portion with what was computed for it; those that a stop left out are missing.
    pub solved: Vec<(Study, Collected)>,
    /// Whether this process has to write the results.
    pub publishes: bool,
}

/// Runs the portions of a composed layer one after another; all have the grid of the first.
/// Processes that run the same layer in one folder share the work on each portion, and wait for
/// each other between portions.
///
/// # Errors
/// As [`run_study`]; stopped before any realisation.
pub fn run_portions(
    study: &Study,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<RanPortions, RunError> {
    let portions = study.portions();
    let work = |portion: &Study| name(&of_one("", portion.clone()), Shard::ALL, Scope::Solves);
    let ours: Vec<Key> = portions.iter().map(work).collect();
    let mut ran = RanPortions { solved: Vec::new(), publishes: true };
    for portion in portions {
        let stores = Stores::open(folder)?;
        match ran.solved.first() {
            Some((_, first)) => stores.grids.put(resolve::key(&portion).as_str(), &first.resolved)?,
            None => take_grid_of_more_wavelengths(&portion, &stores)?,
        }
        drop(stores);
        watch.stage(&portion.title);
        match run_portion(&portion, &ours, folder, settings, watch) {
            Err(RunError::Stopped) if !ran.solved.is_empty() => break,
            done => {
                let Ran { collected, publishes } = done?;
                if ran.solved.is_empty() {
                    keep_grid_for_fewer_wavelengths(&portion, &collected.resolved, &Stores::open(folder)?)?;
                }
                ran.solved.push((portion, collected));
                ran.publishes = publishes;
            }
        }
    }
    Ok(ran)
}

/// Runs one portion, unless everything of it is stored already; waits while other processes are at
/// work on another portion of `ours`.
fn run_portion(
    portion: &Study,
    ours: &[Key],
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Ran, RunError> {
    let mut damages = Vec::new();
    loop {
        let stores = Stores::open(folder)?;
        let stored = collect(portion, &stores, 0);
        damages.extend(stores.database().damages());
        drop(stores);
        if let Some(collected) = stored.filter(|stored| stored.finished() == portion.solves()) {
            watch.hear(Event::Kept(collected.finished()));
            return Ok(Ran { collected: Collected { damages, ..collected }, publishes: true });
        }
        match run_study(portion, folder, settings, watch) {
            Err(RunError::Queue(QueueError::OtherWork { name, .. }))
                if ours.iter().any(|key| key.as_str() == name) =>
            {
                if watch.stop() {
                    return Err(RunError::Stopped);
                }
                std::thread::sleep(BETWEEN_LOOKS);
            }
            ran => {
                let mut ran = ran?;
                ran.collected.damages.splice(0..0, damages);
                return Ok(ran);
            }
        }
    }
}

/// Content hash of a portion with a single wavelength of its list: all that its grid must resolve.
fn key_at(portion: &Study, wavelength_nm: f64) -> Key {
    let packing = Key::of_packing(&portion.packing_request(0));
    let indices = portion.indices(1e-3 * wavelength_nm);
    let method = (&portion.resolution, &portion.solver, &portion.goal, JUDGEMENT);
    Key::of_wave("grid at", &(packing, indices, wavelength_nm, method), portion.vector_wave())
}

/// Notes for every wavelength the grid that it was solved on, unless it has one.
fn keep_grid_for_fewer_wavelengths(
    portion: &Study,
    resolved: &Resolved,
    stores: &Stores,
) -> std::io::Result<()> {
    for &nm in &portion.wavelengths_nm {
        let key = key_at(portion, nm);
        if !stores.grids.has(key.as_str()) {
            stores.grids.put(key.as_str(), resolved)?;
        }
    }
    Ok(())
}

/// If all wavelengths of a portion were solved before on one grid, as part of a longer list, it is
/// this portion's grid too: so these solves are used again.
fn take_grid_of_more_wavelengths(portion: &Study, stores: &Stores) -> std::io::Result<()> {
    if resolve::kept(portion, &stores.grids).is_some() {
        return Ok(());
    }
    let at = |nm: &f64| stores.grids.get(key_at(portion, *nm).as_str());
    let grids: Option<Vec<Resolved>> = portion.wavelengths_nm.iter().map(at).collect();
    match grids.as_deref() {
        Some([first, others @ ..]) if others.iter().all(|other| other == first) => {
            stores.grids.put(resolve::key(portion).as_str(), first)
        }
        _ => Ok(()),
    }
}
