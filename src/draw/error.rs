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
    /// The content cannot be made.
    #[error("cannot make {what}: {reason}")]
    Make {
        /// What was to be made.
        what: String,
        /// Why.
        reason: String,
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
