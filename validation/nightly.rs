//! The nightly accuracy report: every claim at its full level, one page, one history.
//!
//! Each claim runs in a process of its own, so that a crash loses no other; results are kept as they come, so that an
//! interrupted night goes on where it was. `scripts/nightly` calls this.

mod changes;
mod history;
mod manifest;
mod page;

use clap::Parser;
use inkwave::store::{Record, Store};
use inkwave_validation::claim::{Claim, Findings, Level};
use inkwave_validation::{claim, claims};
use manifest::Manifest;
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

/// Measures all claims and writes the accuracy report.
#[derive(Parser)]
struct Args {
    /// Folder of the report; reports/latest for a whole night, target/nightly/report for part of one.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Table that one line per claim and night is added to.
    #[arg(long, default_value = "reports/history.csv")]
    history: PathBuf,
    /// Folder of finished measurements; after an interruption the same program goes on there.
    #[arg(long, default_value = "target/nightly")]
    work: PathBuf,
    /// Puts the first tables between the markers of this Markdown file.
    #[arg(long)]
    readme: Option<PathBuf>,
    /// The level of `cargo test` instead of the full one.
    #[arg(long)]
    quick: bool,
    /// Only claims whose id contains this; the report then lacks the others.
    #[arg(long)]
    only: Option<String>,
    /// Date and time for the manifest and the history.
    #[arg(long, default_value = "unknown")]
    date: String,
    /// Measures one claim and keeps the result (what the program calls itself with).
    #[arg(long, hide = true)]
    measure: Option<String>,
    /// Prints what claim 24 keeps of a truth, from the folder of a finished run of validation/data/intervals*.toml, named
    /// like that file without its ending.
    #[arg(long, hide = true)]
    truth: Option<PathBuf>,
    /// Makes the pages anew from the numbers that lie beside them, and measures nothing.
    #[arg(long)]
    redraw: bool,
    /// Puts a seal under a page that another script has made.
    #[arg(long, hide = true)]
    seal: Option<PathBuf>,
}

/// One claim's night.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measured {
    pub id: String,
    pub seconds: f64,
    pub findings: Findings,
    /// Why there are no findings.
    pub failure: Option<String>,
}

impl Record for Measured {
    const KIND: &'static str = "claim";
}

impl Measured {
    pub fn holds(&self) -> bool {
        self.failure.is_none() && self.findings.hold()
    }

    /// The smallest margin; 0 for a claim that could not be measured.
    pub fn margin(&self) -> f64 {
        match (&self.failure, self.findings.tightest()) {
            (None, Some(check)) => check.margin(),
            _ => 0.0,
        }
    }
}

/// A claim beside its night.
pub struct Judged {
    pub claim: &'static Claim,
    pub measured: Measured,
}

