//! Options and output folders of commands that solve.

use super::again::this_command;
use super::diagnostics::folder_report;
use super::memory::bytes;
use clap::Args;
use inkwave::input::load::stem;
use inkwave::run::RunSettings;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use miette::Result;
use std::path::{Path, PathBuf};

/// Where the results go, and what the solves may take.
#[derive(Debug, Args)]
pub struct WorkArgs {
    /// Output folder (created if missing; interrupted work is resumed)
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Number of parallel solves (default: number of processors); fewer need less memory
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Memory for all parallel solves, GB (default: four fifths of the free memory)
    #[arg(long, value_name = "GB", allow_negative_numbers = true)]
    pub memory_gb: Option<f64>,
    /// Print the expected cost, after a short trial, and exit
    #[arg(long)]
    pub plan: bool,
}

impl WorkArgs {
    /// Settings of a run.
    ///
    /// # Errors
    /// `--memory-gb` is not a number above 0.
    pub fn settings(&self) -> Result<RunSettings> {
        let otherwise = RunSettings::default();
        let memory = self.memory_gb.map_or(Ok(otherwise.memory), bytes)?;
        Ok(RunSettings { jobs: self.jobs.map(usize::from), memory, ..otherwise })
    }

    /// `--output`, else `out/<name of the file>` and what follows the name.
    pub fn folder(&self, file: &Path, end: &str) -> PathBuf {
        self.output.clone().unwrap_or_else(|| Path::new("out").join(stem(file) + end))
    }
}

/// Opens an output folder, whose work this command resumes.
///
/// # Errors
/// The folder cannot be written, or holds something else.
pub fn opened(path: &Path, holds: Holds) -> Result<OutputFolder> {
    let folder = OutputFolder::open(path, holds).map_err(folder_report)?;
    Ok(folder.going_on_with(this_command()))
}
