//! The agreement suite: a strategy against the dense solve of the same discrete system, on tiny problems.

use crate::tiny::{REAL, SCHEMES, SETTINGS, Setting, distance, garbage, problem};
use inkwave::solve::{Direct, Goal, Silent, SolveError, Solver};
use inkwave::wave::{Mean, Scheme};

/// Residual asked for.
pub const GOAL: Goal = Goal { tolerance: 1e-12, max_applications: 20_000 };

/// Largest distance allowed: tiny grids amplify a residual of 1e-12 by less than 100 (their smallest singular value is
/// above 0.01).
pub const BOUND: f64 = 1e-10;

/// Largest distance of the strategy's field from the dense one over all settings, schemes and means that suit it, started
/// from garbage; and the first failure, if any, with the problem it belongs to.
pub fn worst_distance(solver: &dyn Solver) -> Result<f64, String> {
    let mut worst = 0.0f64;
    for setting in SETTINGS {
        for scheme in SCHEMES {
            for mean in means(solver) {
                let found = distance_on(solver, setting, scheme, mean);
                let named = |e| format!("{} on {setting:?} {scheme:?} {mean:?}: {e}", solver.name());
                worst = worst.max(found.map_err(named)?);
            }
        }
    }
    Ok(worst)
}

/// A real mean suits every strategy; a complex one those that say so.
fn means(solver: &dyn Solver) -> impl Iterator<Item = Mean> {
    let complex = solver.suited_mean().absorbing.then(Mean::default);
    [REAL].into_iter().chain(complex)
}

fn distance_on(solver: &dyn Solver, setting: Setting, scheme: Scheme, mean: Mean) -> Result<f64, SolveError> {
    let problem = problem(setting, scheme, mean);
    let truth = Direct::default().solve(&problem, GOAL, &mut Silent)?.field;
    let field = solver.solve_from(&problem, Some(&garbage(&problem)), GOAL, &mut Silent)?.field;
    Ok(distance(&field, &truth))
}
