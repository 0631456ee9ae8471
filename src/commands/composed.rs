//! `inkwave run` of a composed layer: its slabs are solved one after another, and any thickness of it
//! follows from them.

use super::again::to_resume;
use super::diagnostics::{run_report, tell_damages};
use super::progress::Progress;
use super::work::opened;
use inkwave::evaluate::manifest::Status;
use inkwave::input::study::{Composed, Study};
use inkwave::report::composed::{lines, publish};
use inkwave::run::RunSettings;
use inkwave::store::marker::Holds;
use inkwave::sweep::Sweep;
use inkwave::sweep::alone::run_portions;
use inkwave::sweep::plan::by_size;
use miette::miette;
use std::path::Path;

/// Runs a composed layer and prints its colours.
pub(super) fn run(study: &Study, path: &Path, settings: RunSettings) -> miette::Result<()> {
    let folder = opened(path, Holds::Study)?;
    let progress = Progress::new();
    progress.expect(study.solves(), false);
    let solved = progress.during(|| run_portions(study, &folder, settings, &progress));
    let solved = solved.inspect_err(|_| folder.discard_when_empty()).map_err(run_report)?;
    solved.iter().for_each(|(_, collected)| tell_damages(&collected.damages));
    let published = publish(study, &solved, &folder);
    let published = published.map_err(|error| miette!(help = to_resume(), "{error}"))?;
    published.remarks.iter().for_each(super::say::note);
    for line in lines(&published) {
        say!("{}: {line}", study.title)?;
    }
    say!("Report: {}", folder.path().join("report.html").display())?;
    if published.status == Status::Complete {
        return Ok(());
    }
    let help = if progress.stopped() { to_resume() } else { "the report lists the reasons".to_owned() };
    Err(miette!(help = help, "not every solve has a result: the results are marked as partial"))
}

/// Layers from this thickness on are offered to be composed, µm: two slabs of the usual 2 µm.
const WORTH_COMPOSING_UM: f64 = 4.0;

/// Says what a thick layer would cost if it were composed of slabs.
pub(super) fn offer(mut study: Study, settings: RunSettings) -> miette::Result<()> {
    let um = study.layer.thickness_um;
    let plane = study.packing.relief.is_none() && study.variation.thickness_std_um == 0.0;
    if study.layer.composed.is_some() || um < WORTH_COMPOSING_UM || !plane || study.pigments.is_empty() {
        return Ok(());
    }
    let whole = by_size(&Sweep::of_one("", study.clone()), settings).core_seconds;
    let slab_um = um / (0.5 * um).round();
    let composed = Composed { slab_um, directions: [3, 3], thicknesses_um: vec![um] };
    study.layer.composed = Some(composed);
    let slabs = by_size(&Sweep::of_one("", study), settings).core_seconds;
    say!(
        "[layer.composed] composes these {um} µm of slabs of {slab_um:.2} µm: by size some {:.1} processor hours \
         instead of {:.1}, whatever the thickness",
        slabs / 3600.0,
        whole / 3600.0
    )
}
