//! All strategies solve one discrete system.

use super::tau::{distance, history};
use crate::cells::{Cell, solve};
use crate::claim::{Claim, Findings, Level};
use inkwave::draw::chart::Chart;
use inkwave::solve::{Direct, Entry, Registry, Solver};
use inkwave::wave::{Resolution, Scheme, Side};

pub const CLAIM: Claim = Claim {
    id: "06-agreement",
    statement: "Every strategy gives the field of the dense solve, without contrast too.",
    because: "All of them solve the same (A + V) u = b, which has one solution.",
    file: file!(),
    measure: |level, findings| measure(Registry::default().entries(), level, findings),
};

const TOLERANCE: f64 = 1e-12;

/// Distance to the dense solve without any contrast, where a strategy may divide zero by zero.
fn clear(name: &str, solver: &dyn Solver, [nx, ny, cells]: [usize; 3]) -> f64 {
    let mut largest = 0.0_f64;
    for scheme in [Scheme::default(), Scheme::SecondDifference] {
        let resolution = Resolution { nx, ny, cells, scheme };
        let problem = Cell { kappa: 0.0, resolution, mean: solver.suited_mean() }.clear_problem((
            25.0,
            15.0,
            Side::Incident,
        ));
        let truth = solve(&Direct::default(), &problem, TOLERANCE).expect("dense").field;
        let solution =
            solve(solver, &problem, TOLERANCE).unwrap_or_else(|e| panic!("{name}, no contrast: {e}"));
        largest = largest.max(distance(&solution.field, &truth));
    }
    largest
}

/// Measures the strategies against the dense solve.
pub fn measure(strategies: &[Entry], level: Level, findings: &mut Findings) {
    let sizes: &[[usize; 3]] = level.pick(&[[7, 6, 5]], &[[7, 6, 5], [11, 5, 5], [6, 12, 6], [8, 8, 5]]);
    let mut histories = Vec::new();
    for entry in strategies {
        let name = entry.name.as_str();
        let solver = entry.build();
        if solver.most_unknowns().is_some() {
            continue;
        }
        let mut largest = clear(name, solver.as_ref(), sizes[0]);
        for &[nx, ny, cells] in sizes {
            for (kappa, side) in [(0.1, Side::Incident), (0.0, Side::Exit)] {
                for scheme in [Scheme::default(), Scheme::SecondDifference] {
                    let mean = solver.suited_mean();
                    let resolution = Resolution { nx, ny, cells, scheme };
                    let problem = Cell { kappa, resolution, mean }.problem((25.0, 15.0, side));
                    let truth = solve(&Direct::default(), &problem, TOLERANCE).expect("dense").field;
                    let solution = solve(solver.as_ref(), &problem, TOLERANCE)
                        .unwrap_or_else(|e| panic!("{name}, {resolution:?}, κ = {kappa}: {e}"));
                    largest = largest.max(distance(&solution.field, &truth));
                    if kappa > 0.0 && scheme == Scheme::default() && [nx, ny, cells] == sizes[0] {
                        histories.push(history(name, &solution.account));
                    }
                }
            }
        }
        findings.identity(name, largest, 1e-10, "residual 1e-12; small cells amplify it by less than 100");
    }
    findings.plots.push(Chart::log_log(
        "Residual histories on a small absorbing cell",
        "operator applications",
        "relative residual",
        histories,
    ));
}
