//! Compares the last run of the `costs` bench with earlier ones and draws costs and trends.
//!
//! Times drift from machine to machine and from hour to hour. What most benches share is the machine's: the median, over all
//! benches, of a run's times over their baseline. A bench has changed when its own time has, beyond that and its noise. The
//! baseline of a bench is the median of several earlier runs on the same machine. The table's unit, the transforms alone
//! (`operator/floor` on the largest grid), is a bench like others: when it changes, that is reported once, and not for all.

use clap::Parser;
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::draw::seal::sealed;
use inkwave::store::safely;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Keeps the history of costs.
#[derive(Parser)]
struct Args {
    /// Where criterion left its estimates.
    #[arg(long, default_value = "target/criterion")]
    criterion: PathBuf,
    #[arg(long, default_value = "reports/benchmarks")]
    out: PathBuf,
    #[arg(long, default_value = "unknown")]
    date: String,
    #[arg(long, default_value = "unknown")]
    commit: String,
    #[arg(long, default_value = "unknown")]
    machine: String,
    /// Draws the last run of the history again, and measures nothing.
    #[arg(long)]
    redraw: bool,
}

/// One bench of one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Entry {
    date: String,
    commit: String,
    machine: String,
    bench: String,
    unknowns: Option<usize>,
    applications: Option<usize>,
    bytes_per_unknown: Option<f64>,
    /// Median, nanoseconds.
    median_ns: f64,
    /// Median over the floor's.
    ratio: f64,
    /// Relative standard error of the ratio.
    noise: f64,
}

/// The bench whose median is the unit.
const FLOOR: &str = "operator/floor/8";
/// A time must change by this much (its logarithm), and by four times its noise, to be flagged.
const SMALLEST_CHANGE: f64 = 0.2;

fn main() -> Outcome<()> {
    let args = Args::parse();
    let path = args.out.join("history.csv");
    let mut history: Vec<Entry> = if path.exists() {
        csv::Reader::from_path(&path)?.deserialize().collect::<Result<_, _>>()?
    } else {
        Vec::new()
    };
    let run = if args.redraw { last_run(&mut history) } else { measured(&args)? };
    let news = News::of(&run, &history);
    history.extend(run.clone());
    std::fs::create_dir_all(&args.out)?;
    let mut table = csv::Writer::from_writer(Vec::new());
    history.iter().try_for_each(|e| table.serialize(e))?;
    safely::write(&path, &table.into_inner()?)?;
    for (name, plot) in
        [("costs.svg", costs(&run)), ("bytes.svg", bytes(&run)), ("trend.svg", trend(&history))]
    {
        safely::write(&args.out.join(name), plot.svg()?.as_bytes())?;
    }
    let words = words(&args.out.join("words.csv"))?;
    safely::write(&args.out.join("README.md"), sealed(&page(&run, &news, &words)).as_bytes())?;
    news.changes.iter().for_each(|(bench, change)| println!("{bench}: {change}"));
    println!(
        "{} benches, {} changed; {}",
        run.len(),
        news.changes.len(),
        args.out.join("README.md").display()
    );
    Ok(())
}

/// Takes the last run out of the history, to draw it again.
fn last_run(history: &mut Vec<Entry>) -> Vec<Entry> {
    let last = history.last().map(|e| e.date.clone()).unwrap_or_default();
    let first = history.iter().position(|e| e.date == last).unwrap_or(0);
    history.split_off(first)
}

/// What people have found out about a change: bench, commit at which it was seen, words.
#[derive(Deserialize)]
struct Word {
    bench: String,
    commit: String,
    words: String,
}

fn words(path: &Path) -> Outcome<Vec<Word>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    Ok(csv::Reader::from_path(path)?.deserialize().collect::<Result<_, _>>()?)
}

