//! Energy balance of every strategy.

use crate::cells::{Cell, Direction, solve};
use crate::claim::{Claim, Findings, Level};
use inkwave::solve::{Entry, Registry};
use inkwave::wave::Side;

pub const CLAIM: Claim = Claim {
    id: "03-energy",
    statement: "R + T + A = 1 to the solver's residual, whatever the strategy, absorption, angle and resolution.",
    because: "The discrete operator's quadratic form is the flux balance (P2 section 2); this says nothing about accuracy.",
    file: file!(),
    measure: |level, findings| measure(Registry::default().entries(), level, findings),
};

const DIRECTIONS: [Direction; 4] = [
    (0.0, 0.0, Side::Incident),
    (35.0, 20.0, Side::Incident),
    (70.0, 0.0, Side::Exit),
    (55.0, 130.0, Side::Exit),
];
const TOLERANCE: f64 = 1e-9;

/// Measures the strategies.
pub fn measure(strategies: &[Entry], level: Level, findings: &mut Findings) {
    let directions = &DIRECTIONS[..level.pick(2, 4)];
    let points = level.pick([10, 9], [16, 15]);
    for kappa in [0.0, 0.1] {
        for entry in strategies {
            let name = entry.name.as_str();
            let solver = entry.build();
            // The largest dense matrix that stays below a minute.
            let points = if solver.most_unknowns().is_some() { [7, 6] } else { points };
            let cell = Cell { mean: solver.suited_mean(), ..Cell::new(kappa, points, 6) };
            let balance = |&from: &Direction| {
                let problem = cell.problem(from);
                let solution = solve(solver.as_ref(), &problem, TOLERANCE);
                let solution = solution.unwrap_or_else(|e| panic!("{name}, κ = {kappa}: {e}"));
                problem.far_field(&solution.field).energy_error().abs()
            };
            let error = directions.iter().map(balance).fold(0.0, f64::max);
            findings.identity(
                format!("{name}, κ = {kappa}"),
                error,
                10.0 * TOLERANCE,
                "ten times the residual asked for: fluxes are quadratic, and trapped waves amplify a little",
            );
        }
    }
}
