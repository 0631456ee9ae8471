//! `inkwave compare FILE`: strategies side by side on one geometry.

use super::again::this_command;
use super::diagnostics::study_report;
use super::run::folder_report;
use super::say::{note, say};
use clap::Args;
use inkwave::compare::experiment::{CompareError, ComparisonFile, Plan};
use inkwave::compare::matrix::Cell;
use inkwave::compare::pages::{Row, is_of_a_comparison};
use inkwave::solve::{Registry, Step, Watch};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use miette::{IntoDiagnostic, Result};
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
        let Plan { bodies, rows } = file.plan(&registry).map_err(report)?;
        return say(format_args!("{}: {rows} solves on a layer of {bodies} bodies", args.file.display()));
    }
    let output = OutputFolder::open(&args.output, Holds::Comparison).map_err(folder_report)?;
    let output = output.going_on_with(this_command());
    output.mark_partial().map_err(folder_report)?;
    let mut stop = StopWatch(super::stop::StopFlag::listen());
    let matrix =
        file.run_matrix(&registry, &mut stop, tell_cell).inspect_err(|_| output.discard_when_empty());
    if let Some(matrix) = matrix.map_err(report)? {
        output.remove_files(is_of_a_comparison).map_err(folder_report)?;
        matrix.write(output.path()).into_diagnostic()?;
        complete(&output, matrix.cells.len() == matrix.asked)?;
        say(format_args!("Comparison: {}", output.path().join("matrix.html").display()))?;
        return ended(matrix.cells.len(), matrix.asked);
    }
    let comparison = file
        .run(&registry, &mut stop, tell_row)
        .inspect_err(|_| output.discard_when_empty())
        .map_err(report)?;
    output.remove_files(is_of_a_comparison).map_err(folder_report)?;
    comparison.write(output.path()).into_diagnostic()?;
    complete(&output, comparison.rows.len() == comparison.asked)?;
    say(format_args!("Comparison: {}", args.output.join("comparison.html").display()))?;
    ended(comparison.rows.len(), comparison.asked)?;
    if comparison.rows.iter().any(|row| row.converged()) {
        return Ok(());
    }
    let reason = comparison.rows.first().map_or("no rows", |row| row.outcome.as_str());
    Err(miette::miette!(help = "the page lists every reason", "no row has a result; the first: {reason}"))
}

/// Takes the mark away where every solve is there.
fn complete(output: &OutputFolder, all: bool) -> Result<()> {
    if all { output.complete().map_err(folder_report) } else { Ok(()) }
}

/// One finished solve of a matrix: index, period, strategy, cost and outcome.
fn tell_cell(cell: &Cell) {
    let (n, kappa, period, outcome) = (cell.n, cell.kappa, cell.period_um, &cell.outcome);
    let cost = format!("{} applications, {:.2} s", cell.operator_applications, cell.seconds);
    note(format_args!("{n} + {kappa}i, {period} µm, {:16} {cost}: {outcome}", cell.strategy));
}

/// One finished row of a comparison: strategy, grid, error and cost.
fn tell_row(row: &Row) {
    let error = row.error.map_or("failed".into(), |e| format!("error {e:.1e}"));
    note(format_args!(
        "{:16} {:?} {} × {} × {}: {error}, {} applications, {:.2} s",
        row.strategy, row.scheme, row.nx, row.ny, row.cells, row.operator_applications, row.seconds
    ));
}

/// Nobody shall wait for the effect of a key that has none.
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
