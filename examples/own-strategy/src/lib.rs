//! A strategy in a crate of its own: generalised conjugate residuals (Eisenstat, Elman & Schultz,
//! SIAM J. Numer. Anal. 20, 345, 1983). It implements [`Solver`], keeps its account in the [`Ledger`]
//! and joins a [`Registry`]; its tests run it in a comparison, against the referee and under two
//! claims.

use inkwave::solve::flat;
use inkwave::solve::vectors::{dot, norm};
use inkwave::solve::{Ledger, Registry, Solution, SolveError, Solver};
use inkwave::wave::Field;

/// Minimises the residual over all stored directions, with one operator application per step.
#[derive(Clone, Copy, Debug)]
pub struct ConjugateResiduals {
    /// Directions kept before a restart; each costs two vectors.
    pub directions: usize,
}

impl Default for ConjugateResiduals {
    fn default() -> Self {
        Self { directions: 60 }
    }
}

/// The built-in strategies and this one.
pub fn registry() -> Result<Registry, SolveError> {
    let make = || Box::new(ConjugateResiduals::default()) as Box<dyn Solver>;
    Registry::default().with("conjugate_residuals", "Generalised conjugate residuals of another crate.", make)
}

impl Solver for ConjugateResiduals {
    fn name(&self) -> &'static str {
        "conjugate_residuals"
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        ledger.holds_vectors(4 + 2 * self.directions);
        let mut field = start.cloned().unwrap_or_else(|| ledger.background.clone());
        let mut residual = Field::zeros(field.raw_dim());
        loop {
            // The true residual, r = u₀ − M u with M = 1 + A⁻¹V: rounding does not add up from
            // cycle to cycle.
            let size = ledger.measure(&field, &mut residual);
            ledger.note(size)?;
            if ledger.reached() {
                return Ok(ledger.finish(field));
            }
            ledger.judge("allow more applications, or more directions")?;
            self.cycle(&mut ledger, &mut field, &mut residual)?;
        }
    }
}

impl ConjugateResiduals {
    /// Steps until the residual of the recurrence meets the goal, or all directions are in use.
    fn cycle(&self, ledger: &mut Ledger, field: &mut Field, residual: &mut Field) -> Result<(), SolveError> {
        let mut kept: Vec<(Field, Field)> = Vec::with_capacity(self.directions);
        while kept.len() < self.directions && !ledger.reached() && !ledger.exhausted() {
            let (p, q) = direction(ledger, residual, &kept);
            let square = norm(flat(&q)).powi(2);
            if square == 0.0 {
                break;
            }
            let alpha = dot(flat(&q), flat(residual)) / square; // α = ⟨q, r⟩ / ⟨q, q⟩
            field.scaled_add(alpha, &p); // u ← u + α p
            residual.scaled_add(-alpha, &q); // r ← r − α q
            kept.push((p, q));
            ledger.account.steps += 1;
            ledger.note(norm(flat(residual)) / ledger.scale())?;
        }
        Ok(())
    }
}

/// The residual as a direction p with its image q = M p, made orthogonal to all images so far.
fn direction(ledger: &mut Ledger, residual: &Field, kept: &[(Field, Field)]) -> (Field, Field) {
    let (mut p, mut q) = (residual.clone(), Field::zeros(residual.raw_dim()));
    ledger.problem.scatter(p.view(), &mut q); // q = A⁻¹V p
    ledger.account.operator_applications += 1;
    q += &p;
    for (p0, q0) in kept {
        let beta = dot(flat(q0), flat(&q)) / norm(flat(q0)).powi(2); // β = ⟨q₀, q⟩ / ⟨q₀, q₀⟩
        p.scaled_add(-beta, p0);
        q.scaled_add(-beta, q0);
    }
    (p, q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use inkwave::solve::Silent;
    use inkwave_bench::experiment::ComparisonFile;
    use inkwave_validation::claim::{Findings, Level};
    use inkwave_validation::{claims, referee};
    use std::path::Path;

    #[test]
    fn the_referee_accepts_it() {
        let worst = referee::worst_distance(&ConjugateResiduals::default()).expect("converges everywhere");
        assert!(worst < referee::BOUND, "{worst:.1e}");
    }

    #[test]
    fn it_stands_under_the_claims_on_strategies() {
        let registry = registry().expect("a new name");
        let added = registry.entries().last().expect("the strategy of this crate");
        assert_eq!(added.name, "conjugate_residuals");
        for measure in [claims::energy::measure, claims::agreement::measure] {
            let mut findings = Findings::default();
            measure(std::slice::from_ref(added), Level::Quick, &mut findings);
            assert!(!findings.checks.is_empty() && findings.hold(), "{:?}", findings.checks);
        }
    }

    /// It has a row in `compare`, with the error of the other strategies on the same discrete
    /// system.
    #[test]
    fn it_is_a_row_of_a_comparison() {
        let examples =
            Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("examples/own-strategy is a folder of it");
        let mut file = ComparisonFile::read(&examples.join("compare-dilute.toml")).expect("an example");
        file.strategies = Some(vec!["krylov".into(), "conjugate_residuals".into()]);
        file.resolutions.iter_mut().for_each(|grids| grids.truncate(1));
        file.absorbing_mean = Some(true);
        file.repeats = Some(1);
        let registry = registry().expect("a new name");
        let comparison = file.run(&registry, &mut Silent, |_| ()).expect("compared");
        for pair in comparison.rows.chunks(2) {
            let [krylov, own] = [&pair[0], &pair[1]].map(|r| r.result.clone().expect("both converge"));
            assert!(
                (krylov - own).abs() < 1e-4,
                "{krylov:.3e} and {own:.3e}: the residual asked for, amplified"
            );
        }
    }
}
