//! `inkwave fit FIT.toml`: from measured drawdowns to a pigment's index; `inkwave design
//! DESIGN.toml`: from a target colour to recipes.

use super::diagnostics::{folder_report, mixed_up_report, step_report};
use super::progress::Progress;
use super::sweep::tell_plan;
use super::terminal::note;
use super::work::{WorkArgs, opened};
use clap::Args;
use inkwave::design::publish::{axes_in_words, ranges};
use inkwave::design::recipe::DesignTask;
use inkwave::design::run::{DesignError, DesignRun};
use inkwave::design::wish::decimals;
use inkwave::fit::load::FitTask;
use inkwave::fit::publish::in_words;
use inkwave::fit::run::{FitError, FitRun, PlannedSolves, Trust};
use inkwave::run::RunSettings;
use inkwave::run::tangents::timed;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::work::variant::of_one;
use inkwave::{design, fit};
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;

/// Fit a pigment's index n + iκ to spectra of drawdowns
///
/// Writes `pigment.csv` (n, κ, their standard errors and correlation), which any study takes as
/// `index = { csv = "pigment.csv" }`; `fit.json`; a page; and `pigment-other.csv` where a second
/// solution fits equally well. The same command resumes an interrupted fit.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Fit file (TOML); `inkwave schema fit --annotated` prints every key
    pub fit: PathBuf,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Runs a fit.
pub fn fit(args: &FitArgs) -> Result<()> {
    let task = fit::load::load(&args.fit).map_err(|error| mixed_up_report(error, "fit"))?;
    task.remarks.iter().for_each(note);
    let settings = args.work.settings()?;
    if args.work.plan {
        let nodes = fit::composed::variants(&task);
        return if task.is_composed() {
            tell_plan(&nodes, false, settings).map(drop)
        } else {
            plan_fit(&task, settings)
        };
    }
    let folder = opened(&args.work.folder(&args.fit, ""), Holds::Fit)?;
    let progress = Progress::new();
    let outcome = if task.is_composed() {
        let solves = fit::composed::variants(&task).iter().map(|node| node.study.solves()).sum();
        progress.expect(solves, false);
        progress.during(|| fit::composed::fit(&task, &folder, settings, &progress))
    } else {
        progress.expect(PlannedSolves::of(&task).most(), true);
        progress.during(|| FitRun::new(&task, &folder, settings, &progress)?.fit())
    };
    let outcome = outcome.map_err(fit_report)?;
    fit::publish::publish(&task, &outcome, &folder).into_diagnostic()?;
    say!("{}: {}", task.title, in_words(&outcome))?;
    outcome.remarks.iter().for_each(note);
    for forecast in &outcome.forecasts {
        let in_words = |x: Option<f64>| x.map_or("unknown".into(), |x| format!("{x:.2}"));
        let fitted = in_words(forecast.delta_e_2000);
        let munk = in_words(forecast.delta_e_2000_kubelka_munk);
        say!("{}: ΔE₀₀ to the measurement {fitted} (Kubelka–Munk {munk})", forecast.name)?;
    }
    say!("Report: {}", folder.path().join("report.html").display())?;
    if outcome.trust == Trust::Contradicted {
        let help = "the remarks above and the report name what to check";
        return Err(miette!(help = help, "the measured spectra contradict the study: no errors are stated"));
    }
    Ok(())
}

/// Why a fit ended, for the terminal.
fn fit_report(error: FitError) -> miette::Report {
    match error {
        FitError::Run(error) => step_report(error),
        other => miette!("{other}"),
    }
}

fn plan_fit(task: &FitTask, settings: RunSettings) -> Result<()> {
    let folder = tempfile::tempdir().into_diagnostic()?;
    let folder = OutputFolder::open(folder.path(), Holds::Fit).map_err(folder_report)?;
    let progress = Progress::new();
    let (begin, costs) = progress.during(|| {
        let (begin, run) = timed(|| FitRun::new(task, &folder, settings, &progress));
        (begin, run.map_err(FitError::from).and_then(|run| run.trial()))
    });
    let costs = costs.map_err(fit_report)?;
    let solves = PlannedSolves::of(task);
    let [least, most] = PlannedSolves::LINEARISATIONS;
    let spectra = task.measured.len();
    let layers = task.coats_measured;
    let layers = if layers == 1 { "1 layer".into() } else { format!("{layers} layers") };
    let waves = task.wavelengths_nm().len();
    let cells = task.coats[0].realisations;
    say!("{}: {spectra} spectra of {layers}, {waves} wavelengths, {cells} cells", task.title)?;
    say!("grids and packings: {}", processor_time(begin))?;
    say!(
        "coarse table of n and κ: {} solves with derivatives, and the search on it: {}",
        solves.table,
        processor_time(costs.table)
    )?;
    say!(
        "each of {least} to {} linearisations, of up to {most} where several solutions fit equally well: {} solves, {}",
        most / PlannedSolves::BRANCHES,
        solves.linearisation,
        processor_time(costs.linearisation)
    )?;
    if solves.predicted > 0 {
        say!("predictions: {} solves, {}", solves.predicted, processor_time(costs.predicted))?;
    }
    say!(
        "in all {} to {}, from trial solves; wall-clock time is longer on a busy machine",
        processor_time(begin + costs.total(least)),
        processor_time(begin + costs.total(most))
    )
}

