//! Describes damage found in a store.

use super::identity::METHOD_VERSION;
use std::path::PathBuf;

/// Number of damaged records that are listed one by one; the rest are only counted.
const NAMED: usize = 5;

/// Why a stored record is ignored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordFault {
    /// Content, kind or key do not match the seal.
    #[error("its checksum does not match its name and content")]
    Seal,
    /// Intact, but computed with another version of the method.
    #[error("made by method {0}, this program's is {METHOD_VERSION}")]
    Method(u32),
    /// Intact, but in a format that this program does not read.
    #[error("not in a format that this program reads: {0}")]
    Form(String),
}

/// Damage found in a store.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// One record.
    #[error("{kind} {key}: {fault}")]
    Record {
        /// Kind, such as `point`.
        kind: String,
        /// Its content hash.
        key: String,
        /// What is wrong with the record.
        fault: RecordFault,
    },
    /// A whole file, or some of its pages.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// SQLite's error message, and the number of intact records copied to another file.
        reason: String,
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
}

/// Reports which records and files are damaged, and how many; `None` if there is no damage.
pub fn in_words(damages: &[Damage]) -> Option<String> {
    let records = damages.iter().filter(|d| matches!(d, Damage::Record { .. })).count();
    let files = damages.len() - records;
    let what: Vec<String> =
        [counted(records, "record"), counted(files, "file")].into_iter().flatten().collect();
    if what.is_empty() {
        return None;
    }
    let what = what.join(" and ");
    let mut text = format!("{what} of the store damaged or outdated; they count as absent:");
    for damage in damages.iter().take(NAMED) {
        text += &format!("\n  {damage}");
    }
    if damages.len() > NAMED {
        text += &format!("\n  and {} more", damages.len() - NAMED);
    }
    Some(text)
}

fn counted(n: usize, what: &str) -> Option<String> {
    (n > 0).then(|| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") })
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
