//! `inkwave report DIR`: tables, contact sheets and pages of a sweep from its store, finished or
//! not.

use super::diagnostics::folder_report;
use super::merge::open_report;
use super::sweep::tell;
use clap::Args;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::sweep::folder::read;
use inkwave::sweep::publish::publish;
use miette::{IntoDiagnostic, miette};
use std::path::PathBuf;

/// Rebuild tables, contact sheets and pages of a sweep from its finished solves
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
pub fn run(args: &ReportArgs) -> miette::Result<()> {
    let mut sweep = read(&args.folder).map_err(open_report)?;
    let names: Vec<String> = sweep.outline.axes.iter().map(|axis| axis.name.clone()).collect();
    let sheet = &mut sweep.outline.sheet;
    for (option, place) in [(&args.rows, &mut sheet.rows), (&args.columns, &mut sheet.columns)] {
        if let Some(wanted) = option.as_ref().filter(|wanted| !names.contains(wanted)) {
            let allowed = names.join(", ");
            return Err(miette!(help = "name one of the axes", "found axis {wanted:?}; allowed: {allowed}"));
        }
        *place = option.clone().or(place.take());
    }
    let folder = OutputFolder::open(&args.folder, Holds::Sweep).map_err(folder_report)?;
    let reported = publish(&sweep, &folder).into_diagnostic()?;
    tell(&reported, &folder, false, "run the sweep again with its file")
}
