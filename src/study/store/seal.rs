//! The seal of a record, which shows that it is intact, of the current method and stored under its
//! own key; and the damage that a store may have.

use super::identity::{METHOD_VERSION, build};
use std::path::PathBuf;

/// Length of a seal: 128 bits of BLAKE3.
const SEAL_BYTES: usize = 16;
/// Number of damaged records that are listed one by one; the rest are only counted.
const NAMED: usize = 5;

/// A record as stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sealed {
    /// Kind, such as `point`.
    pub kind: String,
    /// Content hash of what the record depends on.
    pub key: String,
    /// [`METHOD_VERSION`] of the program that computed it.
    pub method: u32,
    /// The program that computed it: name, version, commit.
    pub program: String,
    /// Checksum of the record's kind, key, method, program and content.
    pub seal: Vec<u8>,
    /// The record itself (MessagePack).
    pub content: Vec<u8>,
}

impl Sealed {
    /// Seals `content` as the record `key` of `kind`.
    pub fn new(kind: &str, key: &str, content: Vec<u8>) -> Self {
        let mut record = Self {
            kind: kind.to_owned(),
            key: key.to_owned(),
            method: METHOD_VERSION,
            program: build().to_owned(),
            seal: Vec::new(),
            content,
        };
        record.seal = record.expected_seal().to_vec();
        record
    }

    /// Checks that the record is unchanged.
    ///
    /// # Errors
    /// The seal does not match (a changed byte, another record under this key), or the method
    /// differs.
    pub fn check(&self) -> Result<(), RecordFault> {
        if self.seal != self.expected_seal() {
            Err(RecordFault::Seal)
        } else if self.method != METHOD_VERSION {
            Err(RecordFault::Method(self.method))
        } else {
            Ok(())
        }
    }

    fn expected_seal(&self) -> [u8; SEAL_BYTES] {
        let Self { kind, key, method, program, content, .. } = self;
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("inkwave record/{kind}/{key}/{method}/{program}/").as_bytes()).update(content);
        let mut seal = [0; SEAL_BYTES];
        hasher.finalize_xof().fill(&mut seal);
        seal
    }
}

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
    if damages.is_empty() {
        return None;
    }
    let records = damages.iter().filter(|d| matches!(d, Damage::Record { .. })).count();
    let files = damages.len() - records;
    let what = [counted(records, "record"), counted(files, "file")];
    let what = what.into_iter().flatten().collect::<Vec<_>>().join(" and ");
    let mut text = format!("{what} of the store damaged or outdated; they count as absent:");
    text.extend(damages.iter().take(NAMED).map(|damage| format!("\n  {damage}")));
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
    fn the_seal_breaks_with_name_kind_method_program_and_every_bit() {
        let whole = Sealed::new("point", "a", vec![1, 2, 3]);
        assert_eq!(whole.check(), Ok(()));
        for forged in [
            Sealed { key: "b".into(), ..whole.clone() },
            Sealed { kind: "grid".into(), ..whole.clone() },
            Sealed { method: METHOD_VERSION + 1, ..whole.clone() },
            Sealed { program: "another".into(), ..whole.clone() },
        ] {
            assert_eq!(forged.check(), Err(RecordFault::Seal));
        }
        for bit in 0..24 {
            let mut damaged = whole.clone();
            damaged.content[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(damaged.check(), Err(RecordFault::Seal));
        }
    }

    #[test]
    fn a_record_of_another_method_is_recognised() {
        let other = METHOD_VERSION + 1;
        let mut record = Sealed { method: other, ..Sealed::new("point", "a", vec![1]) };
        record.seal = record.expected_seal().to_vec();
        assert_eq!(record.check(), Err(RecordFault::Method(other)));
    }

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
