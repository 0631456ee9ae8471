//! Errors of exports.

use crate::evaluate::ink::InkError;
use crate::ink::PackError;
use crate::solve::SolveError;
use crate::wave::WaveError;
use std::path::PathBuf;

/// Why something could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The folder has no results that can be used.
    #[error("{reason}")]
    Folder {
        /// What is wrong with it.
        reason: String,
        /// What to try.
        remedy: &'static str,
    },
    /// Solves are missing.
    #[error("{} is unfinished: {finished} of {asked} solves are stored", path.display())]
    Unfinished {
        /// The folder.
        path: PathBuf,
        /// Finished solves.
        finished: usize,
        /// Solves of the study.
        asked: usize,
    },
    /// The study has no such file: what was asked for, and what is allowed.
    #[error("{0}")]
    Refused(String),
    /// Records that do not belong together.
    #[error(transparent)]
    Seen(#[from] crate::appearance::bdf::BdfError),
    /// The appearance cannot be computed.
    #[error(transparent)]
    Ink(#[from] InkError),
    /// A table cannot be written.
    #[error("cannot write a table: {0}")]
    Csv(#[from] csv::Error),
    /// JSON cannot be written.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A file made from a template.
    #[error("cannot write the file: {0}")]
    Template(#[from] minijinja::Error),
    /// The archive of arrays cannot be written.
    #[error("cannot write the archive of arrays: {0}")]
    Npz(#[from] ndarray_npy::WriteNpzError),
    /// The packing could not be reproduced.
    #[error(transparent)]
    Packing(#[from] PackError),
    /// The near field's problem is not valid.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The near field's solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl ExportError {
    /// What to try, unless the message includes it.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::Folder { remedy, .. } => Some(remedy),
            Self::Seen(_) => Some("run the study again in a new folder"),
            _ => None,
        }
    }

    /// No layer of this thickness.
    pub(super) fn thickness(found: f64, allowed: &str) -> Self {
        Self::Refused(format!("--thickness: found {found} µm; allowed is {allowed} µm"))
    }

    /// A format that needs the ink on its paper, and why there is none.
    pub(super) fn no_ink(format: &str, reason: &str) -> Self {
        Self::Refused(format!("{format} needs the ink on its paper: {reason}"))
    }
}
