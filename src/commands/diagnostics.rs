//! Study errors as a person wants to see them: the line of the file, what is wrong with it, what to try.

use super::say::printable;
use inkwave::input::fault::{Fault, StudyError};
use inkwave::input::locate::span_of;
use inkwave::input::tree::SyntaxFault;
use miette::{Diagnostic, LabeledSpan, NamedSource, Report, Severity, SourceCode};
use std::fmt;
use std::sync::Arc;

/// Turns a study error into a report with the offending lines.
pub fn study_report(error: StudyError) -> Report {
    match error {
        StudyError::Syntax { path, text, span, message, remedy } => {
            let fault = SyntaxFault { message, remedy: "", span: span.clone() };
            let message = format!("{}: {}", path.display(), fault.in_words(&text));
            let label = span.map(|span| LabeledSpan::new_with_span(Some("here".into()), span));
            let source = source(&path, text);
            Report::new(Shown { message, help: Some(remedy), label, source, others: Vec::new() })
        }
        StudyError::Values { path, text, faults } => {
            let source = source(&path, text);
            let mut shown: Vec<Shown> = faults.iter().map(|fault| Shown::fault(fault, &source)).collect();
            if shown.len() == 1 {
                let mut only = shown.remove(0);
                if source.is_none() {
                    only.message = format!("{}: {}", path.display(), only.message);
                }
                return Report::new(only);
            }
            let message = format!("{}: {} fields need another value", path.display(), shown.len());
            Report::new(Shown { message, help: None, label: None, source: None, others: shown })
        }
        unreadable @ StudyError::Unreadable { .. } => {
            let help = Some("give the path of a study file, such as examples/yellow.toml".to_owned());
            Report::new(Shown {
                message: unreadable.to_string(),
                help,
                label: None,
                source: None,
                others: Vec::new(),
            })
        }
    }
}

type SourceText = Arc<NamedSource<String>>;

/// Longest line that is shown, bytes; the printer's limit is 65 535 columns, a reader's is nearer.
const LONGEST_LINE: usize = 1000;

/// The text to show lines of; none where they are too long to be shown.
fn source(path: &std::path::Path, text: String) -> Option<SourceText> {
    let readable = text.lines().all(|line| line.len() <= LONGEST_LINE);
    let text: String = text.chars().map(harmless).collect();
    readable.then(|| Arc::new(NamedSource::new(path.display().to_string(), text).with_language("toml")))
}

/// A character that a terminal does not obey, of as many bytes, so that places stay.
fn harmless(c: char) -> char {
    match c {
        '\n' | '\r' | '\t' => c,
        c if c.is_control() => {
            if c.is_ascii() {
                '?'
            } else {
                '¿'
            }
        }
        c => c,
    }
}

#[derive(Debug)]
struct Shown {
    message: String,
    help: Option<String>,
    label: Option<LabeledSpan>,
    source: Option<SourceText>,
    others: Vec<Shown>,
}

impl Shown {
    fn fault(fault: &Fault, source: &Option<SourceText>) -> Self {
        let label = |span| LabeledSpan::new_with_span(Some(format!("found {}", fault.found)), span);
        Self {
            message: fault.to_string(),
            help: Some(fault.remedy.clone()),
            label: source.as_ref().and_then(|source| span_of(source.inner(), &fault.field)).map(label),
            source: source.clone(),
            others: Vec::new(),
        }
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&printable(&self.message))
    }
}

impl std::error::Error for Shown {}

impl Diagnostic for Shown {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Error)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(printable(help)) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_deref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.label.clone().map(|label| Box::new(std::iter::once(label)) as Box<dyn Iterator<Item = _>>)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let others = self.others.iter().map(|other| other as &dyn Diagnostic);
        (!self.others.is_empty()).then(|| Box::new(others) as Box<dyn Iterator<Item = _>>)
    }
}
