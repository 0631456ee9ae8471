//! `inkwave run STUDY.toml`: from a study file to the picture of an ink on paper. Of a composed
//! layer the slabs are solved, and any thickness of it follows from them.

use super::diagnostics::{mixed_up_report, run_report, tell_damages};
use super::progress::{Live, Progress};
use super::sweep::{tell_others, tell_plan};
use super::terminal::{note, to_resume};
use super::work::{WorkArgs, opened};
use clap::Args;
use inkwave::evaluate::evaluated::FinishedSolves;
use inkwave::evaluate::manifest::{Count, Status};
use inkwave::input::file::ComposedTable;
use inkwave::input::load::{load, load_plates, stem};
use inkwave::input::study::{Composed, Study, StudyKind};
use inkwave::library::gather::{OWN_LIBRARY, of_solves};
use inkwave::numerics::allowed::brief;
use inkwave::report::publish::{PublishError, Published, evaluate_and_publish};
use inkwave::run::{RunSettings, Stores};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::store::safely;
use inkwave::work::alone::{RanStudy, run_any_study, stored};
use inkwave::work::plan::by_size;
use inkwave::work::variant::of_one;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};

/// Arguments of `inkwave run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Study file (TOML); `inkwave schema --annotated` prints every key
    pub study: PathBuf,
    /// Print the plan as JSON
    #[arg(long, requires = "plan")]
    pub json: bool,
    /// Solve the layers as plates of a library, between half-spaces of one index, and write no report: library.json in the
    /// output folder, or FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub library: Option<Option<PathBuf>>,
    #[command(flatten)]
    pub work: WorkArgs,
}

/// Reads, checks and runs a study.
pub fn run(args: &RunArgs) -> Result<()> {
    let is_library = args.library.is_some();
    let loaded = if is_library { load_plates(&args.study) } else { load(&args.study) };
    let study = loaded.map_err(|error| mixed_up_report(error, "study"))?;
    study.remarks.iter().for_each(note);
    let settings = args.work.settings()?;
    if args.work.plan {
        tell_plan(&of_one(&stem(&args.study), study.clone()), args.json, settings)?;
        return if args.json { Ok(()) } else { offer(study, settings) };
    }
    let of_study = study.output.folder.as_ref().filter(|_| args.work.output.is_none() && !is_library);
    let end = if is_library { "-plates" } else { "" };
    let path = of_study.map_or_else(|| args.work.folder(&args.study, end), PathBuf::from);
    let folder = opened(&path, Holds::Study)?;
    if let Some(reason) = study.no_ink() {
        note!("no paper, colour and picture: {reason}");
    }
    if let Some(reason) = by_size(&of_one("", study.clone()), settings).out_of_reach {
        note!("out of reach: {reason} (--plan gives details; Ctrl-C stops)");
    }
    let progress = Progress::new();
    progress.expect(study.solves(), study.target_delta_e.is_some());
    let publish = || is_library || publish_stored(&study, &folder);
    let live = Live::new(&folder, &progress, Box::new(publish));
    let ran = progress.during(|| run_any_study(&study, &folder, settings, &live));
    let RanStudy { solved, damages, publishes } =
        ran.inspect_err(|_| folder.discard_when_empty()).map_err(run_report)?;
    tell_damages(&damages);
    if !publishes {
        return tell_others(&folder);
    }
    if let Some(file) = &args.library {
        let file = file.clone().unwrap_or_else(|| folder.path().join(OWN_LIBRARY));
        keep_plates(&study, &solved, &file, progress.stopped())?;
        return folder.complete().into_diagnostic();
    }
    note!("evaluating the layer: numbers, error bars and pictures");
    let published = match evaluate_and_publish(&study, &solved, &folder) {
        Err(error @ PublishError::Slabs(_)) => {
            let finished = solved.finished();
            let kept = format!("{finished} of {} solves are finished and kept", study.solves());
            return Err(miette!(help = to_resume(), "{error}: {kept}"));
        }
        published => published.into_diagnostic()?,
    };
    published.remarks.iter().for_each(note);
    tell(&study, &published, &folder, progress.stopped())
}

