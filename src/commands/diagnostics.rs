//! Reports of errors: what is wrong and what to try; of study errors also the offending line of the
//! file.

use super::terminal::{note, printable, to_resume};
use inkwave::ink::PackError;
use inkwave::input::case::CaseError;
use inkwave::input::fault::{Fault, StudyError};
use inkwave::input::locate::{key_span_of, span_of};
use inkwave::input::tree::parse_toml;
use inkwave::numerics::files;
use inkwave::run::RunError;
use inkwave::solve::SolveError;
use inkwave::solve::accuracy::AccuracyError;
use inkwave::store::folder::FolderError;
use inkwave::store::seal::{Damage, in_words};
use miette::{Diagnostic, LabeledSpan, NamedSource, Report, miette};
use std::path::Path;
use std::sync::Arc;

/// Turns a study error into a report that quotes the offending lines.
pub fn study_report(error: StudyError) -> Report {
    match error {
        StudyError::Syntax { path, text, fault } => {
            let message = format!("{}: {}", path.display(), fault.in_words(&text));
            let label = fault.span.map(|span| LabeledSpan::new_with_span(Some("here".into()), span));
            Report::new(Shown::new(&message, Some(fault.remedy), label, source(&path, text)))
        }
        StudyError::Values { path, text, faults } => {
            let source = source(&path, text);
            if let [only] = &faults[..] {
                let start = if source.is_none() { format!("{}: ", path.display()) } else { String::new() };
                return Report::new(Shown::fault(&start, only, &source));
            }
            let message = format!("{}: {} fields need another value", path.display(), faults.len());
            let others = faults.iter().map(|fault| Shown::fault("", fault, &source)).collect();
            Report::new(Shown { others, ..Shown::new(&message, None, None, None) })
        }
        unreadable @ StudyError::Unreadable { .. } => {
            let help = "give the path of a study file, such as examples/yellow.toml";
            Report::new(Shown::new(&unreadable.to_string(), Some(help), None, None))
        }
    }
}

/// [`study_report`] of a file that may be meant for another command, such as a study given to
/// `inkwave sweep`, by the tables that only one kind of file has.
pub fn mixed_up_report(error: StudyError, expected: &str) -> Report {
    let (StudyError::Values { path, text, .. } | StudyError::Syntax { path, text, .. }) = &error else {
        return study_report(error);
    };
    let is_json = path.extension().is_some_and(|e| e == "json");
    if is_json && is_study_in_json(text) {
        let help = "write it as TOML: `inkwave schema study --annotated` shows the form";
        return miette!(help = help, "{} is a study in JSON; allowed: a study in TOML", path.display());
    }
    // compositions may be JSON themselves
    let passes_for_case = is_json && expected != "composition";
    let kinds =
        [STUDY_KEYS, ["measured", "fit"], ["vary", "target"], ["base", "axis"], ["wavelength", "inputs"]];
    let (found, command) = match kinds.map(|keys| has_one(text, keys)) {
        [true, false, false, false, _] => ("study", "run"),
        [false, true, false, ..] => ("fit", "fit"),
        [false, false, true, ..] => ("design", "design"),
        [false, false, false, true, _] => ("sweep", "sweep"),
        [false, false, false, false, is_case] if is_case || passes_for_case => ("case", "solve"),
        _ => return study_report(error),
    };
    if found == expected {
        return study_report(error);
    }
    let path = path.display();
    let help = format!("run it with `inkwave {command} {path}`");
    miette!(help = help, "{path} is a {found}, and this command reads a {expected}")
}

/// Tables that only studies have.
const STUDY_KEYS: [&str; 2] = ["layer", "pigment"];

fn is_study_in_json(text: &str) -> bool {
    let parsed = serde_json::from_str::<serde_json::Value>(text);
    parsed.is_ok_and(|json| STUDY_KEYS.iter().any(|key| json.get(key).is_some()))
}

fn has_one(text: &str, keys: [&str; 2]) -> bool {
    parse_toml(text).is_ok_and(|table| keys.iter().any(|key| table.contains_key(*key)))
}

