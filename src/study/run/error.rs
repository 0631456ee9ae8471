//! Why a run ends early.

use crate::ink::PackError;
use crate::solve::accuracy::AccuracyError;
use crate::solve::demand::TooLarge;
use crate::store::folder::FolderError;
use crate::store::queue::QueueError;
use crate::wave::WaveError;
use std::io;

/// Why a run has no results.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A realisation could not be packed.
    #[error("realisation {}: {source}", realisation + 1)]
    Packing {
        /// Number of the realisation, from 0.
        realisation: usize,
        /// The reason.
        source: PackError,
    },
    /// No grid reaches the requested accuracy.
    #[error(transparent)]
    Resolution(#[from] AccuracyError),
    /// The solves do not fit into memory.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The scene cannot be discretised.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The output folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A record could not be stored.
    #[error("cannot store a result: {0}")]
    Store(#[from] io::Error),
    /// The queue of tasks failed.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// Threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The user asked to stop; finished solves are kept.
    #[error("stopped before the first solve")]
    Stopped,
}

impl RunError {
    /// Turns every error caused by a stop into [`RunError::Stopped`]: a stop is not a failure of
    /// packing or grid.
    pub fn stopped(self) -> Self {
        match self {
            Self::Packing { source: PackError::Stopped { .. }, .. } | Self::Wave(WaveError::Stopped) => {
                Self::Stopped
            }
            Self::Resolution(error) if error.is_stop() => Self::Stopped,
            other => other,
        }
    }

    /// True if the grains of one realisation found no room, which does not affect the others.
    pub fn has_no_room(&self) -> bool {
        let no_room =
            |source: &PackError| matches!(source, PackError::Blocked { .. } | PackError::NotReached { .. });
        matches!(self, Self::Packing { source, .. } if no_room(source))
    }
}
