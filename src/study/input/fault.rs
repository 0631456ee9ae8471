//! Errors in a study, described so that they can be corrected.

pub use crate::numerics::allowed::Allowed;
use crate::numerics::allowed::{Whole, shown, with_short_numbers};
use crate::numerics::files::named;
use serde::Serialize;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// An error in a study: the field, what was found there, what is allowed and what to try.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: found {found}; allowed: {allowed}")]
pub struct Fault {
    /// Path of the field in the study file, such as `pigment[0].volume_fraction`.
    pub field: String,
    /// The value found.
    pub found: String,
    /// What is allowed.
    pub allowed: String,
    /// What to try.
    pub remedy: String,
}

/// What is found in a list without entries.
pub const EMPTY_LIST: &str = "an empty list";

/// What is found where no key of that name exists.
pub(super) const UNKNOWN_KEY: &str = "an unknown key";

impl Fault {
    /// Whether the name of the field is wrong, not its value.
    pub fn is_of_key(&self) -> bool {
        self.found == UNKNOWN_KEY
    }

    /// An error in a field.
    pub fn new(
        field: impl Into<String>,
        found: impl fmt::Display,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            field: field.into(),
            found: with_short_numbers(&found.to_string()),
            allowed: with_short_numbers(&allowed.into()),
            remedy: with_short_numbers(&remedy.into()),
        }
    }
}

/// Why a text cannot be parsed: the parser's message and the position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SyntaxFault {
    /// The message, without the position.
    pub message: String,
    /// Suggested remedy.
    pub remedy: &'static str,
    /// Position in bytes; `None` if unknown.
    pub span: Option<Range<usize>>,
}

impl SyntaxFault {
    /// The message with line and column, if known.
    pub fn in_words(&self, text: &str) -> String {
        let Some(span) = &self.span else { return self.message.clone() };
        let before = &text[..floor_char_boundary(text, span.start)];
        let line = before.matches('\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        format!("line {line}, column {}: {}", before[start..].chars().count() + 1, self.message)
    }

    /// Adds the file that contains the error.
    pub fn in_file(self, path: &Path, text: &str) -> StudyError {
        StudyError::Syntax { path: path.to_owned(), text: text.to_owned(), fault: self }
    }
}

/// The last character boundary up to a byte.
pub(super) fn floor_char_boundary(text: &str, byte: usize) -> usize {
    (0..=byte.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

/// Why a study is invalid.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The file cannot be read.
    #[error("cannot read the study file {}: {source}", named(&path.display().to_string()))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error message.
        source: std::io::Error,
    },
    /// Not TOML.
    #[error("{}: {}", path.display(), fault.message)]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Its text, to show the line.
        text: String,
        /// What is wrong.
        fault: SyntaxFault,
    },
    /// Values are not allowed; all of them are listed.
    #[error("{}: {}", path.display(), list(faults))]
    Values {
        /// The file.
        path: PathBuf,
        /// Its text, to show the lines.
        text: String,
        /// All errors.
        faults: Vec<Fault>,
    },
}

fn list(faults: &[Fault]) -> String {
    faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("; ")
}

/// All errors in one line, each with its remedy.
impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let all = self.0.iter().map(|fault| format!("{fault}: {}", fault.remedy));
        f.write_str(&all.collect::<Vec<_>>().join("; "))
    }
}

/// Maximum length of a value in a message, characters.
const LONGEST_FOUND: usize = 200;

/// A value of bounded length.
pub(super) fn shortened(found: String) -> String {
    if found.chars().count() <= LONGEST_FOUND {
        return found;
    }
    found.chars().take(LONGEST_FOUND).chain(['…']).collect()
}

/// A value as a file writes it, cut where it is long.
pub fn as_written(value: &impl Serialize) -> String {
    let written = toml::Value::try_from(value).map(|value| value.to_string());
    shortened(written.unwrap_or_else(|_| "a value".to_owned()))
}

/// Lists those of some keys that are present in a table.
pub fn keys_in_words(table: &impl Serialize, keys: &[&str]) -> String {
    let table = toml::Table::try_from(table).unwrap_or_default();
    match keys.iter().copied().filter(|key| table.contains_key(*key)).collect::<Vec<_>>().split_last() {
        None => "none of them".into(),
        Some((only, [])) => format!("{only} alone"),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
    }
}

/// Collects the errors of a study.
#[derive(Debug, Default)]
pub struct Faults(pub Vec<Fault>);

impl Faults {
    /// Adds an error.
    pub fn push(&mut self, fault: Fault) {
        self.0.push(fault);
    }

    /// Adds an error in a field.
    pub fn add(
        &mut self,
        field: impl Into<String>,
        found: impl fmt::Display,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.push(Fault::new(field, found, allowed, remedy));
    }

    /// Adds an error unless the number is finite and allowed.
    pub fn number(&mut self, field: &str, value: f64, allowed: Allowed, remedy: &str) {
        if !allowed.holds(value) {
            self.add(field, shown(value), allowed.to_string(), remedy);
        }
    }

    /// Reports a name of a part, such as `"layer"`, that is blank or that one of the others has.
    pub fn name<'n>(
        &mut self,
        field: String,
        name: &str,
        others: impl IntoIterator<Item = &'n str>,
        part: &str,
    ) {
        if name.trim().is_empty() {
            let allowed = "a name with a letter or a digit";
            self.add(field, format!("{name:?}, a blank name"), allowed, format!("name the {part}"));
        } else if others.into_iter().any(|other| other == name) {
            let allowed = format!("a name that no other {part} has");
            self.add(field, format!("{name:?} twice"), allowed, format!("give this {part} another name"));
        }
    }

    /// Reports a title that is blank.
    pub fn title(&mut self, title: Option<&str>) {
        if let Some(blank) = title.filter(|title| title.trim().is_empty()) {
            let remedy = "write a title, or leave it out: it is then the name of the file";
            self.add(
                "title",
                format!("{blank:?}, a blank title"),
                "a title with a letter or a digit",
                remedy,
            );
        }
    }

    /// Reports a list without entries.
    pub fn empty(&mut self, field: impl Into<String>, allowed: impl Into<String>, remedy: impl Into<String>) {
        self.add(field, EMPTY_LIST, allowed, remedy);
    }

    /// Reports a whole number outside its allowed range.
    pub fn whole(&mut self, field: &str, value: usize, allowed: Whole, remedy: &str) {
        if !allowed.holds(value) {
            self.add(field, value, allowed.to_string(), remedy);
        }
    }
}
