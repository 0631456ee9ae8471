//! The least squares on a table of responses: descent from a start, with the strength of the prior
//! chosen by the evidence.

use super::FitError;
use crate::fit::data::Data;
use crate::fit::file::AlsoFitted;
use crate::fit::law::LinearFit;
use crate::fit::load::FitTask;
use crate::fit::prior::IndexPrior;
use crate::fit::response::Response;
use faer::Mat;

/// Largest change of n in one step.
const LARGEST_STEP: f64 = 0.15;
/// Strength before any is chosen.
const FIRST_STRENGTH: f64 = 0.06;
/// Iterations on the table, and halvings of a step that leads uphill.
const ITERATIONS: usize = 12;
const HALVINGS: usize = 5;

/// A branch that fits the data on the table.
pub(in crate::fit) struct Branch {
    pub unknowns: Vec<f64>,
    /// Minus twice the logarithm of the evidence.
    pub(super) cost: f64,
}

/// The prior of a fit.
pub(in crate::fit) fn prior_of(task: &FitTask) -> IndexPrior {
    let is_also = |what: AlsoFitted| task.settings.also.contains(&what);
    let nm = task.wavelengths_nm();
    let prior = IndexPrior::new(task.settings.prior, nm, task.binder_index(), is_also(AlsoFitted::Thickness));
    let prior = if is_also(AlsoFitted::FaceLight) { prior.with_face_light() } else { prior };
    match task.settings.known_n {
        Some(known) => prior.with_known(nm, known),
        None => prior,
    }
}

/// Gauss–Newton on a table, with the strength of the prior chosen by the evidence on the way;
/// `systematic` are the table's errors as [`Data::new`] takes them.
pub(in crate::fit) fn descend(
    task: &FitTask,
    prior: &IndexPrior,
    start: Vec<f64>,
    systematic: &[f64],
    response_at: impl Fn(&[f64]) -> Result<Response, FitError>,
) -> Result<Branch, FitError> {
    let mut unknowns = start;
    let mut response = response_at(&unknowns)?;
    for round in 0..ITERATIONS {
        let early = round < ITERATIONS / 3;
        let prior = if early { prior } else { &prior.adapted(&unknowns) };
        let data = Data::new(task, prior, &unknowns, &response, systematic);
        let chosen =
            if early { data.step(FIRST_STRENGTH).map(|step| (FIRST_STRENGTH, step)) } else { data.chosen() };
        let (strength, step) = chosen.ok_or(FitError::Singular)?;
        let before = data.cost(strength).ok_or(FitError::Singular)?;
        let mut share = 1.0;
        let mut moved = None;
        for _ in 0..HALVINGS {
            let tried = between(&unknowns, &step.unknowns, share);
            let response = response_at(&tried)?;
            let data = Data::new(task, prior, &tried, &response, systematic);
            if data.cost(strength).is_some_and(|cost| cost < before) {
                moved = Some((tried, response));
                break;
            }
            share *= 0.4;
        }
        let Some((next, there)) = moved else { break };
        (unknowns, response) = (next, there);
    }
    let prior = prior.adapted(&unknowns);
    let data = Data::new(task, &prior, &unknowns, &response, systematic);
    let cost = -2.0 * data.chosen().ok_or(FitError::Singular)?.1.log_evidence;
    Ok(Branch { unknowns, cost })
}

/// The unknowns whose index is nearest to a path of \[n, κ\].
pub(in crate::fit) fn near(prior: &IndexPrior, path: &[[f64; 2]]) -> Option<Vec<f64>> {
    let waves = path.len();
    let count = prior.count();
    let rows = |i: usize| if i < waves { &prior.n[i] } else { &prior.kappa[i - waves] };
    let expected = |i: usize| rows(i).iter().zip(&prior.mean).map(|(a, x)| a * x).sum::<f64>();
    let residual: Vec<f64> = (0..2 * waves).map(|i| path[i % waves][i / waves] - expected(i)).collect();
    let covariance = Mat::from_fn(2 * waves, 2 * waves, |i, j| if i == j { 4e-4 } else { 0.0 });
    let problem = LinearFit {
        jacobian: &Mat::from_fn(2 * waves, count, |i, j| rows(i)[j]),
        residual: &residual,
        covariance: &covariance,
        point: &prior.mean,
        mean: &prior.mean,
        precision: &prior.precision(FIRST_STRENGTH),
        positive: &prior.positive,
    };
    Some(problem.step()?.unknowns)
}

pub(super) fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
}

/// Share of a step that keeps the change of n within its limit.
pub(super) fn share_of_step(prior: &IndexPrior, from: &[f64], to: &[f64]) -> f64 {
    let (from, to) = (prior.index(from), prior.index(to));
    let largest = from.iter().zip(&to).map(|(a, b)| (b[0] - a[0]).abs()).fold(0.0, f64::max);
    (LARGEST_STEP / largest.max(1e-12)).min(1.0)
}
