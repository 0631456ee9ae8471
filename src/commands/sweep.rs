//! `inkwave sweep SWEEP.toml`: a study of many variants, on one machine or many.

use super::diagnostics::{folder_report, mixed_up_report, run_report, tell_damages};
use super::progress::{Live, Progress};
use super::terminal::{note, this_command, to_resume};
use super::work::{WorkArgs, opened};
use clap::Args;
use inkwave::run::RunSettings;
use inkwave::run::watch::RunWatch;
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::sweep::publish::{Publisher, publish};
use inkwave::sweep::reported::Reported;
use inkwave::sweep::{Sweep, folder, load};
use inkwave::work::plan::{self, Plan};
use inkwave::work::run as runner;
use inkwave::work::run::Scope;
use inkwave::work::units::{Shard, ends_early, units};
use inkwave::work::variant::{Variant, solved_for};
use miette::{IntoDiagnostic, Result, miette};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Environment variables in which array schedulers pass the number of a task, counted from 1.
const TASK_NUMBER: [&str; 4] = ["SLURM_ARRAY_TASK_ID", "PBS_ARRAYID", "PBS_ARRAY_INDEX", "HQ_TASK_ID"];

/// Shortest waiting time that is reported.
const WORTH_TELLING: Duration = Duration::from_millis(100);

