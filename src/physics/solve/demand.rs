//! What a solve will take of the memory, said before anything is built.
//!
//! Numbers of bytes are kept as floating-point numbers: however wild the grid, they grow without overflow. Every term is an
//! upper bound; `tests/suite/memory.rs` holds the sum against what the system measured.

pub use super::size::Size;
use super::solver::{Fit, Solver};
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
        self.with(self.fit(solver, f64::INFINITY).bytes)
    }

    fn fit(&self, solver: &dyn Solver, bytes: f64) -> Fit {
        if self.channels == 0 { Fit::fixed(self.fields(4.0)) } else { solver.fit(self, bytes) }
    }

    /// Bytes of a solve whose strategy takes that many.
    fn with(&self, strategy: f64) -> f64 {
        self.problem() + self.making().max(strategy)
    }

    /// The strategy if `memory` bytes hold it, itself or with less memory of its own, and with leave to grow into the rest.
    ///
    /// # Errors
    /// [`TooLarge`]: nothing does.
    pub fn admit<'a>(&self, asked: &'a dyn Solver, memory: f64) -> Result<Admitted<'a>, TooLarge> {
        let Fit { bytes, solver } = self.fit(asked, memory - self.problem());
        let bytes = self.with(bytes);
        if bytes <= memory {
            return Ok(Admitted { bytes, asked, fitted: solver });
        }
        let [need_gb, allowed_gb] = [bytes, memory].map(|bytes| 1e-9 * bytes);
        Err(TooLarge { resolution: self.resolution, need_gb, allowed_gb })
    }
}

/// A strategy that fits the memory.
pub struct Admitted<'a> {
    /// Bytes of a solve, unless it stalls and the strategy grows.
    pub bytes: f64,
    asked: &'a dyn Solver,
    /// With another memory of its own.
    fitted: Option<Box<dyn Solver>>,
}

impl Admitted<'_> {
    /// The strategy.
    pub fn solver(&self) -> &dyn Solver {
        self.fitted.as_deref().unwrap_or(self.asked)
    }
}
