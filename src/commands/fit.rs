//! `inkwave fit FIT.toml`: from measured drawdowns to a pigment's index.

use super::diagnostics::{folder_report, run_report, step_report, study_report};
use super::progress::Progress;
use super::terminal::note;
use super::work::{WorkArgs, opened};
use clap::Args;
use inkwave::fit::load::{FitTask, load};
use inkwave::fit::publish::{in_words, publish};
use inkwave::fit::run::{FitError, FitRun, Trust, points};
use inkwave::run::RunSettings;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;

/// Fit a pigment's index n + iκ to spectra of drawdowns
///
/// Writes `pigment.csv` (n, κ, their standard errors and correlation; an `index = { csv }` of any
/// study), `fit.json` and a page. An interrupted fit is resumed by the same command.
#[derive(Debug, Args)]
pub struct FitArgs {
    /// Fit file (TOML); `inkwave schema fit --annotated` prints every key
    pub fit: PathBuf,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Runs the command.
pub fn run(args: &FitArgs) -> Result<()> {
    let task = load(&args.fit).map_err(study_report)?;
    let settings = args.work.settings()?;
    if args.work.plan {
        return tell_plan(&task, settings);
    }
    let folder = opened(&args.work.folder(&args.fit, ""), Holds::Fit)?;
    let progress = Progress::new();
    let [table, steps, predicted] = points(&task);
    progress.expect(table + steps + predicted, true);
    let outcome = progress.during(|| FitRun::new(&task, &folder, settings, &progress)?.fit());
    let outcome = outcome.map_err(|error| match error {
        FitError::Run(error) => step_report(error),
        other => miette!("{other}"),
    })?;
    publish(&task, &outcome, &folder).into_diagnostic()?;
    say!("{}: {}", task.title, in_words(&outcome))?;
    outcome.remarks.iter().for_each(note);
    for forecast in &outcome.forecasts {
        let of = |x: Option<f64>| x.map_or("unknown".into(), |x| format!("{x:.2}"));
        let (own, munk) = (of(forecast.delta_e_2000), of(forecast.delta_e_2000_kubelka_munk));
        say!("{}: ΔE₀₀ to the measurement {own} (Kubelka–Munk {munk})", forecast.name)?;
    }
    say!("Report: {}", folder.path().join("report.html").display())?;
    if outcome.trust == Trust::Contradicted {
        let help = "the remarks above and the page say what to check";
        return Err(miette!(help = help, "the measured spectra contradict the study: no errors are stated"));
    }
    Ok(())
}

fn tell_plan(task: &FitTask, settings: RunSettings) -> Result<()> {
    let folder = tempfile::tempdir().into_diagnostic()?;
    let folder = OutputFolder::open(folder.path(), Holds::Fit).map_err(folder_report)?;
    let progress = Progress::new();
    let each = progress.during(|| FitRun::new(task, &folder, settings, &progress)?.trial());
    let each = each.map_err(run_report)?;
    let [table, steps, predicted] = points(task);
    let cells = task.coats[0].realisations;
    let waves = task.wavelengths_nm().len();
    say!(
        "{}: {} spectra of {} layers, {waves} wavelengths, {cells} cells",
        task.title,
        task.measured.len(),
        task.coats_measured
    )?;
    let minutes = |points: usize| each * points as f64 / 60.0;
    for (what, points) in
        [("coarse table", table), ("linearisations, at most", steps), ("predictions", predicted)]
    {
        say!("{what}: {points} solves with derivatives, {:.1} processor minutes", minutes(points))?;
    }
    say!(
        "in all at most {:.1} processor minutes ({:.0} ms for each solve with its derivatives)",
        minutes(table + steps + predicted),
        1e3 * each
    )
}
