//! `inkwave merge SHARDS… --output DIR`: joins what several machines have computed. `inkwave report
//! DIR`: tables, contact sheets and pages of a sweep from its store, finished or not.

use super::diagnostics::{folder_report, study_report, tell_damages};
use super::sweep::report as report_on;
use clap::Args;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::sweep::folder::{OpenError, read};
use inkwave::sweep::merge::{MergeError, merge};
use miette::{Result, miette};
use std::path::PathBuf;

/// Merge the shards of a sweep into one folder and write its report
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folders of the shards
    #[arg(required = true)]
    pub shards: Vec<PathBuf>,
    /// Output folder for the whole sweep
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
}

/// Merges and reports.
pub fn run(args: &MergeArgs) -> Result<()> {
    let folder = OutputFolder::open(&args.output, Holds::Sweep).map_err(folder_report)?;
    let merged = merge(&args.shards, &folder).inspect_err(|_| folder.discard_when_empty());
    let merged = merged.map_err(merge_report)?;
    tell_damages(&merged.damages);
    if merged.healed > 0 {
        note!("{} damaged records were replaced by intact copies from other shards", merged.healed);
    }
    report_on(&merged.sweep, &folder, false, "run the sweep again with its file")
}

/// Write tables, contact sheets and pages of a sweep again from its finished solves
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folder of the sweep
    pub folder: PathBuf,
    /// Axis along the rows of the contact sheets
    #[arg(long, value_name = "AXIS")]
    pub rows: Option<String>,
    /// Axis along the columns of the contact sheets
    #[arg(long, value_name = "AXIS")]
    pub columns: Option<String>,
}

/// Reads the sweep back and reports.
pub fn report(args: &ReportArgs) -> Result<()> {
    let mut sweep = read(&args.folder).map_err(open_report)?;
    let names: Vec<String> = sweep.outline.axes.iter().map(|axis| axis.name.clone()).collect();
    let sheet = &mut sweep.outline.sheet;
    for (option, place) in [(&args.rows, &mut sheet.rows), (&args.columns, &mut sheet.columns)] {
        if let Some(axis) = option.as_ref().filter(|axis| !names.contains(axis)) {
            let allowed = names.join(", ");
            return Err(miette!(
                help = "give the name of one of the axes",
                "found axis {axis:?}; allowed: {allowed}"
            ));
        }
        *place = option.clone().or(place.take());
    }
    let folder = OutputFolder::open(&args.folder, Holds::Sweep).map_err(folder_report)?;
    report_on(&sweep, &folder, false, "run the sweep again with its file")
}

fn open_report(error: OpenError) -> miette::Report {
    match error {
        OpenError::Variant(error) => study_report(error),
        OpenError::Changed(_) => {
            let help = "run inkwave sweep again with its file and --output here: these files are rewritten and every solve is kept";
            miette!(help = help, "{error}")
        }
        other => miette!(help = "give a folder written by inkwave sweep or inkwave merge", "{other}"),
    }
}

fn merge_report(error: MergeError) -> miette::Report {
    match error {
        MergeError::Open(error) => open_report(error),
        MergeError::Folder(error) => folder_report(error),
        MergeError::OtherSweep(_) => {
            miette!(help = "merge shards of the same sweep file only; run the others again", "{error}")
        }
        MergeError::Contradiction(_) => {
            let help = "the two builds compute different results: run one of the shards again with the other's build";
            miette!(help = help, "{error}")
        }
        MergeError::Copy(_) => miette!(help = "check the disk and the permissions", "{error}"),
    }
}
