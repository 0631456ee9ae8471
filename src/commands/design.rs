//! `inkwave design DESIGN.toml`: from a wanted colour to recipes.

use super::again::this_command;
use super::diagnostics::study_report;
use super::progress::Progress;
use super::run::{folder_report, run_report};
use super::say::{note, say};
use super::stop::StopFlag;
use super::sweep::tell_plan;
use clap::Args;
use inkwave::design::publish::{publish, ranges};
use inkwave::design::recipe::{DesignTask, load};
use inkwave::design::run::{DesignError, DesignRun};
use inkwave::run::{RunError, RunSettings};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::sweep::Sweep;
use miette::{IntoDiagnostic, miette};
use std::path::{Path, PathBuf};

/// Find recipes for a wanted colour
///
/// Runs variants of a study, lays response surfaces through their spectra, and verifies what these
/// answer by further runs. Writes `design.json` and a page. An interrupted design is resumed by the
/// same command.
#[derive(Debug, Args)]
pub struct DesignArgs {
    /// Design file (TOML); `inkwave schema design --annotated` prints every key
    pub design: PathBuf,
    /// Output folder (created if missing)
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Number of parallel solves (default: number of processors)
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Print the expected cost of one run in the middle of the ranges and the number of runs, and
    /// exit
    #[arg(long)]
    pub plan: bool,
    /// Memory for all parallel solves, GB (default: four fifths of the free memory)
    #[arg(long, value_name = "GB", allow_negative_numbers = true)]
    pub memory_gb: Option<f64>,
}

/// Runs the command.
pub fn run(args: &DesignArgs) -> miette::Result<()> {
    let task = load(&args.design).map_err(study_report)?;
    let settings = super::memory::settings(args.jobs, args.memory_gb)?;
    if args.plan {
        return plan(&task, settings);
    }
    let name = args.design.file_stem().map_or_else(|| "design".into(), PathBuf::from);
    let path = args.output.clone().unwrap_or_else(|| Path::new("out").join(name));
    let folder = OutputFolder::open(&path, Holds::Design).map_err(folder_report)?;
    let folder = folder.going_on_with(this_command());
    let progress = Progress::new(StopFlag::listen());
    let run = DesignRun { task: &task, folder: &folder, settings, watch: &progress };
    let outcome = run.design();
    progress.finish();
    let outcome = outcome.map_err(design_report)?;
    publish(&task, &outcome, &folder).into_diagnostic()?;
    say(format_args!("{}: {}", task.title, outcome.verdict))?;
    for run in &outcome.verified {
        let (delta_e, ratio) = (run.delta_e_2000.in_words(2), run.contrast_ratio.in_words(3));
        note(format_args!("verified: {}: ΔE₀₀ {delta_e}, contrast ratio {ratio}", run.recipe));
    }
    let ranges = ranges(&task, &outcome);
    if !ranges.is_empty() {
        note(format_args!("recipes of nearly equal colour: {}", ranges.join("; ")));
    }
    note(format_args!("the surfaces miss a variant's colour by ΔE₀₀ {:.2} (median)", outcome.surface_error));
    say(format_args!("Report: {}", folder.path().join("report.html").display()))?;
    if outcome.met {
        return Ok(());
    }
    Err(miette!(
        help = "widen the ranges in [[vary]], vary another field or another ink, or accept a larger design.delta_e",
        "the target is not reached"
    ))
}

fn plan(task: &DesignTask, settings: RunSettings) -> miette::Result<()> {
    let runs = task.variants() + task.settings.verifications;
    say(format_args!(
        "{}: {} variants and at most {} verifying runs, {runs} runs in all; one of them:",
        task.title,
        task.variants(),
        task.settings.verifications
    ))?;
    let middle = vec![0.5; task.variables.len()];
    let study = task.study(&middle).map_err(|faults| miette!("{}", faults[0]))?;
    tell_plan(&Sweep::of_one("middle", study), false, settings)
}

fn design_report(error: DesignError) -> miette::Report {
    match error {
        DesignError::Run(RunError::Stopped) => {
            let help = format!("to resume: {}", this_command());
            miette!(help = help, "stopped: what is solved is stored")
        }
        DesignError::Run(error) => run_report(error),
        other => miette!("{other}"),
    }
}
