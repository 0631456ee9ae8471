//! Describes damage found in a store.

use super::identity::METHOD_VERSION;
use std::fmt;
use std::path::PathBuf;

/// Number of damaged records that are listed one by one; the rest are only counted.
const NAMED: usize = 5;

/// Why a stored record is ignored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordFault {
    /// Content, kind or key do not match the seal.
    Seal,
    /// Intact, but computed with another version of the method.
    Method(u32),
    /// Intact, but in a format that this program does not read.
    Form(String),
}

impl fmt::Display for RecordFault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Seal => write!(f, "its checksum does not match its name and content"),
            Self::Method(found) => write!(f, "made by method {found}, this program's is {METHOD_VERSION}"),
            Self::Form(why) => write!(f, "not in a format that this program reads: {why}"),
        }
    }
}

/// Damage found in a store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Damage {
    /// One record.
    Record {
        /// Kind, such as `point`.
        kind: String,
        /// Its content hash.
        key: String,
        /// What is wrong with the record.
        fault: RecordFault,
    },
    /// A whole file, or some of its pages.
    File {
        /// The file.
        path: PathBuf,
        /// SQLite's error message.
        reason: String,
        /// Number of intact records copied to another file; `None` if the file was left as it is.
        saved: Option<usize>,
    },
}

impl Damage {
    /// Identifies the damaged record or file.
    pub fn subject(&self) -> String {
        match self {
            Self::Record { kind, key, .. } => format!("{kind} {key}"),
            Self::File { path, .. } => path.display().to_string(),
        }
    }

    /// The damaged file; `None` for a record.
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Record { .. } => None,
            Self::File { path, .. } => Some(path),
        }
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Record { fault, .. } => write!(f, "{}: {fault}", self.subject()),
            Self::File { reason, saved: None, .. } => write!(f, "{}: {reason}", self.subject()),
            Self::File { reason, saved: Some(saved), .. } => {
                write!(f, "{}: {reason}; {saved} intact records were saved", self.subject())
            }
        }
    }
}

/// Reports which records and files are damaged, and how many; `None` if there is no damage.
pub fn in_words(damages: &[Damage]) -> Option<String> {
    let records = damages.iter().filter(|d| matches!(d, Damage::Record { .. })).count();
    let files = damages.len() - records;
    let what = match (records, files) {
        (0, 0) => return None,
        (n, 0) => counted(n, "record"),
        (0, n) => counted(n, "file"),
        (n, m) => format!("{} and {}", counted(n, "record"), counted(m, "file")),
    };
    let mut text = format!("{what} of the store damaged or outdated; they count as absent:");
    for damage in damages.iter().take(NAMED) {
        text += &format!("\n  {damage}");
    }
    if damages.len() > NAMED {
        text += &format!("\n  and {} more", damages.len() - NAMED);
    }
    Some(text)
}

fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_is_counted_and_named() {
        let point = |key: &str| Damage::Record {
            kind: "point".into(),
            key: key.to_owned(),
            fault: RecordFault::Seal,
        };
        assert_eq!(in_words(&[]), None);
        let told = in_words(&["a", "b", "c", "d", "e", "f", "g"].map(point)).unwrap();
        assert!(told.starts_with("7 records") && told.contains("point a") && told.ends_with("and 2 more"));
    }
}
