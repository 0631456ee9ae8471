//! Errors of making and writing outputs.

use std::path::PathBuf;

/// Why a results file, or a picture in one, was not made.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file cannot be written.
    #[error("cannot write {}: {source}; check the folder and its permissions", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The message of the system.
        source: std::io::Error,
    },
    /// The file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The content cannot be made.
    #[error("cannot make {what}: {reason}")]
    Make {
        /// What was to be made.
        what: String,
        /// Why.
        reason: String,
    },
    /// A size outside its range.
    #[error("{field} = {value}: allowed 1 to {most}")]
    Size {
        /// Which size.
        field: &'static str,
        /// The value, pixels.
        value: usize,
        /// Most, pixels.
        most: usize,
    },
    /// The wrong number of items.
    #[error("{field}: {count} entries where {expected} are needed")]
    Count {
        /// Which items.
        field: &'static str,
        /// Items given.
        count: usize,
        /// Items expected; 1 stands for one at least.
        expected: usize,
    },
}

impl OutputError {
    /// Maps any failure while `what` is made.
    pub(crate) fn making<E: std::fmt::Display>(what: &str) -> impl Fn(E) -> Self + '_ {
        move |reason| Self::Make { what: what.into(), reason: reason.to_string() }
    }
}

/// A failure of the drawing library.
pub(super) fn failed(reason: impl std::fmt::Display) -> OutputError {
    OutputError::making("a drawing")(reason)
}
