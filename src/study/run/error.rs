//! Why a run ends early.

use crate::ink::PackError;
use crate::solve::accuracy::AccuracyError;
use crate::solve::demand::TooLarge;
use crate::store::folder::FolderError;
use crate::store::queue::QueueError;
use crate::wave::WaveError;
use std::io;

/// Why a run ended without collecting anything.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A packing was not delivered.
    #[error("realisation {}: {source}", realisation + 1)]
    Packing {
        /// Number of the realisation, from 0.
        realisation: usize,
        /// Why.
        source: PackError,
    },
    /// No grid reaches the accuracy.
    #[error(transparent)]
    Resolution(#[from] AccuracyError),
    /// The work would not fit into memory.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The scene does not make a problem.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The folder of results.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A record could not be kept.
    #[error("cannot keep a result: {0}")]
    Store(#[from] io::Error),
    /// The queue of work.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// Threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// Someone asked to stop; what is finished is kept.
    #[error("stopped before the first solve")]
    Stopped,
}

impl RunError {
    /// With all that a stop looks like as [`RunError::Stopped`]: it is no failure of packing or grid.
    pub fn stopped(self) -> Self {
        match self {
            Self::Packing { source: PackError::Stopped { .. }, .. } | Self::Wave(WaveError::Stopped) => {
                Self::Stopped
            }
            Self::Resolution(error) if error.is_stop() => Self::Stopped,
            other => other,
        }
    }

    /// True when the grains of one realisation found no room, which says nothing of the others.
    pub fn has_no_room(&self) -> bool {
        let no_room =
            |source: &PackError| matches!(source, PackError::Blocked { .. } | PackError::NotReached { .. });
        matches!(self, Self::Packing { source, .. } if no_room(source))
    }
}
