//! `--memory-gb`.

use inkwave::run::runner::RunSettings;
use miette::Result;

/// Bytes of so many GB.
///
/// # Errors
/// Not above 0, or no number.
pub fn bytes(gb: f64) -> Result<f64> {
    if gb.is_nan() || gb <= 0.0 {
        miette::bail!("--memory-gb is {gb}; it must be above 0: try 4");
    }
    Ok(1e9 * gb)
}

/// Settings of a run from `--jobs` and `--memory-gb`.
///
/// # Errors
/// See [`bytes`].
pub fn settings(jobs: Option<u16>, memory_gb: Option<f64>) -> Result<RunSettings> {
    let otherwise = RunSettings::default();
    let memory = memory_gb.map_or(Ok(otherwise.memory), bytes)?;
    Ok(RunSettings { jobs: jobs.map(usize::from), memory })
}
