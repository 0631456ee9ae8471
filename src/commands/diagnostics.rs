//! Reports of study errors: the offending line of the file, what is wrong and what to try.

use super::say::printable;
use inkwave::input::fault::{Fault, StudyError};
use inkwave::input::locate::span_of;
use miette::{Diagnostic, LabeledSpan, NamedSource, Report};
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

type SourceText = Arc<NamedSource<String>>;

/// Longest source line quoted, bytes (the diagnostics library's limit is 65 535 columns).
const LONGEST_LINE: usize = 1000;

/// Source text to quote from; `None` if a line is too long to quote.
fn source(path: &std::path::Path, text: String) -> Option<SourceText> {
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
        let (message, help) = (printable(message), help.map(printable));
        Self { message, help, labels: Vec::from_iter(label), text, others: Vec::new() }
    }

    /// A fault at its place in the text; its message follows `start`.
    fn fault(start: &str, fault: &Fault, text: &Option<SourceText>) -> Self {
        let span = text.as_ref().and_then(|text| span_of(text.inner(), &fault.field));
        let found = printable(&format!("found {}", fault.found));
        let label = span.map(|span| LabeledSpan::new_with_span(Some(found), span));
        Self::new(&format!("{start}{fault}"), Some(&fault.remedy), label, text.clone())
    }
}