/// Median and its standard error, ns, of every bench under a folder.
fn estimates(folder: &Path, found: &mut BTreeMap<String, [f64; 2]>) -> Outcome<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if !path.is_dir() {
            continue;
        }
        let read = |name: &str| -> Outcome<serde_json::Value> {
            Ok(serde_json::from_slice(&std::fs::read(path.join(name))?)?)
        };
        if path.ends_with("new") && path.join("estimates.json").exists() {
            let median = &read("estimates.json")?["median"];
            let number = |key: &str| median[key].as_f64().ok_or("criterion's estimates have no median");
            let id = read("benchmark.json")?["full_id"].as_str().unwrap_or_default().to_string();
            found.insert(id, [number("point_estimate")?, number("standard_error")?]);
        } else {
            estimates(&path, found)?;
        }
    }
    Ok(())
}

#[derive(Deserialize)]
struct Work {
    bench: String,
    unknowns: usize,
    applications: usize,
    bytes: usize,
}

fn measured(args: &Args) -> Outcome<Vec<Entry>> {
    let mut found = BTreeMap::new();
    estimates(&args.criterion, &mut found)?;
    let work: Vec<Work> =
        csv::Reader::from_path(args.criterion.join("work.csv"))?.deserialize().collect::<Result<_, _>>()?;
    let floor =
        *found.get(FLOOR).ok_or_else(|| format!("{FLOOR} was not run; run cargo bench --bench costs"))?;
    let groups = ["operator/", "strategy/", "geometry/", "study/"];
    let own = found.iter().filter(|(id, _)| groups.iter().any(|g| id.starts_with(g)));
    Ok(own
        .map(|(bench, [median, error])| {
            let work = work.iter().find(|w| w.bench == *bench);
            Entry {
                date: args.date.clone(),
                commit: args.commit.clone(),
                machine: args.machine.clone(),
                bench: bench.clone(),
                unknowns: work.map(|w| w.unknowns),
                applications: work.map(|w| w.applications),
                bytes_per_unknown: work.map(|w| (w.bytes as f64 / w.unknowns as f64).round()),
                median_ns: median.round(),
                ratio: median / floor[0],
                noise: (error / median).hypot(floor[1] / floor[0]),
            }
        })
        .collect())
}

/// What is new against the baseline.
struct News {
    /// Runs that the baseline is the median of, at least for most benches.
    baseline: usize,
    /// Common factor of all times: the machine's.
    drift: f64,
    /// Benches whose time or work has changed, the unit among them, in words.
    changes: BTreeMap<String, String>,
}

/// Earlier runs of the baseline, at most and at least.
const BASELINE: [usize; 2] = [3, 7];

impl News {
    fn of(run: &[Entry], history: &[Entry]) -> News {
        let earlier = |e: &Entry| {
            let alike = history.iter().filter(|h| h.bench == e.bench && h.machine == e.machine);
            alike.rev().take(BASELINE[1]).cloned().collect::<Vec<Entry>>()
        };
        let known: Vec<(&Entry, Vec<Entry>)> =
            run.iter().map(|e| (e, earlier(e))).filter(|(_, all)| !all.is_empty()).collect();
        let factor =
            |e: &Entry, all: &[Entry]| e.median_ns / median(all.iter().map(|h| h.median_ns).collect());
        let drift = median(known.iter().map(|(e, all)| factor(e, all)).collect());
        let baseline = known.iter().map(|(_, all)| all.len()).max().unwrap_or(0);
        let change = |(e, all): &(&Entry, Vec<Entry>)| {
            let said = work_change(e, &all[0]).or_else(|| time_change(e, all, factor(e, all) / drift))?;
            Some((e.bench.clone(), said))
        };
        News { baseline, drift, changes: known.iter().filter_map(change).collect() }
    }
}

/// Work does not depend on the machine: one earlier run is enough to compare with.
fn work_change(now: &Entry, last: &Entry) -> Option<String> {
    let (before, after) = (last.applications?, now.applications?);
    (before != after).then(|| format!("applications {before} → {after}"))
}

