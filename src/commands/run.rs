//! `inkwave run STUDY.toml`: from a study file to the picture of an ink on paper.

use super::diagnostics::study_report;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `inkwave run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Study file (TOML); examples/yellow.toml shows all of it.
    pub study: PathBuf,
    /// Folder for the results; made when it is not there, continued when it holds part of this study.
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Reads, checks and runs a study.
pub fn run(args: &RunArgs) -> miette::Result<()> {
    let study = inkwave::study::load::load(&args.study).map_err(study_report)?;
    eprintln!("{}", study.key());
    Ok(())
}
