//! BiCGSTAB (van der Vorst 1992): short recurrences, eight vectors for any number of steps.
//!
//! Implemented here because the maintained complex implementation in the linear-algebra crate can
//! neither be cancelled nor observed. Convergence is erratic without absorption, where GMRES is the
//! better choice.

use crate::solve::vectors::{dot, norm};
use crate::solve::{Demand, Ledger, Size, Solution, SolveError, Solver, flat};
use crate::wave::Field;
use num_complex::Complex64;

/// BiCGSTAB; two operator applications per step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Bicgstab {
    /// Number of restarts from the true residual when the recurrence breaks down or has drifted.
    pub most_restarts: usize,
}

impl Default for Bicgstab {
    fn default() -> Bicgstab {
        Bicgstab { most_restarts: 20 }
    }
}

impl Solver for Bicgstab {
    fn name(&self) -> &'static str {
        "bicgstab"
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        ledger.holds_vectors(8);
        let [mut u, mut r] = ledger.from_zero(start)?;
        for _ in 0..=self.most_restarts {
            if ledger.reached() {
                return Ok(ledger.finish(u));
            }
            recurrence(&mut ledger, &mut u, &mut r)?;
            let residual = ledger.measure(&u, &mut r);
            if !residual.is_finite() || residual > 1e4 {
                return Err(ledger.diverged(f64::INFINITY));
            }
            if !ledger.reached() {
                ledger.judge("use strategy = \"krylov\"")?;
            }
        }
        Err(ledger.not_converged("the recurrence keeps breaking down; use strategy = \"krylov\""))
    }

    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        Demand::fixed(size.fields(11.0))
    }
}

/// Iterates until the recursive residual meets the goal, breaks down, or the applications are used
/// up.
fn recurrence(ledger: &mut Ledger, u: &mut Field, r: &mut Field) -> Result<(), SolveError> {
    let shadow = r.clone();
    let mut p = r.clone();
    let mut v = Field::zeros(r.dim());
    let mut s = Field::zeros(r.dim());
    let mut t = Field::zeros(r.dim());
    let mut rho = dot(flat(&shadow), flat(r));
    while !ledger.exhausted() {
        apply(ledger, &p, &mut v); // v = M p
        let alpha = rho / dot(flat(&shadow), flat(&v)); // α = ⟨r̃, r⟩ / ⟨r̃, v⟩
        // s = r − α v
        ndarray::Zip::from(&mut s).and(&*r).and(&v).par_for_each(|s, &r, &v| *s = r - alpha * v);
        // Half a step may suffice, and does exactly so without contrast: ω would be 0/0.
        let half = norm(flat(&s)) / ledger.scale();
        if half <= 0.9 * ledger.goal.tolerance {
            ndarray::Zip::from(&mut *u).and(&p).par_for_each(|u, &p| *u += alpha * p);
            ledger.account.steps += 1;
            return ledger.note(half);
        }
        apply(ledger, &s, &mut t); // t = M s
        let omega = dot(flat(&t), flat(&s)) / norm(flat(&t)).powi(2); // ω = ⟨t, s⟩ / ⟨t, t⟩
        if !(alpha.is_finite() && omega.is_finite()) || omega.norm() < 1e-14 {
            return Ok(());
        }
        // u ← u + α p + ω s,  r ← s − ω t
        ndarray::Zip::from(&mut *u).and(&p).and(&s).par_for_each(|u, &p, &s| *u += alpha * p + omega * s);
        ndarray::Zip::from(&mut *r).and(&s).and(&t).par_for_each(|r, &s, &t| *r = s - omega * t);
        ledger.account.steps += 1;
        let residual = norm(flat(r)) / ledger.scale();
        ledger.note(residual)?;
        if residual <= 0.9 * ledger.goal.tolerance || residual > 1e4 {
            return Ok(());
        }
        let before = std::mem::replace(&mut rho, dot(flat(&shadow), flat(r)));
        let beta = rho / before * (alpha / omega); // β = ⟨r̃, r⟩ / ⟨r̃, r⟩_previous · α/ω
        // p ← r + β (p − ω v)
        let next = ndarray::Zip::from(&mut p).and(&*r).and(&v);
        next.par_for_each(|p, &r, &v| *p = r + beta * (*p - omega * v));
    }
    Ok(())
}

/// Applies the operator: out ← (1 + A⁻¹V) x.
fn apply(ledger: &mut Ledger, x: &Field, out: &mut Field) {
    ledger.problem.scatter(x.view(), out);
    ndarray::Zip::from(out).and(x).par_for_each(|o, &x: &Complex64| *o += x);
    ledger.account.operator_applications += 1;
}
