//! Relaxation to the stationary state by Crank–Nicolson splitting (P2 section 3, with (3.13)'s sign
//! corrected).
//!
//! In plane values, with D the lumped mass and c = iτ/2, one step is
//! (D − cV) D⁻¹ (D − cÃ) û = (D + cV) D⁻¹ (D + cÃ) u − 2c b, whose fixed point is (Ã + V) u = b for
//! every τ. The state stored is s = D⁻¹(D − cÃ)u at the points; since (D + cÃ)u = 2Du − Ds, a step
//! costs one inverse and one forward transform. Without absorption trapped waves circulate
//! undamped; replacing the state by its mean over a window ("averaging restart") removes them.

mod march;

pub(crate) use march::contrasts;

use crate::solve::vectors::norm;
use crate::solve::{Demand, Ledger, Size, Solution, SolveError, Solver, flat};
use crate::wave::{Field, Mean, Problem};
use march::{March, Memory};

/// Settings of the relaxation; the defaults converge on every reference case with a real mean.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Relaxation {
    /// Product of τ and the largest |V|.
    pub tau: f64,
    /// Number of steps between evaluations of the residual, and window over which the state is
    /// averaged.
    pub window: usize,
    /// Number of earlier restarts used in the averaging; 1 averages over one window only.
    pub memory: usize,
}

/// Longest window, and most earlier restarts.
const MOST_WINDOW: usize = 10_000;
/// Smallest τ reached by halving, as a fraction of the setting.
const SHORTEST: f64 = 0.2;
/// If a window multiplies the residual by more than this, τ is too long.
const GROWTH: f64 = 10.0;

impl Default for Relaxation {
    fn default() -> Relaxation {
        Relaxation { tau: 6.0, window: 12, memory: 24 }
    }
}

impl Solver for Relaxation {
    fn name(&self) -> &'static str {
        "relaxation"
    }

    fn check(&self) -> Result<(), SolveError> {
        if !(self.tau.is_finite() && self.tau > 0.0) {
            return Err(SolveError::setting("relaxation.tau", self.tau, "finite and above 0", "try 6"));
        }
        SolveError::unless_within("relaxation.window", self.window, 1..=MOST_WINDOW, "12 is usual")?;
        SolveError::unless_within("relaxation.memory", self.memory, 1..=MOST_WINDOW, "24 is usual")
    }

    fn suited_mean(&self) -> Mean {
        Mean { absorbing: false, ..Mean::default() }
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        let problem = ledger.split()?;
        Self::needs_real_mean(problem)?;
        let mut scratch = Field::zeros(problem.shape());
        let field = ledger.first_field(start, &mut scratch)?;
        if ledger.reached() {
            return Ok(ledger.finish(field));
        }
        let mut tau = self.tau;
        let mut march = March::new(problem, tau, &field);
        let mut memory = Memory::new(march.candidate(&mut ledger), self.memory);
        ledger.account.bytes = march.bytes() + memory.most_bytes();
        loop {
            let before = ledger.account.residual;
            let mean = march.window(self.window, &mut ledger);
            memory.recent.push_back(march.candidate_of(mean, &mut ledger));
            memory.recent.push_back(march.candidate(&mut ledger));
            // A NaN residual counts as grown.
            let after = ledger.account.residual;
            if (after.is_nan() || after > GROWTH * before) && 0.5 * tau >= self.tau * SHORTEST {
                // Ringing of the band-limited contrast causes gain at some points: shorter steps
                // reduce the splitting error.
                tau *= 0.5;
                march = March::new(problem, tau, &memory.base.field);
                memory = Memory::new(march.candidate(&mut ledger), self.memory);
            } else {
                memory.average();
            }
            march.state.assign(&memory.base.state);
            ledger.note(norm(flat(&memory.base.residual)) / ledger.scale())?;
            if ledger.reached() {
                if ledger.measure(&memory.base.field, &mut scratch) <= ledger.goal.tolerance {
                    return Ok(ledger.finish(memory.base.field));
                }
                // Rounding has separated the blend's residual from the field's: restart from the
                // field.
                march = March::new(problem, tau, &memory.base.field);
                memory = Memory::new(march.candidate(&mut ledger), self.memory);
            }
            ledger.judge("try another tau or window, or strategy = \"krylov\"")?;
        }
    }

    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        // Stored candidates hold four fields with their differences; two more are under
        // construction.
        let candidates = 5.0 * (self.memory.max(1) as f64 + 3.0);
        Demand::fixed(size.fields(candidates + 9.0 + 2.0 * (size.resolution.scheme.degree() as f64 + 1.0)))
    }
}

impl Relaxation {
    fn needs_real_mean(problem: &Problem) -> Result<(), SolveError> {
        if problem.mean.mean_absorption() > 0.0 {
            let remedy = "both halves of the splitting must be dissipative: choose the real mean (solve \
                --real-mean), in a study another strategy, such as \"krylov\"";
            return Err(SolveError::setting("mean", "complex", "a real ⟨k²⟩", remedy));
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "relaxation_tests.rs"]
mod tests;
