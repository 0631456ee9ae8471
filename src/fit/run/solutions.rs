//! Whether a fit has one solution or two, and what would tell two apart.

use super::advice::{Advice, advice};
use super::outcome::{FitOutcome, OtherSolution, Trust, UNDETERMINED};
use super::{FitError, FitSolution};
use crate::fit::law::rms;
use crate::fit::load::FitTask;

/// Differences of χ² and of −2 ln(probability of the data) within which two solutions fit equally
/// well (3 σ).
pub(super) const AS_GOOD: f64 = 9.0;
/// Standard errors of n that cover another solution.
const COVERED: f64 = 2.0;

/// Root mean square difference of two n over the wavelengths.
pub(super) fn apart(one: &[f64], other: &[f64]) -> f64 {
    rms(one.iter().zip(other).map(|(a, b)| a - b))
}

/// The outcome of a fit from its solutions, which are those of branches that fitted the coarse
/// table equally well: the likeliest one, and beside it another where the solves do not exclude it.
pub(super) fn concluded(task: &FitTask, mut solutions: Vec<FitSolution>) -> Result<FitOutcome, FitError> {
    let cost = |solution: &FitSolution| solution.outcome.evidence_cost;
    solutions.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let (best, others) = solutions.split_first().ok_or(FitError::Singular)?;
    let mut outcome = best.outcome.clone();
    let n = |solution: &FitSolution| solution.outcome.index.iter().map(|row| row.n).collect::<Vec<_>>();
    let n_error = rms(outcome.index.iter().filter_map(|row| row.n_error));
    let least = UNDETERMINED.max(COVERED * n_error);
    let stated = outcome.trust != Trust::Contradicted;
    let other = others.iter().find(|other| stated && apart(&n(best), &n(other)) > least);
    let Some(other) = other else { return Ok(with_advice(task, outcome, best, None)) };
    // one that has not converged may yet fall by what its derivatives promise
    let promised = other.step.promised;
    // not χ² alone: the one that may bend more, with more effective unknowns, has less of it
    let worse = cost(other) - cost(best);
    if worse - promised > AS_GOOD {
        let excluded = format!(
            "a second solution with mean n ≈ {:.2}, which fitted the coarse table, is excluded by the solves (χ² {:.0} \
             against {:.0}; −2 ln of the probability of the data larger by {worse:.0})",
            mean_n(other),
            other.outcome.chi_squared,
            outcome.chi_squared
        );
        outcome.remarks.insert(0, excluded);
        return Ok(with_advice(task, outcome, best, None));
    }
    outcome.n_is_determined = false;
    Ok(with_advice(task, outcome, best, Some(other)))
}

fn mean_n(solution: &FitSolution) -> f64 {
    let index = &solution.outcome.index;
    index.iter().map(|row| row.n).sum::<f64>() / index.len().max(1) as f64
}

/// Adds the other solution, and says what would determine n where nothing does.
fn with_advice(
    task: &FitTask,
    mut outcome: FitOutcome,
    best: &FitSolution,
    other: Option<&FitSolution>,
) -> FitOutcome {
    if outcome.n_is_determined || outcome.trust == Trust::Contradicted {
        return outcome;
    }
    let said = match other {
        Some(other) => {
            format!(
                "n is not determined: two solutions fit equally well, with mean n ≈ {:.2} and {:.2} (χ² {:.0} and {:.0}). ",
                mean_n(best),
                mean_n(other),
                outcome.chi_squared,
                other.outcome.chi_squared
            )
        }
        None => {
            let n_error = rms(outcome.index.iter().filter_map(|row| row.n_error));
            format!("n is not determined: its standard error is {n_error:.2} (root mean square). ")
        }
    };
    let helps = advice(task, best, other).unwrap_or_else(|_| Advice::none(task));
    outcome.remarks.insert(0, said + &helps.sentence);
    outcome.other_solution = other.map(|other| {
        let FitOutcome {
            index, chi_squared, effective_unknowns, linearisations, log_thickness, spectra, ..
        } = other.outcome.clone();
        OtherSolution { index, chi_squared, effective_unknowns, linearisations, log_thickness, spectra }
    });
    if other.is_some() && !task.predicted.is_empty() {
        outcome.remarks.push("the predicted layers are those of the first solution".into());
    }
    outcome
}