/// Run many variants of a study; the work can be interrupted, resumed and divided among machines
#[derive(Debug, Args)]
pub struct SweepArgs {
    /// Sweep file (TOML); `inkwave schema sweep --annotated` prints every key
    pub sweep: PathBuf,
    /// Print the plan as JSON
    #[arg(long, requires = "plan")]
    pub json: bool,
    /// Run part I of N, counted from 1; N alone takes I from SLURM_ARRAY_TASK_ID, PBS_ARRAYID,
    /// PBS_ARRAY_INDEX or HQ_TASK_ID
    #[arg(long, value_name = "I/N", conflicts_with = "plan")]
    pub shard: Option<String>,
    /// Choose the grids and exit; shards then take them with --grids
    #[arg(long, conflicts_with_all = ["plan", "shard"])]
    pub grids_only: bool,
    /// Take the grids from a folder written with --grids-only
    #[arg(long, value_name = "DIR", conflicts_with = "plan")]
    pub grids: Option<PathBuf>,
    /// Retry failed solves, packings and grids
    #[arg(long)]
    pub retry_failed: bool,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Reads, checks and runs a sweep, or plans it.
pub fn run(args: &SweepArgs) -> Result<()> {
    let sweep = load::load(&args.sweep).map_err(|error| mixed_up_report(error, "sweep"))?;
    // most variants have the same remarks
    let remarks: BTreeSet<&String> = sweep.variants.iter().flat_map(|v| &v.study.remarks).collect();
    remarks.into_iter().for_each(note);
    let settings = args.work.settings()?;
    let settings = RunSettings { retry_failed: args.retry_failed, ..settings };
    if args.work.plan {
        return tell_plan(&sweep.variants, args.json, settings).map(drop);
    }
    let shard = args.shard.as_deref().map(|text| shard(text, &sweep)).transpose()?;
    let part = shard.unwrap_or(Shard::ALL);
    let end = shard.map_or_else(String::new, |s| format!(".shard-{}-of-{}", s.index, s.count));
    let folder = begin(&sweep, &args.work.folder(&args.sweep, &end), args)?;
    let progress = Progress::new();
    let scope = if args.grids_only { Scope::Grids } else { Scope::Solves };
    progress.expect(
        if args.grids_only { 0 } else { runner::solves(&sweep.variants, part) },
        ends_early(&sweep.variants),
    );
    let mut publisher = Publisher::new(&sweep);
    let live = Live::new(&folder, &progress, Box::new(|| publisher.publish(&folder).is_ok()));
    let watch: &dyn RunWatch = if args.grids_only { &progress } else { &live };
    let tally = progress.during(|| runner::run(&sweep.variants, &folder, (part, scope), settings, watch));
    let tally = tally.map_err(run_report)?;
    tell_damages(&tally.damages);
    if tally.waited >= WORTH_TELLING {
        let seconds = tally.waited.as_secs_f64();
        note!("the workers of this process waited {seconds:.1} s for other processes");
    }
    if args.grids_only && progress.stopped() {
        return Err(miette!(help = to_resume(), "stopped before all grids were chosen"));
    }
    if args.grids_only {
        return say!("Grids in {}", folder.path().display());
    }
    if shard.is_some() {
        // The sweep is reported once the shards are merged; until then the page shows the results
        // of this one.
        publish(&sweep, &folder).into_diagnostic()?;
        return tell_shard(&tally, part, &folder, progress.stopped());
    }
    if !tally.publishes {
        return tell_others(&folder);
    }
    report(&sweep, &folder, progress.stopped(), &this_command())
}

/// Says that other processes continue here.
pub(super) fn tell_others(folder: &OutputFolder) -> Result<()> {
    say!("Other processes are still working in {} and will write the report.", folder.path().display())
}

/// Publishes what the store has of a sweep and prints where the results are.
pub(super) fn report(sweep: &Sweep, folder: &OutputFolder, stopped: bool, go_on: &str) -> Result<()> {
    tell(&publish(sweep, folder).into_diagnostic()?, folder, stopped, go_on)
}

/// Opens the output folder, writes the sweep to it and applies `--retry-failed` and `--grids`.
fn begin(sweep: &Sweep, path: &Path, args: &SweepArgs) -> Result<OutputFolder> {
    let folder = opened(path, Holds::Sweep)?;
    folder.begin().map_err(folder_report)?;
    folder::write(sweep, &folder).map_err(folder_report)?;
    if let Some(from) = &args.grids {
        let taken =
            folder::take_grids(from, &folder).map_err(|e| miette!("--grids {}: {e}", from.display()))?;
        note!("{taken} grids taken from {}", from.display());
    }
    Ok(folder)
}

/// Prints where the results are; incomplete results are an error, so that scripts notice.
fn tell(reported: &Reported, folder: &OutputFolder, stopped: bool, go_on: &str) -> Result<()> {
    for judged in &reported.conclusions {
        say!("{}: {} ({})", judged.table.id, judged.verdict.name(), judged.inequality)?;
    }
    if let Some(nearest) = &reported.nearest {
        say!("Target {}: {}", nearest.target, nearest.summary)?;
    }
    say!("Report: {}", folder.path().join("report.html").display())?;
    let complete = reported.complete();
    let all = reported.outcomes.len();
    let failures = reported.failures();
    if complete == all {
        return Ok(());
    }
    let waiting = reported.outcomes.iter().filter(|o| !o.is_complete() && o.reason.is_none()).count();
    let help = if waiting > 0 && !stopped {
        format!("{waiting} variants are unfinished; to resume: {go_on}, or merge the missing shards")
    } else if failures > 0 && !stopped {
        "the report lists the reasons; change the sweep or use --retry-failed".to_owned()
    } else {
        format!("to resume: {go_on}")
    };
    Err(miette!(help = help, "{complete} of {all} variants are finished, {failures} failures are recorded"))
}

fn tell_shard(tally: &runner::Tally, shard: Shard, folder: &OutputFolder, stopped: bool) -> Result<()> {
    let runner::Tally { asked, finished, failed, .. } = *tally;
    let Shard { index, count } = shard;
    say!("Shard {index}/{count} in {}: {finished} of {asked} solves finished", folder.path().display())?;
    if stopped || finished + failed < asked {
        return Err(miette!(help = to_resume(), "stopped: {finished} of {asked} solves"));
    }
    if failed > 0 {
        let help = "the report lists the reasons; use --retry-failed";
        return Err(miette!(help = help, "{failed} of {asked} solves have no result"));
    }
    Ok(())
}

/// Prints the expected cost of one study or of the variants of a sweep.
pub(super) fn tell_plan(variants: &[Variant], json: bool, settings: RunSettings) -> Result<Plan> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = settings.jobs.unwrap_or(cores);
    let progress = Progress::new();
    let settings = RunSettings { jobs: Some(jobs), ..settings };
    let plan = progress.during(|| plan::plan(variants, settings, &progress)).map_err(run_report)?;
    if json {
        say!("{}", serde_json::to_string_pretty(&plan).into_diagnostic()?)?;
        return Ok(plan);
    }
    if let Some(reason) = &plan.out_of_reach {
        say!("out of reach: {reason}")?;
    }
    let [least, longest] = plan.core_seconds_range;
    // no number of cores ends before one solve has ended
    let one_solve = 1.0 / plan.solves.max(1) as f64;
    let time = |core_seconds: f64, cores: f64| in_words(core_seconds * one_solve.max(1.0 / cores));
    let range = format!("{} to {}", time(least, jobs as f64), time(longest, jobs as f64));
    say!("variants          {}", plan.variants)?;
    say!("packings          {}", plan.packings)?;
    // `run.target_delta_e` may be reached earlier.
    let (most, about) = if ends_early(variants) { ("at most ", "at most") } else { ("", "about") };
    say!("solves            {most}{}", plan.solves)?;
    say!("unknowns          {} in the largest solve", plan.unknowns)?;
    say!("memory            {} MB for {jobs} solves at a time", plan.memory_mb * jobs)?;
    let on_jobs = time(plan.core_seconds, jobs as f64);
    let on_hundred = time(plan.core_seconds, 100.0);
    // what is known to be less is not known about
    let about = if on_jobs.starts_with("less") { String::new() } else { format!("{about} ") };
    say!("time              {about}{on_jobs} on {jobs} idle cores (range {range}), {on_hundred} on 100")?;
    say!("                  for the solves; numbers, error bars and pages take seconds more")?;
    say!("shards            {} at most", plan.units)?;
    say!("estimated from    {}", plan.calibration)?;
    Ok(plan)
}

