//! `--memory-gb`, and what the process is allowed.

use inkwave::run::RunSettings;
use inkwave::run::memory::allowed;
use miette::{Result, miette};

/// Bytes of so many GB, or what the process's limits leave of them.
///
/// # Errors
/// Not above 0, or no number.
pub fn bytes(gb: f64) -> Result<f64> {
    if gb.is_nan() || gb <= 0.0 {
        miette::bail!("--memory-gb is {gb}; it must be above 0: try 4");
    }
    Ok((1e9 * gb).min(allowed()))
}

/// Settings of a run from `--jobs` and `--memory-gb`.
///
/// # Errors
/// See [`bytes`].
pub fn settings(jobs: Option<u16>, memory_gb: Option<f64>) -> Result<RunSettings> {
    let otherwise = RunSettings::default();
    let memory = memory_gb.map_or(Ok(otherwise.memory), bytes)?;
    Ok(RunSettings { jobs: jobs.map(usize::from), memory, ..otherwise })
}

/// Bytes beside the solves: threads with their stacks, packings, pages and pictures.
const LEAST_LEFT: f64 = 96e6;

/// Starts the threads that all work is done with, and sees that there is memory to begin with.
///
/// # Errors
/// The system refuses threads, or leaves less memory than any work takes: said now, as nothing could be said later.
pub fn start_threads() -> Result<()> {
    let left = allowed();
    if left < LEAST_LEFT {
        let help = "raise the limit (ulimit -v, ulimit -d, or the cgroup's), or take another machine";
        let [left, least] = [left, LEAST_LEFT].map(|bytes| (1e-6 * bytes).floor());
        return Err(miette!(
            help = help,
            "{left} MB of memory are left to this process; {least} MB are needed"
        ));
    }
    let started = rayon::ThreadPoolBuilder::new().build_global();
    let help = "allow more processes or memory (ulimit -u, ulimit -v), or fewer threads: RAYON_NUM_THREADS=1";
    started.map_err(|error| miette!(help = help, "cannot start threads: {error}"))
}
