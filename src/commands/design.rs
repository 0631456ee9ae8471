//! `inkwave design DESIGN.toml`: from a wanted colour to recipes.

use super::diagnostics::{step_report, study_report};
use super::progress::Progress;
use super::sweep::tell_plan;
use super::work::{WorkArgs, opened};
use clap::Args;
use inkwave::design::publish::{publish, ranges};
use inkwave::design::recipe::{DesignTask, load};
use inkwave::design::run::{DesignError, DesignRun};
use inkwave::run::RunSettings;
use inkwave::store::marker::Holds;
use inkwave::sweep::Sweep;
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;

/// Find recipes for a wanted colour
///
/// Runs variants of a study, lays response surfaces through their spectra, and verifies what these
/// answer by further runs. Writes `design.json` and a page. An interrupted design is resumed by the
/// same command.
#[derive(Debug, Args)]
pub struct DesignArgs {
    /// Design file (TOML); `inkwave schema design --annotated` prints every key
    pub design: PathBuf,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Runs the command.
pub fn run(args: &DesignArgs) -> Result<()> {
    let task = load(&args.design).map_err(study_report)?;
    let settings = args.work.settings()?;
    if args.work.plan {
        return plan(&task, settings);
    }
    let folder = opened(&args.work.folder(&args.design, ""), Holds::Design)?;
    let progress = Progress::new();
    let run = DesignRun { task: &task, folder: &folder, settings, watch: &progress };
    let outcome = progress.during(|| run.design()).map_err(|error| match error {
        DesignError::Run(error) => step_report(error),
        other => miette!("{other}"),
    })?;
    publish(&task, &outcome, &folder).into_diagnostic()?;
    say!("{}: {}", task.title, outcome.verdict)?;
    for run in &outcome.verified {
        let (delta_e, ratio) = (run.delta_e_2000.in_words(2), run.contrast_ratio.in_words(3));
        note!("verified: {}: ΔE₀₀ {delta_e}, contrast ratio {ratio}", run.recipe);
    }
    let ranges = ranges(&task, &outcome);
    if !ranges.is_empty() {
        note!("recipes of nearly equal colour: {}", ranges.join("; "));
    }
    note!("the surfaces miss a variant's colour by ΔE₀₀ {:.2} (median)", outcome.surface_error);
    say!("Report: {}", folder.path().join("report.html").display())?;
    if outcome.met {
        return Ok(());
    }
    Err(miette!(
        help = "widen the ranges in [[vary]], vary another field or another ink, or accept a larger design.delta_e",
        "the target is not reached"
    ))
}

fn plan(task: &DesignTask, settings: RunSettings) -> Result<()> {
    let runs = task.variants() + task.settings.verifications;
    say!(
        "{}: {} variants and at most {} verifying runs, {runs} runs in all; one of them:",
        task.title,
        task.variants(),
        task.settings.verifications
    )?;
    let middle = vec![0.5; task.variables.len()];
    let study = task.study(&middle).map_err(|faults| miette!("{}", faults[0]))?;
    tell_plan(&Sweep::of_one("middle", study), false, settings)
}