/// Report of a case that cannot be read, which may be a file for another command.
pub fn case_report(error: CaseError, path: &Path) -> Report {
    let text = files::read_text(path, files::CASE).unwrap_or_default();
    let path = path.display();
    if has_one(&text, STUDY_KEYS) {
        let help = "add --realisation 1 to solve one of its packings, or run all of it with `inkwave run`";
        return miette!(help = help, "{path} is a study, and this command reads a case");
    }
    let kinds = [("fit", ["measured", "fit"]), ("design", ["vary", "target"]), ("sweep", ["base", "axis"])];
    match kinds.into_iter().find(|(_, keys)| has_one(&text, *keys)) {
        Some((kind, _)) => {
            let help = format!("run it with `inkwave {kind} {path}`");
            miette!(help = help, "{path} is a {kind}, and this command reads a case")
        }
        None => miette!("{error}"),
    }
}

type SourceText = Arc<NamedSource<String>>;

/// Longest source line quoted, bytes (the diagnostics library's limit is 65 535 columns).
const LONGEST_LINE: usize = 1000;

/// Source text to quote from; `None` if a line is too long to quote.
fn source(path: &Path, text: String) -> Option<SourceText> {
    let readable = text.lines().all(|line| line.len() <= LONGEST_LINE);
    let text: String = text.chars().map(harmless).collect();
    readable.then(|| Arc::new(NamedSource::new(path.display().to_string(), text).with_language("toml")))
}

/// Replaces a control character by a printable one of the same length in bytes, so that spans stay
/// valid.
fn harmless(c: char) -> char {
    match c {
        '\n' | '\r' | '\t' => c,
        c if c.is_ascii_control() => '?',
        c if c.is_control() => '¿',
        c => c,
    }
}

#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{message}")]
struct Shown {
    message: String,
    #[help]
    help: Option<String>,
    #[label(collection)]
    labels: Vec<LabeledSpan>,
    #[source_code]
    text: Option<SourceText>,
    #[related]
    others: Vec<Shown>,
}

impl Shown {
    fn new(message: &str, help: Option<&str>, label: Option<LabeledSpan>, text: Option<SourceText>) -> Self {
        let message = printable(message);
        let help = help.map(printable);
        Self { message, help, labels: Vec::from_iter(label), text, others: Vec::new() }
    }

    /// A fault at its place in the text; its message follows `start`.
    fn fault(start: &str, fault: &Fault, text: &Option<SourceText>) -> Self {
        let find = if fault.is_of_key() { key_span_of } else { span_of };
        let span = text.as_ref().and_then(|text| find(text.inner(), &fault.field));
        let found = printable(&format!("found {}", fault.found));
        let label = span.map(|span| LabeledSpan::new_with_span(Some(found), span));
        Self::new(&format!("{start}{fault}"), Some(&fault.remedy), label, text.clone())
    }
}

/// Reports damaged files of a store.
pub fn tell_damages(damages: &[Damage]) {
    if let Some(told) = in_words(damages) {
        note(told);
    }
}

/// Report of a folder that cannot be used.
pub fn folder_report(error: FolderError) -> miette::Report {
    miette!(help = error.remedy(), "{error}")
}

/// [`run_report`] of work in several steps, whose finished ones count.
pub fn step_report(error: RunError) -> miette::Report {
    match error {
        RunError::Stopped => miette!(help = to_resume(), "stopped: what is solved is stored"),
        error => run_report(error),
    }
}

/// Report of a run without results.
pub fn run_report(error: RunError) -> miette::Report {
    let help = match error.cause() {
        RunError::Folder(error) => Some(error.remedy()),
        RunError::Packing { source: PackError::Blocked { .. } | PackError::NotReached { .. }, .. } => {
            Some("lower pigment.volume_fraction, take smaller grains or a thicker layer")
        }
        // These messages include what to try.
        RunError::Resolution(
            AccuracyError::Memory(_)
            | AccuracyError::TooLarge { .. }
            | AccuracyError::NotReached { .. }
            | AccuracyError::TooManyWaves { .. }
            | AccuracyError::Unphysical(_)
            | AccuracyError::Solve(SolveError::NotConverged { .. }),
        ) => None,
        RunError::Resolution(AccuracyError::Solve(_)) => {
            Some("[solver] sets strategy, tolerance and max_applications: try strategy = \"krylov\"")
        }
        RunError::Resolution(_) | RunError::Wave(_) => Some(
            "[resolution] sets the grid: raise points_per_um or planes_per_um, or give an accuracy instead",
        ),
        _ => None,
    };
    match help {
        Some(help) => miette!(help = help, "{error}"),
        None => miette!("{error}"),
    }
}