/// A time that has changed beyond the machine's drift and the noise of the baseline.
fn time_change(now: &Entry, earlier: &[Entry], factor: f64) -> Option<String> {
    if earlier.len() < BASELINE[0] {
        return None;
    }
    let times: Vec<f64> = earlier.iter().map(|e| e.median_ns.ln()).collect();
    let middle = median(times.clone());
    let scatter = median(times.iter().map(|t| (t - middle).abs()).collect());
    // A median deviation of 1 is a standard deviation of 1.48.
    let noise = 4.0 * (1.48 * scatter).hypot(now.noise);
    let beyond = factor.ln().abs() > SMALLEST_CHANGE.max(noise);
    beyond.then(|| {
        format!(
            "time {:+.0} % beside the other benches (noise {:.0} %)",
            100.0 * (factor - 1.0),
            100.0 * noise
        )
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(1.0)
}

/// Benches that differ in size only: all but the last part of the name.
fn series<'a>(run: &'a [Entry], value: impl Fn(&Entry) -> Option<f64> + 'a) -> Vec<Curve> {
    let mut curves: BTreeMap<&str, Vec<(f64, f64)>> = BTreeMap::new();
    for entry in run {
        if let (Some(unknowns), Some(y), Some((name, _))) =
            (entry.unknowns, value(entry), entry.bench.rsplit_once('/'))
        {
            curves.entry(name).or_default().push((unknowns as f64, y));
        }
    }
    let sorted = |(name, mut points): (&str, Vec<(f64, f64)>)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Curve::new(name, Style::Data, points)
    };
    curves.into_iter().filter(|c| c.1.len() > 1).map(sorted).collect()
}

fn costs(run: &[Entry]) -> Chart {
    let mut curves = series(run, |e| Some(1e-9 * e.median_ns));
    let guide = curves.first().map(|c| {
        let [x0, y0, _] = c.points[0];
        let at = |p: &[f64; 3]| (p[0], y0 * p[0] * p[0].ln() / (x0 * x0.ln()));
        Curve::new("N log N", Style::Guide, c.points.iter().map(at))
    });
    for curve in &mut curves {
        if let Some(slope) = curve.exponent() {
            curve.name = format!("{}: N^({})", curve.name, slope.in_words(2));
        }
    }
    curves.extend(guide);
    Chart::log_log("Cost against size", "unknowns N", "seconds", curves)
}

fn bytes(run: &[Entry]) -> Chart {
    let curves = series(run, |e| e.bytes_per_unknown.filter(|_| e.bench.starts_with("strategy")));
    Chart::log_log("Memory", "unknowns N", "bytes per unknown", curves)
}

/// Geometric mean of each group's times over those of the first run, against the day.
fn trend(history: &[Entry]) -> Chart {
    let mut runs: Vec<&str> = history.iter().map(|e| e.date.as_str()).collect();
    runs.dedup();
    let mut groups: Vec<&str> =
        history.iter().filter_map(|e| e.bench.rsplit_once('/')).map(|p| p.0).collect();
    groups.sort_unstable();
    groups.dedup();
    let curves = groups.iter().map(|group| group_curve(group, &runs, history)).collect();
    let start = runs.first().and_then(|date| days(date)).unwrap_or(0.0);
    let x_ticks = runs
        .iter()
        .filter_map(|date| Some((days(date)? - start, date.get(5..16).unwrap_or(date).replace('T', " "))));
    Chart {
        log: [false, true],
        x_ticks: x_ticks.collect(),
        ..Chart::log_log(
            "Costs over the runs",
            "month-day and time of the run, UTC",
            "time ÷ that of the first run (geometric mean)",
            curves,
        )
    }
}

