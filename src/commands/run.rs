//! `inkwave run STUDY.toml`: from a study file to the picture of an ink on paper.

use super::diagnostics::study_report;
use super::progress::Progress;
use super::stop::StopFlag;
use clap::Args;
use inkwave::report::folder::{FolderError, OutputFolder};
use inkwave::study::checked::Study;
use inkwave::study::load::load;
use inkwave::study::runner::{self, RunSettings};
use std::path::{Path, PathBuf};

/// Arguments of `inkwave run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Study file (TOML); examples/yellow.toml shows all of it.
    pub study: PathBuf,
    /// Folder for the results; made when it is not there, continued when it holds part of this study.
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Solves at a time; the number of processors when left out. Fewer take less memory.
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
}

/// Reads, checks and runs a study.
pub fn run(args: &RunArgs) -> miette::Result<()> {
    let study = load(&args.study).map_err(study_report)?;
    let path = output_path(args, &study);
    let folder = OutputFolder::open(&path).map_err(folder_report)?;
    let progress = Progress::new(StopFlag::listen());
    let collected = runner::run(&study, &folder, RunSettings { jobs: args.jobs.map(usize::from) }, &progress);
    progress.finish();
    let c = collected.map_err(|e| miette::miette!("{e}"))?;
    eprintln!("{:?} {}", c.resolved, c.finished());
    Ok(())
}

/// `--output`, else the study's own folder, else `out/<study name>`.
fn output_path(args: &RunArgs, study: &Study) -> PathBuf {
    let name = || args.study.file_stem().map_or_else(|| "study".into(), PathBuf::from);
    let own = || study.output.folder.as_ref().map(PathBuf::from);
    args.output.clone().or_else(own).unwrap_or_else(|| Path::new("out").join(name()))
}

fn folder_report(error: FolderError) -> miette::Report {
    miette::miette!(help = error.remedy(), "{error}")
}
