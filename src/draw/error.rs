//! Why an output was not written.

use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    #[error("cannot write {}: {source}", path.display())]
    Write { path: PathBuf, source: std::io::Error },
    #[error("cannot read {}: {reason}", path.display())]
    Read { path: PathBuf, reason: String },
    #[error("cannot make {what}: {reason}")]
    Make { what: String, reason: String },
}

impl OutputError {
    pub(crate) fn making(what: &str) -> impl Fn(String) -> Self + '_ {
        move |reason| Self::Make { what: what.into(), reason }
    }
}