/// Processor time in words.
fn processor_time(seconds: f64) -> String {
    if seconds < 90.0 {
        format!("{seconds:.1} processor seconds")
    } else {
        format!("{:.1} processor minutes", seconds / 60.0)
    }
}

/// Find recipes for a target colour, or for wanted numbers such as a solar reflectance
///
/// Runs variants of a study, fits response surfaces to the spectra and verifies their best recipes
/// by further runs. Writes `design.json` and a page. The same command resumes an interrupted
/// design.
#[derive(Debug, Args)]
pub struct DesignArgs {
    /// Design file (TOML); `inkwave schema design --annotated` prints every key
    pub design: PathBuf,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Runs a design.
pub fn design(args: &DesignArgs) -> Result<()> {
    let task = design::recipe::load(&args.design).map_err(|error| mixed_up_report(error, "design"))?;
    task.remarks.iter().for_each(note);
    let settings = args.work.settings()?;
    if args.work.plan {
        return plan_design(&task, settings);
    }
    let folder = opened(&args.work.folder(&args.design, ""), Holds::Design)?;
    let progress = Progress::new();
    let run = DesignRun { task: &task, folder: &folder, settings, watch: &progress };
    let outcome = progress.during(|| run.design()).map_err(|error| match error {
        DesignError::Run(error) => step_report(error),
        other => miette!("{other}"),
    })?;
    design::publish::publish(&task, &outcome, &folder).into_diagnostic()?;
    say!("{}: {}", task.title, outcome.verdict)?;
    for run in &outcome.verified {
        let delta_e = run.delta_e_2000.map(|distance| format!("ΔE₀₀ {}", distance.in_words(2)));
        let ratio = format!("contrast ratio {}", run.contrast_ratio.in_words(3));
        let wanted = outcome.wishes.iter().zip(&run.numbers);
        let wanted = wanted
            .map(|(wish, number)| format!("{} {}", wish.name, number.estimate.in_words(decimals(wish))));
        let all: Vec<String> = delta_e.into_iter().chain([ratio]).chain(wanted).collect();
        note!("verified: {}: {}", run.recipe, all.join(", "));
    }
    for left in &outcome.left_out {
        note!("left out, because it has no colour: {left}");
    }
    let ranges = ranges(&task, &outcome);
    if !ranges.is_empty() {
        let which = if outcome.target.is_some() {
            "recipes of nearly equal colour"
        } else {
            "recipes that meet the wishes"
        };
        note!("{which}: {}", ranges.join("; "));
    }
    if let Some(axes) = axes_in_words(&outcome) {
        note!("variables {axes}");
    }
    if !outcome.interpolated.is_empty() {
        note!(
            "median prediction error of the response surfaces: ΔE₀₀ {:.2} (each variant left out in turn)",
            outcome.surface_error
        );
    }
    say!("Report: {}", folder.path().join("report.html").display())?;
    if outcome.met {
        return Ok(());
    }
    if !outcome.is_decided() {
        return Err(miette!(
            help = "raise design.realisations or design.verifications: with smaller errors it can be decided",
            "whether the target is reached is not decided"
        ));
    }
    Err(miette!(
        help = "widen the ranges in [[vary]], vary another field or another ink, or accept a larger design.delta_e",
        "the target is not reached"
    ))
}

fn plan_design(task: &DesignTask, settings: RunSettings) -> Result<()> {
    let runs = task.variants() + task.settings.verifications;
    say!(
        "{}: {} variants and at most {} verifying runs, {runs} runs in all; one of them:",
        task.title,
        task.variants(),
        task.settings.verifications
    )?;
    let composed = task.names(task.composed());
    if !composed.is_empty() {
        say!("composed exactly, without variants of their own: {}", composed.join(", "))?;
    }
    let middle = vec![0.5; task.variables.len()];
    let study = task.study(&middle).map_err(|faults| miette!("{}", faults[0]))?;
    let plan = tell_plan(&of_one("middle", study), false, settings)?;
    let [least, most] = plan.core_seconds_range.map(|seconds| processor_time(seconds * runs as f64));
    say!("all {runs} runs      {least} to {most}; fewer where a recipe is found earlier")
}