/// Writes the plates of the layers.
fn keep_plates(study: &Study, solved: &FinishedSolves, file: &Path, stopped: bool) -> Result<()> {
    if stopped {
        let finished = solved.finished();
        let all = study.solves();
        let words = format!("no library yet: {finished} of {all} solves are finished and kept");
        return Err(miette!(help = to_resume(), "{words}"));
    }
    let library = of_solves(study, solved).map_err(|reason| miette!("{}: {reason}", study.title))?;
    let text = serde_json::to_string(&library).into_diagnostic()?;
    safely::write(file, text.as_bytes()).into_diagnostic().wrap_err_with(|| file.display().to_string())?;
    for plate in &library.plates {
        say!(
            "{}: {} µm between half-spaces of index {}",
            plate.name,
            brief(plate.thickness_um),
            library.joint.index
        )?;
    }
    if let Some(words) = study.layers_without_plates() {
        say!("{words}")?;
    }
    say!("Library: {}", file.display())
}

/// Publishes what is finished; false if that fails.
fn publish_stored(study: &Study, folder: &OutputFolder) -> bool {
    let solved = Stores::open(folder).ok().and_then(|stores| stored(study, &stores));
    solved.is_some_and(|solved| evaluate_and_publish(study, &solved, folder).is_ok())
}

/// Prints the main results, or why there is no colour, and every other number that is missing.
fn tell_results(study: &Study, published: &Published) -> Result<()> {
    for line in &published.lines {
        say!("{}: {line}", study.title)?;
    }
    if let Some(reason) = &published.no_colour {
        say!("{}: no colour: {reason}", study.title)?;
    }
    for number in &published.numbers {
        say!("{}: {number}", study.title)?;
    }
    let told = |line: &&String| published.no_colour.as_ref().is_some_and(|reason| reason.contains(*line));
    for line in published.withheld.iter().filter(|line| !told(line)) {
        say!("{}: no result: {line}", study.title)?;
    }
    Ok(())
}

/// What to do about packings, and about solves, that are missing.
const LACKING: &str = "the results are means over the packings that succeeded, and the error bars include the largest effect that the others \
     could have: lower pigment.volume_fraction, or try a smaller layer.period_um, which takes fewer grains per packing";
const FAILED: &str = "the report lists the reasons; try another solver, a finer grid or more applications";

/// Prints where the results are; incomplete results are an error, so that scripts notice.
fn tell(study: &Study, published: &Published, folder: &OutputFolder, stopped: bool) -> Result<()> {
    tell_results(study, published)?;
    say!("Report: {}", folder.path().join("report.html").display())?;
    if let (Some((widest, remedy)), Some(target), false) = (published.widest, study.target_delta_e, stopped) {
        let all = study.realisations;
        note!(
            "the 95 % interval of a colour, ΔE₀₀ {widest:.2}, is still wider than run.target_delta_e = {target} after {all} \
             realisations; what would make it narrower: {remedy}"
        );
    }
    if let Some(missing) = &published.missing_packings {
        note!("{missing}: {LACKING}");
    }
    if published.status == Status::Complete {
        return Ok(());
    }
    let Count { finished, asked } = published.solves;
    let (help, why) = match (stopped, published.failed_solves) {
        (true, _) => (to_resume(), "stopped".to_owned()),
        (false, failed) => (FAILED.to_owned(), format!("{failed} solves have no result")),
    };
    Err(miette!(
        help = help,
        "{why}: {finished} of {asked} solves are finished, the results are marked as partial"
    ))
}

/// Layers from this thickness on are offered to be composed, µm: two slabs of the usual 2 µm.
const WORTH_COMPOSING_UM: f64 = 4.0;

/// Says what a thick layer would cost if it were composed of slabs.
fn offer(mut study: Study, settings: RunSettings) -> Result<()> {
    let um = study.layer.thickness_um;
    let plane =
        study.stack.is_empty() && study.packing.relief.is_none() && study.variation.thickness_std_um == 0.0;
    if study.composed().is_some() || um < WORTH_COMPOSING_UM || !plane || study.pigments.is_empty() {
        return Ok(());
    }
    let whole = by_size(&of_one("", study.clone()), settings).core_seconds;
    let slab_um = um / (0.5 * um).round();
    study.kind = StudyKind::Composed(Composed {
        slab_um,
        directions: ComposedTable::OF_A_LAYER,
        thicknesses_um: vec![um],
        mixing: None,
        layers: Vec::new(),
        varied: None,
        joint_index: None,
    });
    let slabs = by_size(&of_one("", study), settings).core_seconds;
    say!(
        "with [layer.composed], slabs of {slab_um:.2} µm would give these {um} µm, and any other thickness, in about {:.1} \
         processor hours instead of {:.1} (estimated from the numbers of unknowns)",
        slabs / 3600.0,
        whole / 3600.0
    )
}
