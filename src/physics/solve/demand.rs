//! Memory demand of a solve, known before anything is built.
//!
//! Numbers of bytes are floating-point numbers, which cannot overflow for any grid. Every term is
//! an upper bound; `tests/suite/memory.rs` compares the sum with the memory measured.

use super::solver::Size;
use super::solver::{Demand, Solver};
use crate::wave::Resolution;
use thiserror::Error;

/// A solve exceeds the memory allowed.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "{} × {} points and {} cells would need {} of the {} allowed; take fewer points or \
     cells, a smaller layer, or more memory (--memory-gb of commands that have it)",
    .resolution.nx, .resolution.ny, .resolution.cells, memory_in_words(*need_gb), memory_in_words(*allowed_gb)
)]
pub struct TooLarge {
    /// The rejected grid.
    pub resolution: Resolution,
    /// Memory needed, GB.
    pub need_gb: f64,
    /// Memory allowed, GB.
    pub allowed_gb: f64,
}

/// An amount of memory in a suitable unit: 12.31 GB, 0.4 MB, 30 bytes.
pub fn memory_in_words(gb: f64) -> String {
    match gb {
        gb if gb >= 0.095 => format!("{gb:.2} GB"),
        gb if gb >= 9.5e-5 => format!("{:.1} MB", 1e3 * gb),
        gb => format!("{:.0} bytes", 1e9 * gb),
    }
}

impl Size {
    /// Largest memory of a solve with a strategy, bytes.
    pub fn bytes(&self, solver: &dyn Solver) -> f64 {
        self.with(self.demand(solver, f64::INFINITY).bytes)
    }

    fn demand(&self, solver: &dyn Solver, bytes: f64) -> Demand {
        if self.channels == 0 { Demand::fixed(self.fields(4.0)) } else { solver.demand(self, bytes) }
    }

    /// Memory of a solve whose strategy needs `strategy` bytes.
    fn with(&self, strategy: f64) -> f64 {
        self.problem() + self.making().max(strategy)
    }

    /// The strategy if `memory` bytes suffice, unchanged or with less memory of its own, and with
    /// permission to grow into the rest.
    ///
    /// # Errors
    /// [`TooLarge`] if no variant fits.
    pub fn admit<'a>(&self, requested: &'a dyn Solver, memory: f64) -> Result<Admitted<'a>, TooLarge> {
        let Demand { bytes, solver } = self.demand(requested, memory - self.problem());
        let bytes = self.with(bytes);
        if bytes <= memory {
            return Ok(Admitted { bytes, requested, fitted: solver });
        }
        Err(TooLarge { resolution: self.resolution, need_gb: 1e-9 * bytes, allowed_gb: 1e-9 * memory })
    }
}

/// A strategy that fits into the memory.
pub struct Admitted<'a> {
    /// Memory of a solve in bytes, unless it stalls and the strategy grows.
    pub bytes: f64,
    requested: &'a dyn Solver,
    /// The strategy with other memory settings, if they had to change.
    fitted: Option<Box<dyn Solver>>,
}

impl Admitted<'_> {
    /// The strategy.
    pub fn solver(&self) -> &dyn Solver {
        self.fitted.as_deref().unwrap_or(self.requested)
    }
}
