//! Compares the last run of the `costs` bench with earlier ones and draws costs and trends.
//!
//! Times drift from machine to machine and from hour to hour, so all comparisons are of ratios: a bench's median over
//! that of the transforms alone (`operator/floor` on the largest grid) in the same run.

#[allow(dead_code, reason = "the claims draw other plots, too")]
use clap::Parser;
use inkwave::draw::log_plot::{Curve, LogPlot, Style};
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
/// A ratio must change by this much, and by four times its noise, to be flagged.
const SMALLEST_CHANGE: f64 = 0.2;

fn main() -> Outcome<()> {
    let args = Args::parse();
    let path = args.out.join("history.csv");
    let mut history: Vec<Entry> = if path.exists() {
        csv::Reader::from_path(&path)?.deserialize().collect::<Result<_, _>>()?
    } else {
        Vec::new()
    };
    let run = measured(&args)?;
    let flags: BTreeMap<String, String> =
        run.iter().filter_map(|e| Some((e.bench.clone(), flag(e, &history)?))).collect();
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
    safely::write(&args.out.join("README.md"), page(&run, &flags).as_bytes())?;
    flags.iter().for_each(|(bench, change)| println!("{bench}: {change}"));
    println!("{} benches, {} beyond noise; {}", run.len(), flags.len(), args.out.join("README.md").display());
    Ok(())
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

/// What changed against the median of earlier runs, if it is more than noise.
fn flag(entry: &Entry, history: &[Entry]) -> Option<String> {
    let earlier: Vec<&Entry> = history.iter().filter(|e| e.bench == entry.bench).collect();
    let last = earlier.last()?;
    if let (Some(before), Some(now)) = (last.applications, entry.applications)
        && before != now
    {
        return Some(format!("applications {before} → {now}"));
    }
    let mut ratios: Vec<f64> = earlier.iter().rev().take(7).map(|e| e.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let change = entry.ratio / ratios[ratios.len() / 2] - 1.0;
    let noise = 4.0 * entry.noise.hypot(last.noise);
    (change.abs() > SMALLEST_CHANGE.max(noise))
        .then(|| format!("ratio {:+.0} % (noise {:.0} %)", 100.0 * change, 100.0 * noise))
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

/// Slope of a least-squares line through logarithms.
fn exponent(curve: &Curve) -> f64 {
    let points: Vec<[f64; 2]> = curve.points.iter().map(|p| [p[0].ln(), p[1].ln()]).collect();
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let square: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
    points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / square
}

fn costs(run: &[Entry]) -> LogPlot {
    let mut curves = series(run, |e| Some(1e-9 * e.median_ns));
    let guide = curves.first().map(|c| {
        let [x0, y0, _] = c.points[0];
        let at = |p: &[f64; 3]| (p[0], y0 * p[0] * p[0].ln() / (x0 * x0.ln()));
        Curve::new("N log N", Style::Guide, c.points.iter().map(at))
    });
    curves.iter_mut().for_each(|c| c.name = format!("{}: N^{:.2}", c.name, exponent(c)));
    curves.extend(guide);
    LogPlot::log_log("Cost against size", "unknowns N", "seconds", curves)
}

fn bytes(run: &[Entry]) -> LogPlot {
    let curves = series(run, |e| e.bytes_per_unknown.filter(|_| e.bench.starts_with("strategy")));
    LogPlot::log_log("Memory", "unknowns N", "bytes per unknown", curves)
}

/// Geometric mean of each group's ratios, run by run.
fn trend(history: &[Entry]) -> LogPlot {
    let mut runs: Vec<&str> = history.iter().map(|e| e.date.as_str()).collect();
    runs.dedup();
    let mut groups: Vec<&str> =
        history.iter().filter_map(|e| e.bench.rsplit_once('/')).map(|p| p.0).collect();
    groups.sort_unstable();
    groups.dedup();
    let curve = |group: &&str| {
        let points = runs.iter().enumerate().filter_map(|(i, run)| {
            let own = history
                .iter()
                .filter(|e| e.date == **run && e.bench.rsplit_once('/').is_some_and(|p| *p.0 == **group));
            let logs: Vec<f64> = own.map(|e| e.ratio.ln()).collect();
            (!logs.is_empty()).then(|| (i as f64 + 1.0, (logs.iter().sum::<f64>() / logs.len() as f64).exp()))
        });
        Curve::new(*group, Style::Data, points)
    };
    let curves = groups.iter().map(curve).collect();
    LogPlot {
        log: [false, true],
        ..LogPlot::log_log("Costs over the runs", "run", "time ÷ floor (geometric mean)", curves)
    }
}

fn page(run: &[Entry], flags: &BTreeMap<String, String>) -> String {
    let mut text = String::from("# Benchmarks\n\n");
    if !flags.is_empty() {
        text += "**Beyond noise since earlier runs:**\n\n";
        flags.iter().for_each(|(bench, change)| text += &format!("- {bench}: {change}\n"));
        text += "\n";
    }
    if let Some(first) = run.first() {
        text += &format!("{}, commit {}, {}. ", first.date, first.commit, first.machine);
    }
    text += &format!("`scripts/bench-track` makes this page; the unit of all ratios is `{FLOOR}`.\n\n");
    text += "![](costs.svg)\n![](bytes.svg)\n![](trend.svg)\n\n";
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
