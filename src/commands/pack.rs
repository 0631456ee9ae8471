//! `inkwave pack STUDY.toml`: packings alone, with their files, pictures and statistics.

use super::diagnostics::{folder_report, mixed_up_report};
use super::progress::style;
use super::terminal::{StopFlag, note};
use super::work::opened;
use clap::Args;
use indicatif::ProgressBar;
use inkwave::ink::statistics::ReachedSizes;
use inkwave::ink::{Method, PackProgress, PackWatch, Packing, pack};
use inkwave::input::Study;
use inkwave::input::load::{load_packing, stem};
use inkwave::numerics::allowed::brief;
use inkwave::report::packing::{is_of_one_packing, write_report};
use inkwave::run::memory::usable;
use inkwave::store::marker::Holds;
use miette::{IntoDiagnostic, Result, WrapErr};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// Pack the grains of a study and report their statistics, without solving the wave equation
#[derive(Args, Debug)]
pub struct PackArgs {
    /// Study file (TOML); light, indices and paper may be left out
    pub study: PathBuf,
    /// Output folder (default: the study's name followed by "-packing"; created if missing)
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Number of realisations (default: the study's)
    #[arg(short, long)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    pub realisations: Option<u16>,
    /// Seed (default: the study's)
    #[arg(short, long)]
    pub seed: Option<u64>,
}

/// Reads the study, packs every realisation, writes the report.
pub fn run(args: &PackArgs) -> Result<()> {
    let mut study = load_packing(&args.study).map_err(|error| mixed_up_report(error, "study"))?;
    study.remarks.iter().for_each(note);
    study.packing.seed = args.seed.unwrap_or(study.packing.seed);
    study.realisations = args.realisations.map_or(study.realisations, usize::from);
    if let Some(composed) = study.composed() {
        note!(
            "layer.composed: this packs one slab of {} µm between walls; `inkwave run` takes slabs without walls where they join",
            brief(composed.slab_um)
        );
    }
    let stop = StopFlag::listen();
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(stem(&args.study) + "-packing"));
    let folder = opened(&folder, Holds::Packings)?;
    folder.mark_partial().map_err(folder_report)?;
    let packings = (0..study.realisations).map(|k| one(&study, k, &stop)).collect::<Result<Vec<_>>>();
    let packings = packings.inspect_err(|_| folder.discard_when_empty())?;
    stop.end_at_once(true);
    let pigments: Vec<_> = study.pigments.iter().map(|p| (p.name.clone(), p.grains.shape.clone())).collect();
    folder.remove_files(is_of_one_packing).map_err(folder_report)?;
    let (statistics, page) =
        write_report(folder.path(), &study.title, &pigments, &packings).into_diagnostic()?;
    statistics.remarks.iter().for_each(note);
    folder.complete().map_err(folder_report)?;
    say!("report: {}", page.display())
}

fn one(study: &Study, realisation: usize, stop: &StopFlag) -> Result<Packing> {
    let start = Instant::now();
    let bar = ProgressBar::new(0).with_style(style("{prefix} {spinner} {msg} [{elapsed}]"));
    bar.set_prefix(format!("realisation {}/{}", realisation + 1, study.realisations));
    let request = study.packing_request(realisation);
    let packed = request.fits(usable()).and_then(|()| pack(&request, &mut PackBar { bar: &bar, stop }));
    bar.finish_and_clear();
    let packing = packed.into_diagnostic().wrap_err_with(|| format!("realisation {}", realisation + 1))?;
    say!("{}", summary(&packing, realisation, start.elapsed().as_secs_f64()))?;
    Ok(packing)
}

fn summary(packing: &Packing, realisation: usize, seconds: f64) -> String {
    let account = packing.account();
    let fraction = fraction_in_words(packing);
    let sweeps = if account.sweeps > 0 { format!(", {} sweeps", account.sweeps) } else { String::new() };
    let sizes = |k: usize| {
        Some(format!("; pigment {}: d10, d50, d90 {}", k + 1, ReachedSizes::of(packing, k)?.in_words()))
    };
    let sizes: String = (0..packing.shares().len()).filter_map(sizes).collect();
    let by = match account.method {
        Method::Given | Method::Voxels => format!(", {}", account.method.in_words()),
        method => format!(" by {} in {} steps", method.in_words(), account.steps),
    };
    let notes: String = account.notes.iter().map(|n| format!("; {n}")).collect();
    format!(
        "realisation {}: {} grains{by}{sweeps}, {fraction}, {seconds:.2} s{sizes}{notes}",
        realisation + 1,
        packing.grains().len(),
    )
}

/// The volume fraction of all pigments; in a stack that of each pigment in its own layer.
fn fraction_in_words(packing: &Packing) -> String {
    let shares = packing.shares();
    if packing.layers_um().len() > 1 {
        let each = shares.iter().map(|s| format!("{:.6} ({:.6})", s.achieved_fraction, s.requested_fraction));
        return format!("fractions of their layers (requested) {}", each.collect::<Vec<_>>().join(", "));
    }
    let reached: f64 = shares.iter().map(|s| s.achieved_fraction).sum();
    let requested: f64 = shares.iter().map(|s| s.requested_fraction).sum();
    format!("fraction {reached:.6} (requested {requested:.6})")
}

/// Shows progress on stderr and stops on Ctrl-C.
struct PackBar<'a> {
    bar: &'a ProgressBar,
    stop: &'a StopFlag,
}

impl PackWatch for PackBar<'_> {
    fn progress(&mut self, p: &PackProgress) -> ControlFlow<()> {
        self.bar.tick();
        self.bar.set_message(format!(
            "{} step {}: φ {:.4}, {}/{} grains, overlap energy {:.2e} µm², largest overlap {:.2e} µm",
            p.stage,
            p.step,
            p.fraction,
            p.grains_placed,
            p.grains_wanted,
            p.overlap_energy,
            p.largest_overlap_um
        ));
        if self.stop.is_raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