fn group_curve(group: &str, runs: &[&str], history: &[Entry]) -> Curve {
    let in_group = |e: &&Entry| e.bench.rsplit_once('/').is_some_and(|p| p.0 == group);
    let first = |bench: &str| history.iter().find(|e| e.bench == bench).map_or(f64::NAN, |e| e.median_ns);
    let start = runs.first().and_then(|date| days(date)).unwrap_or(0.0);
    let point = |date: &&str| {
        let own = history.iter().filter(|e| e.date == **date).filter(in_group);
        let logs: Vec<f64> = own.map(|e| (e.median_ns / first(&e.bench)).ln()).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        (!logs.is_empty()).then(|| (days(date).unwrap_or(start) - start, mean.exp()))
    };
    Curve::new(group, Style::Data, runs.iter().filter_map(point))
}

/// Days since 1970 of `2026-11-21T14:32Z`.
fn days(date: &str) -> Option<f64> {
    let number = |range: std::ops::Range<usize>| date.get(range)?.parse::<i64>().ok();
    let (year, month, day) = (number(0..4)?, number(5..7)?, number(8..10)?);
    let (hour, minute) = (number(11..13).unwrap_or(0), number(14..16).unwrap_or(0));
    // Hinnant's days_from_civil: years begin in March.
    let y = if month <= 2 { year - 1 } else { year };
    let of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
    let of_era = (y % 400) * 365 + (y % 400) / 4 - (y % 400) / 100 + of_year;
    let whole = (y / 400) * 146_097 + of_era - 719_468;
    Some(whole as f64 + (hour * 60 + minute) as f64 / 1440.0)
}

fn page(run: &[Entry], news: &News, words: &[Word]) -> String {
    let mut text = String::from("# Benchmarks\n\n");
    let (unit, things): (Vec<_>, Vec<_>) = news.changes.iter().partition(|(bench, _)| *bench == FLOOR);
    let commit = run.first().map_or("", |e| e.commit.as_str());
    if !things.is_empty() {
        text += "**Changed since earlier runs:**\n\n";
        for (bench, change) in things {
            let word = words.iter().find(|w| w.bench == *bench && commit.starts_with(&w.commit));
            text +=
                &format!("- {bench}: {change}{}\n", word.map_or(String::new(), |w| format!(": {}", w.words)));
        }
        text += "\n";
    }
    for (bench, change) in unit {
        text += &format!(
            "The unit of the table's ratios has changed: {bench}: {change}. Ratios of other days are in another unit.\n\n"
        );
    }
    text += &match news.baseline {
        0 => "There is no earlier run on this machine to compare with.\n\n".to_string(),
        n if n < BASELINE[0] => format!(
            "Times are compared once there are {} earlier runs on one machine (now {n}); work is compared from the first.\n\n",
            BASELINE[0]
        ),
        n => format!(
            "Compared with the median of {n} earlier runs on this machine; all times together have changed by {:+.0} %.\n\n",
            100.0 * (news.drift - 1.0)
        ),
    };
    if let Some(first) = run.first() {
        text += &format!("{}, commit {}, {}. ", first.date, first.commit, first.machine);
    }
    text += &format!("`scripts/bench-track` makes this page; the unit of all ratios is `{FLOOR}`.\n\n");
    text += "![Time of every bench against its unknowns](costs.svg)\n![Memory of every bench against its unknowns](bytes.svg)\n";
    text += "![Ratios to the floor, night by night](trend.svg)\n\n";
    text += "| bench | unknowns | applications | bytes per unknown | median, ms | ratio to the floor | noise |\n|---|---|---|---|---|---|---|\n";
    for e in run {
        let whole = |n: Option<usize>| n.map_or("–".into(), |n| n.to_string());
        let bytes = e.bytes_per_unknown.map_or("–".into(), |b| format!("{b:.0}"));
        text += &format!(
            "| {} | {} | {} | {bytes} | {:.3} | {:.4} | {:.0} % |\n",
            e.bench,
            whole(e.unknowns),
            whole(e.applications),
            1e-6 * e.median_ns,
            e.ratio,
            100.0 * e.noise
        );
    }
    text
}
