//! Errors of the search for a grid.

use crate::solve::account::SolveError;
use crate::solve::demand::{TooLarge, memory_in_words};
use crate::wave::MOST_POINTS;
use crate::wave::{Resolution, Unphysical, WaveError};
use thiserror::Error;

/// Results of solves with an error estimate.
pub type Result<T, E = AccuracyError> = std::result::Result<T, E>;

/// Why no result of the requested accuracy exists.
#[derive(Debug, Error)]
pub enum AccuracyError {
    /// The scene does not give a problem on a grid.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// A solve failed or was stopped.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The result violates a physical law.
    #[error(transparent)]
    Unphysical(#[from] Unphysical),
    /// A solve would not fit into memory.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The next finer grid does not fit into memory.
    #[error(
        "accuracy {asked:.1e} is not reached: the estimate is {reached:.1e} on {} × {} points and {} cells, \
         and the next finer grid would need {} of the {} allowed; ask for less accuracy, \
         a smaller cell, or more memory (tried: {tried})",
        .last.nx, .last.ny, .last.cells, memory_in_words(.next.need_gb), memory_in_words(.next.allowed_gb)
    )]
    NotReached {
        /// Requested amplitude error.
        asked: f64,
        /// Estimate on the finest grid solved.
        reached: f64,
        /// The finest grid solved.
        last: Resolution,
        /// Why the next grid is rejected.
        next: TooLarge,
        /// Every grid tried, with its estimate and time.
        tried: String,
    },
    /// Not even the coarsest sensible grid fits into memory.
    #[error(
        "accuracy {asked:.1e} is not reached: the coarsest grid to start from, {} × {} points and {} cells, would need {} \
         of the {} allowed; ask for less accuracy, a smaller cell, or more memory",
        .first.resolution.nx, .first.resolution.ny, .first.resolution.cells,
        memory_in_words(.first.need_gb), memory_in_words(.first.allowed_gb)
    )]
    TooLarge {
        /// Requested amplitude error.
        asked: f64,
        /// Why the coarsest grid is rejected.
        first: TooLarge,
    },
    /// The error does not decrease as the grid is refined.
    #[error(
        "accuracy {asked:.1e} is not reached: the estimate is {reached:.1e} after {levels} successively finer grids; ask for \
         less accuracy"
    )]
    GivenUp {
        /// Grids tried.
        levels: usize,
        /// Requested amplitude error.
        asked: f64,
        /// Estimate on the finest grid solved.
        reached: f64,
    },
    /// The layer is more wavelengths thick or wide than any grid can resolve.
    #[error(
        "accuracy {asked:.1e} is not reached: even the coarsest grid would need {need:.1e} points along an axis of at \
         most {MOST_POINTS}; check that the wavelength and all lengths are in µm"
    )]
    TooManyWaves {
        /// Requested amplitude error.
        asked: f64,
        /// Points or cells along the longest axis.
        need: f64,
    },
    /// An invalid accuracy.
    #[error("accuracy is {0}; allowed is 1e-9 … 0.5: choose how large an amplitude error you accept")]
    Accuracy(f64),
}

impl AccuracyError {
    /// Whether the user stopped the search, which is not a failure.
    pub fn is_stop(&self) -> bool {
        let of_solve = matches!(self, AccuracyError::Solve(SolveError::Cancelled { .. }));
        of_solve || matches!(self, AccuracyError::Wave(WaveError::Stopped))
    }
}