static ALL: &[Claim] = &claims::ALL;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let args = Args::parse();
    if let Some(page) = &args.seal {
        let text = inkwave::draw::seal::sealed(&std::fs::read_to_string(page)?);
        inkwave::store::safely::write(page, text.as_bytes())?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(folder) = &args.truth {
        println!("{:#}", claims::intervals::truth(folder));
        return Ok(ExitCode::SUCCESS);
    }
    if args.redraw {
        let out = args.out.unwrap_or_else(|| "reports/latest".into());
        return redraw(&out, &args.history);
    }
    let level = if args.quick { Level::Quick } else { Level::Full };
    let manifest = Manifest::gather(&args.date, level)?;
    let store: Store<Measured> =
        Store::open(args.work.join(&manifest.program_hash[..16]).join(level.name()))?;
    if let Some(id) = &args.measure {
        return measure(id, level, &store);
    }
    let wanted = |c: &&Claim| args.only.as_ref().is_none_or(|part| c.id.contains(part.as_str()));
    let chosen: Vec<&'static Claim> = ALL.iter().filter(wanted).collect();
    if chosen.is_empty() {
        return Err("no claim's id contains that; validation/claims/mod.rs lists them".into());
    }
    let whole = args.only.is_none() && level == Level::Full;
    let folder = if whole { "reports/latest" } else { "target/nightly/report" };
    let out = args.out.clone().unwrap_or_else(|| folder.into());
    let judged: Vec<Judged> = chosen
        .iter()
        .enumerate()
        .map(|(i, claim)| {
            let measured = night_of(claim, level, &args.work, &store)?;
            let verdict = if measured.holds() { "holds" } else { "FAILS" };
            let n = chosen.len();
            let margin = measured.margin();
            let seconds = measured.seconds;
            eprintln!("[{}/{n}] {} {verdict}, margin {margin:.2} ({seconds:.0} s)", i + 1, claim.id);
            Ok(Judged { claim, measured })
        })
        .collect::<std::io::Result<_>>()?;
    let nights = history::read(&args.history, level)?;
    page::write(&out, &manifest, &judged, &nights)?;
    if let Some(readme) = args.readme.as_ref().filter(|_| whole) {
        page::splice(readme, &judged)?;
    }
    if args.only.is_none() {
        history::append(&args.history, &manifest, &judged)?;
    }
    // The night is over: the next one measures anew.
    judged.iter().try_for_each(|j| store.remove(j.claim.id))?;
    let failing = judged.iter().filter(|j| !j.measured.holds()).count();
    eprintln!("{} of {} claims hold; report in {}", judged.len() - failing, judged.len(), out.display());
    Ok(if failing == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The kept result, or a new one from a process of its own. Failed measurements are tried again.
fn night_of(claim: &Claim, level: Level, work: &Path, store: &Store<Measured>) -> std::io::Result<Measured> {
    if let Some(kept) = store.get(claim.id).filter(|m| m.failure.is_none()) {
        return Ok(kept);
    }
    let clock = Instant::now();
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["--measure", claim.id, "--work"]).arg(work);
    if level == Level::Quick {
        command.arg("--quick");
    }
    let output = command.output()?;
    store.database().refresh()?;
    if let Some(found) = store.get(claim.id).filter(|_| output.status.success()) {
        return Ok(found);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let reason =
        said.lines().find(|l| !l.trim().is_empty() && !l.contains("panicked at")).unwrap_or("no message");
    let failure = Some(format!("{}: {reason}", output.status));
    Ok(Measured {
        id: claim.id.into(),
        seconds: clock.elapsed().as_secs_f64(),
        findings: Findings::default(),
        failure,
    })
}

fn measure(id: &str, level: Level, store: &Store<Measured>) -> Result<ExitCode, Box<dyn Error>> {
    let claim = ALL.iter().find(|c| c.id == id).ok_or_else(|| format!("no claim {id}"))?;
    let clock = Instant::now();
    let mut findings = Findings::default();
    (claim.measure)(level, &mut findings);
    let failure = findings.without_gaps();
    let measured = Measured { id: id.into(), seconds: clock.elapsed().as_secs_f64(), findings, failure };
    store.put(id, &measured)?;
    Ok(ExitCode::SUCCESS)
}

/// What `numbers.json` keeps of a night.
#[derive(Deserialize)]
struct Kept {
    manifest: Manifest,
    claims: Vec<Measured>,
}

/// The pages of a night that is over, as they are made today.
fn redraw(folder: &Path, history: &Path) -> Result<ExitCode, Box<dyn Error>> {
    let kept: Kept = serde_json::from_slice(&std::fs::read(folder.join("numbers.json"))?)?;
    let mut nights = history::read(history, kept.manifest.level)?;
    nights.retain(|night| night.date < kept.manifest.date);
    let claim_of = |measured: Measured| {
        let claim = ALL.iter().find(|c| c.id == measured.id);
        claim.map(|claim| Judged { claim, measured })
    };
    let judged: Vec<Judged> = kept.claims.into_iter().filter_map(claim_of).collect();
    page::write(folder, &kept.manifest, &judged, &nights)?;
    Ok(ExitCode::SUCCESS)
}
