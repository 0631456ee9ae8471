//! Why an output was not written.

use std::path::PathBuf;

/// Why a file of results was not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
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
}

impl OutputError {
    pub(crate) fn making(what: &str) -> impl Fn(String) -> Self + '_ {
        move |reason| Self::Make { what: what.into(), reason }
    }
}
