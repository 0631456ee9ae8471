//! Errors of comparisons.

use crate::draw::OutputError;
use crate::input::case::CaseError;
use crate::input::fault::{Fault, Faults, StudyError};
use crate::solve::SolveError;
use crate::solve::accuracy::AccuracyError;
use crate::store::folder::FolderError;
use crate::wave::WaveError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// An error that prevents the comparison; a strategy that fails is a row with the reason instead.
#[derive(Debug, Error)]
pub enum CompareError {
    /// The file is not a comparison.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// Another error, with the file that it is about.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The comparison, study or case.
        path: PathBuf,
        /// What is wrong.
        error: Box<CompareError>,
    },
    /// Fields that do not fit together.
    #[error("{0}")]
    Fields(Faults),
    /// The case file is not valid.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The layer cannot be packed.
    #[error(transparent)]
    Pack(#[from] crate::ink::PackError),
    /// The geometry does not give a wave problem.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// A strategy is not known, or the user stopped a solve.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The reference solution was not reached.
    #[error(transparent)]
    Accuracy(#[from] AccuracyError),
}

/// What a comparison gives.
pub type CompareResult<T = ()> = Result<T, CompareError>;

impl CompareError {
    /// Whether the user stopped the comparison.
    pub fn is_stop(&self) -> bool {
        match self {
            Self::Solve(error) => matches!(error, SolveError::Cancelled { .. }),
            Self::Accuracy(error) => error.is_stop(),
            Self::InFile { error, .. } => error.is_stop(),
            _ => false,
        }
    }

    /// Adds the name of the file, unless the message contains it.
    pub(super) fn in_file(self, path: &Path) -> CompareError {
        match self {
            named @ (Self::Study(_) | Self::InFile { .. }) => named,
            named @ Self::Case(CaseError::Read { .. } | CaseError::Refused { .. }) => named,
            error => Self::InFile { path: path.to_owned(), error: Box::new(error) },
        }
    }
}

impl From<Fault> for CompareError {
    fn from(fault: Fault) -> Self {
        Self::Fields(Faults(vec![fault]))
    }
}

/// Entries finished before the user stopped; an error only if there are none.
///
/// # Errors
/// Other errors, and a stop before the first entry.
pub(super) fn kept<T>(entries: Vec<T>, end: CompareResult) -> CompareResult<Vec<T>> {
    match end {
        Err(error) if !error.is_stop() || entries.is_empty() => Err(error),
        _ => Ok(entries),
    }
}

/// Why the outputs of a comparison could not be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A plot.
    #[error(transparent)]
    Figure(#[from] OutputError),
    /// A table.
    #[error("cannot write a table: {0}")]
    Table(#[from] csv::Error),
    /// The description of the machine.
    #[error("cannot write the results as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// A page.
    #[error("cannot write the report: {0}")]
    Page(#[from] minijinja::Error),
}
