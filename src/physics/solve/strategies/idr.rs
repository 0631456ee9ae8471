//! IDR(s), the method of induced dimension reduction (Sonneveld and van Gijzen 2008), in the
//! variant with biorthogonal vectors (van Gijzen and Sonneveld 2011): short recurrences, 2 s
//! vectors for any number of steps. Implemented here because no maintained crate offers it for
//! complex matrix-free operators.

mod recurrence;

use crate::solve::vectors::norm;
use crate::solve::{Demand, Ledger, Size, Solution, SolveError, Solver, flat};
use crate::wave::Field;
use crate::wave::system::Double;
use recurrence::Recurrence;

const ADVICE: &str = "raise idr.shadow_space or solver.max_applications, or use strategy = \"krylov\"";
/// Vectors besides directions and images: field, residual, incident wave; phases, residual and
/// correction of the recurrence, and two of work.
const OTHER_VECTORS: usize = 8;

/// IDR(s): s + 1 operator applications per cycle of s + 1 steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Idr {
    /// Dimension s of the shadow space: more of it needs fewer applications and more memory.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 64)))]
    pub shadow_space: usize,
    /// Number of restarts from the true residual when the recurrence breaks down or has drifted.
    pub most_restarts: usize,
}

impl Default for Idr {
    fn default() -> Idr {
        Idr { shadow_space: 12, most_restarts: 20 }
    }
}

impl Solver for Idr {
    fn name(&self) -> &'static str {
        "idr"
    }

    fn check(&self) -> Result<(), SolveError> {
        SolveError::unless_within("idr.shadow_space", self.shadow_space, 1..=64, "12 is usual")
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        ledger.holds_vectors(2 * self.shadow_space + OTHER_VECTORS);
        let [mut u, mut r] = ledger.from_zero(start)?;
        self.advance(&mut ledger, [&mut u, &mut r], ADVICE)?;
        Ok(ledger.finish(u))
    }

    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        Demand::fixed(size.fields((2 * self.shadow_space + OTHER_VECTORS) as f64))
    }
}

impl Idr {
    /// Continues from the field `u` with residual `r` to the goal; `advice` is for solves that do
    /// not reach it.
    pub(super) fn advance(
        &self,
        ledger: &mut Ledger,
        [u, r]: [&mut Field; 2],
        advice: &str,
    ) -> Result<(), SolveError> {
        for _ in 0..=self.most_restarts {
            if ledger.reached() {
                return Ok(());
            }
            let size = norm(flat(r));
            let mut recurrence = Recurrence::new(self.shadow_space, r, size);
            recurrence.run(&Double(ledger.problem), ledger)?;
            u.iter_mut().zip(recurrence.correction()).for_each(|(u, e)| *u += size * e);
            ledger.measure(u, r);
            if !ledger.reached() {
                ledger.judge(advice)?;
            }
        }
        Err(ledger.not_converged(advice))
    }
}
