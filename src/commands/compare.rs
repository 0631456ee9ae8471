//! `inkwave compare FILE`: strategies side by side on one geometry.

use super::diagnostics::{folder_report, study_report};
use super::terminal::StopFlag;
use super::work::opened;
use clap::Args;
use inkwave::solve::{Registry, Step, Watch};
use inkwave::store::marker::Holds;
use inkwave_bench::check::{Conformity, ConformityVerdict, TOLERANCE, check};
use inkwave_bench::error::WriteError;
use inkwave_bench::experiment::{CompareError, ComparisonFile, ComparisonPlan};
use inkwave_bench::external::ExternalTable;
use inkwave_bench::row::Row;
use miette::{Result, miette};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Compare strategies, discretisations and other programs on one geometry or several
#[derive(Args)]
pub struct CompareArgs {
    /// Comparison file (TOML); a study (TOML) or a case (JSON) is solved by the default strategies
    /// on the default grids
    #[arg(required_unless_present = "check")]
    file: Option<PathBuf>,
    /// Run the conformance test on an external program (film, grating, sphere); common mistakes are
    /// named. The rest of the line is its command
    #[arg(long, value_name = "COMMAND", num_args = 1.., allow_hyphen_values = true, conflicts_with_all = ["file", "plan"])]
    check: Vec<String>,
    /// Setting passed to the program under --check, such as a number of harmonics
    #[arg(long, requires = "check", conflicts_with = "file", allow_negative_numbers = true)]
    knob: Option<f64>,
    /// Output folder
    #[arg(short, long, default_value = "out/comparison")]
    output: PathBuf,
    /// Check the files, pack the layer, print the number of solves and exit
    #[arg(long)]
    plan: bool,
}

/// Runs the command.
pub fn run(args: &CompareArgs) -> Result<()> {
    let Some(path) = &args.file else { return checked(args) };
    let file = ComparisonFile::read(path).map_err(report)?;
    let registry = Registry::default();
    tell_unused(&file.unused());
    if args.plan {
        let ComparisonPlan { bodies, rows } = file.plan(&registry).map_err(report)?;
        return say!("{}: {rows} solves on a layer of {bodies} bodies", path.display());
    }
    let output = opened(&args.output, Holds::Comparison)?;
    output.mark_partial().map_err(folder_report)?;
    let mut stop = StopFlag::listen();
    let ran = file.run(&registry, &mut stop, tell_row);
    // a stop may end the comparison after some of its solves; what is there is written
    stop.end_at_once(!stop.is_raised());
    let comparison = ran.inspect_err(|_| output.discard_when_empty()).map_err(report)?;
    comparison.write(&output).map_err(write_report)?;
    say!("Comparison: {}", args.output.join("comparison.html").display())?;
    let solved = comparison.rows.len();
    let requested = comparison.asked;
    if solved < requested {
        let help = "the page shows the finished solves; running the command again repeats all of them";
        return Err(miette!(help = help, "stopped after {solved} of {requested} solves"));
    }
    if comparison.rows.iter().any(|row| row.converged()) {
        return Ok(());
    }
    let reason = comparison.rows.first().map_or("no rows".into(), Row::outcome);
    Err(miette!(help = "the page lists every reason", "no row has a result; the first reason: {reason}"))
}

/// Wall time and memory of a program under check.
const CHECK_SECONDS: f64 = 300.0;
const CHECK_GB: f64 = 8.0;

/// Checks a program and says what it found.
fn checked(args: &CompareArgs) -> Result<()> {
    let command = args.check.clone();
    let knob = args.knob.into_iter().collect();
    let name = command.join(" ");
    let program = ExternalTable { name, command, knob, time_limit_s: CHECK_SECONDS, memory_gb: CHECK_GB };
    let Conformity { cases, verdict } =
        check(&program, Path::new(""), &mut StopFlag::listen()).map_err(report)?;
    for (case, result) in &cases {
        match result {
            Ok(error) if *error <= TOLERANCE => say!("{case}: agrees, error {error:.1e}")?,
            Ok(error) => say!("{case}: wrong, error {error:.1e}")?,
            Err(reason) => say!("{case}: {reason}")?,
        }
    }
    let name = &program.name;
    match verdict {
        ConformityVerdict::Conforms => say!("{name} conforms: every amplitude within {TOLERANCE}"),
        ConformityVerdict::Slips(slips) => {
            let joined = |k: usize| slips.iter().map(|s| s[k].as_str()).collect::<Vec<_>>().join("; or ");
            let names = joined(0);
            let remedies = joined(1);
            Err(miette!(help = remedies, "{name} does not conform; likely mistake: {names}"))
        }
        ConformityVerdict::Unknown => {
            let help = "no common mistake explains the answers; where errors are small, try a finer --knob; `inkwave schema external --annotated` describes requests and answers";
            Err(miette!(help = help, "{name} does not conform"))
        }
        ConformityVerdict::Silent => Err(miette!(help = "it refused all of them", "{name} answered no case")),
    }
}

fn write_report(error: WriteError) -> miette::Report {
    match error {
        WriteError::Folder(error) => folder_report(error),
        other => miette!("{other}"),
    }
}

/// Prints a finished row: case, strategy, grid, error and cost.
fn tell_row(row: &Row) {
    let case = row.case.map_or_else(String::new, |case| format!("{case}: "));
    let result = match &row.result {
        Ok(error) => format!("error {error:.1e}"),
        Err(reason) => format!("failed: {reason}"),
    };
    let seconds = row.seconds.map_or_else(String::new, |seconds| format!(", {seconds:.2} s"));
    let strategy = &row.strategy;
    let grid = row.grid();
    let applications = row.applications();
    note!("{case}{strategy:16} {grid}: {applications} applications{seconds}, {result}");
}

/// Prints the keys that have no effect in a comparison.
fn tell_unused(keys: &[String]) {
    if !keys.is_empty() {
        let why = "a comparison solves the first packing at one wavelength and angle, on its own grids and to its own residual";
        note!("Without effect here: {} ({why}).", keys.join(", "));
    }
}

fn report(error: CompareError) -> miette::Report {
    match error {
        CompareError::Study(error) => study_report(error),
        other => miette!("{other}"),
    }
}

/// Stops a solve on Ctrl-C.
impl Watch for StopFlag {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        if self.is_raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