/// Formats a time with two or three digits.
fn in_words(seconds: f64) -> String {
    match seconds {
        s if s < 0.1 => "less than 0.1 s".to_owned(),
        s if s < 1.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s if s < 360_000.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

/// Parses `I/N`, or `N` with the part from the environment variable of the scheduler, for a sweep
/// that can be divided so.
fn shard(text: &str, sweep: &Sweep) -> Result<Shard> {
    let shard = parse_shard(text)?;
    let most = units(&solved_for(&sweep.variants)).len();
    let count = shard.count;
    if count > most {
        let help = "each shard needs a unit (one realisation of the variants that share a packing); --plan counts them";
        return Err(miette!(
            help = help,
            "--shard: found {count} parts; this sweep can be divided into 1 to {most}"
        ));
    }
    if let Some(variant) = sweep.variants.iter().find(|variant| variant.study.target_delta_e.is_some()) {
        let help = "leave --shard out and start any number of processes in one folder, or give run.realisations alone";
        return Err(miette!(
            help = help,
            "--shard: found with run.target_delta_e in variant {}; allowed without it, as no shard knows the whole confidence interval",
            variant.name
        ));
    }
    Ok(shard)
}

fn parse_shard(text: &str) -> Result<Shard> {
    let number = |text: &str| text.trim().parse::<usize>().ok();
    // the scheduler's variable that is set, with its value
    let task = TASK_NUMBER.iter().find_map(|name| Some((*name, std::env::var(name).ok()?)));
    let (index, count) = match text.split_once('/') {
        Some((index, count)) => (number(index), number(count)),
        None => (task.as_ref().and_then(|(_, value)| number(value)), number(text)),
    };
    let found = match (index, &task) {
        (Some(index), _) => match count.filter(|count| (1..=*count).contains(&index)) {
            Some(count) => return Ok(Shard { index, count }),
            None => format!("{text} (part {index})"),
        },
        (None, _) if text.contains('/') => text.to_owned(),
        (None, Some((name, value))) => format!("{text} and {name} = {value}"),
        (None, None) => format!("{text} alone, and none of {} is set", TASK_NUMBER.join(", ")),
    };
    let help =
        "write --shard 3/8 for the third of eight parts; or --shard 8 in an array job numbered from 1 to 8";
    Err(miette!(help = help, "--shard: found {found}; allowed: I/N with whole numbers 1 ≤ I ≤ N"))
}
