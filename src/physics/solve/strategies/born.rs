//! The Born series about the mean medium: u ← u₀ − A⁻¹V u (P2 (2.5)–(2.7)).

use crate::solve::account::{Solution, SolveError};
use crate::solve::demand::Size;
use crate::solve::ledger::{Ledger, ratio_of_terms};
use crate::solve::solver::{Fit, Solver};
use crate::wave::Field;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The Born series: adds terms until they are small; fails early if they grow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Born {
    /// Steps over which the ratio of successive terms is averaged (geometric mean).
    pub window: usize,
}

impl Default for Born {
    fn default() -> Born {
        Born { window: 8 }
    }
}

impl Solver for Born {
    fn name(&self) -> &'static str {
        "born"
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        ledger.holds_vectors(3);
        let mut field = start.cloned().unwrap_or_else(|| ledger.background.clone());
        let mut term = Field::zeros(field.dim());
        loop {
            // The residual is the next term of the series, so one application serves both purposes.
            let residual = ledger.measure(&field, &mut term);
            ledger.note(residual)?;
            if ledger.reached() {
                return Ok(ledger.finish(field));
            }
            match ratio_of_terms(&ledger.account.history, self.window) {
                Some(ratio) if ratio >= 1.0 => return Err(ledger.diverged(ratio)),
                ratio => ledger.judge(&advice(ratio))?,
            }
            field += &term;
            ledger.account.steps += 1;
        }
    }

    fn fit(&self, size: &Size, _bytes: f64) -> Fit {
        Fit::fixed(size.fields(6.0))
    }
}

fn advice(ratio: Option<f64>) -> String {
    format!("terms shrink by {:.4} per step; use krylov or allow more applications", ratio.unwrap_or(1.0))
}
