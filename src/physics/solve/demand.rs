//! What a solve will take of the memory, said before anything is built.
//!
//! Numbers of bytes are kept as floating-point numbers: however wild the grid, they grow without overflow. Every term is an
//! upper bound; `tests/suite/memory.rs` holds the sum against what the system measured.

pub use super::size::Size;
use super::solver::Solver;
use crate::wave::Resolution;
use thiserror::Error;

/// The memory allowed does not hold a solve.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "{} × {} points and {} cells would need {} of the {} allowed; take fewer points or \
     cells, a smaller layer, or allow more memory with --memory-gb",
    .resolution.nx, .resolution.ny, .resolution.cells, memory_in_words(*need_gb), memory_in_words(*allowed_gb)
)]
pub struct TooLarge {
    /// The grid refused.
    pub resolution: Resolution,
    /// Needed.
    pub need_gb: f64,
    /// Allowed.
    pub allowed_gb: f64,
}

/// A part of the memory in the unit that shows it: 12.31 GB, 0.4 MB, 30 bytes.
pub fn memory_in_words(gb: f64) -> String {
    match gb {
        gb if gb >= 0.095 => format!("{gb:.2} GB"),
        gb if gb >= 9.5e-5 => format!("{:.1} MB", 1e3 * gb),
        gb => format!("{:.0} bytes", 1e9 * gb),
    }
}

impl Size {
    /// Bytes of a solve with a strategy at its largest.
    pub fn bytes(&self, solver: &dyn Solver) -> f64 {
        let strategy = if self.channels == 0 { self.fields(4.0) } else { solver.most_bytes(self) };
        self.problem() + self.making().max(strategy)
    }

    /// The strategy if `memory` bytes hold it, itself or with less memory of its own.
    ///
    /// # Errors
    /// [`TooLarge`]: nothing does.
    pub fn admit<'a>(&self, solver: &'a dyn Solver, memory: f64) -> Result<Admitted<'a>, TooLarge> {
        let need = self.bytes(solver);
        if need <= memory {
            return Ok(Admitted::Whole(solver));
        }
        let left = memory - self.problem();
        if self.making() <= left
            && let Some(smaller) = solver.within(self, left)
        {
            return Ok(Admitted::Fitted(smaller));
        }
        let [need_gb, allowed_gb] = [need, memory].map(|bytes| 1e-9 * bytes);
        Err(TooLarge { resolution: self.resolution, need_gb, allowed_gb })
    }
}

/// A strategy that fits the memory.
pub enum Admitted<'a> {
    /// As it was asked.
    Whole(&'a dyn Solver),
    /// With another memory of its own.
    Fitted(Box<dyn Solver>),
}

impl Admitted<'_> {
    /// With leave to grow to what `memory` bytes hold, where a solve needs it.
    pub fn with_room(self, size: &Size, memory: f64) -> Self {
        let roomy = self.solver().with_room(size, memory - size.problem());
        roomy.map_or(self, Admitted::Fitted)
    }

    /// The strategy.
    pub fn solver(&self) -> &dyn Solver {
        match self {
            Admitted::Whole(solver) => *solver,
            Admitted::Fitted(solver) => &**solver,
        }
    }
}
