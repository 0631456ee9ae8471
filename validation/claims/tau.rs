//! The relaxation's result does not depend on its parameter.

use crate::cells::{Cell, REAL, solve};
use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::figure::{Curve, LogPlot, Style};
use inkwave::solve::{Gmres, Relaxation};
use inkwave::wave::{Field, Side};

pub const CLAIM: Claim = Claim {
    id: "05-tau-independence",
    statement: "Relaxation ends in the same field for every step τ over two decades.",
    because: "The fixed point of the split step is the solution of (A + V) u = b whatever τ is (P2 section 3, corrected (3.13)).",
    file: file!(),
    measure,
};

const TOLERANCE: f64 = 1e-10;

/// Largest difference of two fields over the largest value.
pub fn distance(a: &Field, b: &Field) -> f64 {
    let largest = |f: &Field| f.iter().map(|z| z.norm()).fold(0.0, f64::max);
    largest(&(a - b)) / largest(b)
}

fn measure(level: Level, findings: &mut Findings) {
    let taus: &[f64] = level.pick(&[0.6, 6.0, 60.0], &[0.6, 1.2, 3.0, 6.0, 12.0, 30.0, 60.0]);
    for kappa in [0.0, 0.1] {
        let cell = Cell { mean: REAL, ..Cell::new(kappa, level.pick([8, 7], [12, 11]), 5) };
        let problem = cell.problem((25.0, 40.0, Side::Above));
        let truth = solve(&Gmres::default(), &problem, 0.1 * TOLERANCE).expect("krylov").field;
        let mut histories = Vec::new();
        let mut largest = 0.0f64;
        for &tau in taus {
            let relaxation = Relaxation { tau, ..Relaxation::default() };
            let solution = solve(&relaxation, &problem, TOLERANCE)
                .unwrap_or_else(|e| panic!("τ = {tau}, κ = {kappa}: {e}"));
            largest = largest.max(distance(&solution.field, &truth));
            let residuals = solution.account.history.iter().enumerate().map(|(i, &r)| (i as f64, r));
            histories.push(Curve::new(format!("τ = {tau}"), Style::Data, residuals.skip(1)));
        }
        let what = format!("spread over τ = {} … {}, κ = {kappa}", taus[0], taus[taus.len() - 1]);
        findings.identity(
            what,
            largest,
            100.0 * TOLERANCE,
            "the residual, amplified by at most 100 on so small a cell",
        );
        findings.plots.push(LogPlot::log_log(
            &format!("Relaxation, κ = {kappa}"),
            "look at the residual",
            "relative residual",
            histories,
        ));
    }
    let decades = (taus[taus.len() - 1] / taus[0]).log10();
    findings.check(
        "decades of τ",
        decades,
        Bound::AtLeast(1.99),
        Reason::Promise,
        "two decades were asked for",
    );
}
