//! `inkwave compare FILE`: strategies side by side on one geometry.

use super::again::this_command;
use super::diagnostics::study_report;
use super::run::folder_report;
use super::say::{note, say};
use clap::Args;
use inkwave::compare::experiment::{CompareError, ComparisonFile, ComparisonPlan};
use inkwave::compare::row::Row;
use inkwave::report::publish::PublishError;
use inkwave::solve::{Registry, Step, Watch};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use miette::Result;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Compare strategies, resolutions and discretisations on one geometry
#[derive(Args)]
pub struct CompareArgs {
    /// Comparison (TOML), or a study (TOML) or a case (JSON) to compare with the default lists
    file: PathBuf,
    /// Output folder
    #[arg(short, long, default_value = "out/comparison")]
    output: PathBuf,
    /// Check the files, pack the layer, print the number of solves and exit
    #[arg(long)]
    plan: bool,
}

/// Runs the command.
pub fn run(args: &CompareArgs) -> Result<()> {
    let file = ComparisonFile::read(&args.file).map_err(report)?;
    let registry = Registry::default();
    tell_unused(&file.unused());
    if args.plan {
        let ComparisonPlan { bodies, rows } = file.plan(&registry).map_err(report)?;
        return say(format_args!("{}: {rows} solves on a layer of {bodies} bodies", args.file.display()));
    }
    let output = OutputFolder::open(&args.output, Holds::Comparison).map_err(folder_report)?;
    let output = output.going_on_with(this_command());
    output.mark_partial().map_err(folder_report)?;
    let mut stop = StopWatch(super::stop::StopFlag::listen());
    let comparison = file
        .run(&registry, &mut stop, tell_row)
        .inspect_err(|_| output.discard_when_empty())
        .map_err(report)?;
    comparison.write(&output).map_err(publish_report)?;
    say(format_args!("Comparison: {}", args.output.join("comparison.html").display()))?;
    ended(comparison.rows.len(), comparison.asked)?;
    if comparison.rows.iter().any(|row| row.converged()) {
        return Ok(());
    }
    let reason = comparison.rows.first().map_or("no rows".into(), Row::outcome);
    Err(miette::miette!(help = "the page lists every reason", "no row has a result; the first: {reason}"))
}

fn publish_report(error: PublishError) -> miette::Report {
    match error {
        PublishError::Folder(error) => folder_report(error),
        other => miette::miette!("{other}"),
    }
}

/// One finished row: case, strategy, grid, error and cost.
fn tell_row(row: &Row) {
    let case = row.case.map_or_else(String::new, |case| format!("{case}: "));
    let result = match &row.result {
        Ok(error) => format!("error {error:.1e}"),
        Err(reason) => format!("failed: {reason}"),
    };
    let seconds = row.seconds.map_or_else(String::new, |seconds| format!(", {seconds:.2} s"));
    let (strategy, grid, applications) = (&row.strategy, row.grid(), row.applications());
    note(format_args!("{case}{strategy:16} {grid}: {applications} applications{seconds}, {result}"));
}

/// Names the keys that have no effect here.
fn tell_unused(keys: &[String]) {
    if !keys.is_empty() {
        let why = "comparisons solve the first packing at one wavelength and angle, with grids and residuals of their own";
        note(format_args!("Without effect here: {} ({why}).", keys.join(", ")));
    }
}

/// A comparison that was stopped is no success.
fn ended(there: usize, asked: usize) -> Result<()> {
    if there == asked {
        return Ok(());
    }
    let help = "the page has what was solved; the same command solves all of it again";
    Err(miette::miette!(help = help, "stopped after {there} of {asked} solves"))
}

fn report(error: CompareError) -> miette::Report {
    match error {
        CompareError::Study(error) => study_report(error),
        other => miette::miette!("{other}"),
    }
}

/// Stops a solve on Ctrl-C.
struct StopWatch(super::stop::StopFlag);

impl Watch for StopWatch {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        if self.0.is_raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
