//! The data of a fit, linearised at some unknowns, with all that is known of their errors.

use crate::fit::law::{FitStep, LinearFit, rms};
use crate::fit::load::FitTask;
use crate::fit::prior::IndexPrior;
use crate::fit::response::Response;
use crate::numerics::estimate::jackknife_covariance;
use faer::Mat;

/// Strengths of the prior among which the evidence chooses: size of the second differences.
const STRENGTHS: [f64; 12] = [0.005, 0.007, 0.01, 0.014, 0.02, 0.03, 0.04, 0.06, 0.08, 0.12, 0.2, 0.4];
/// Logarithm of the evidence that the strength may cost: one standard error of it. The prior that
/// bends most within it is taken, which errs towards wider intervals.
const CONCEDED: f64 = 0.5;

/// The data, linearised at some unknowns.
pub(super) struct Data<'a> {
    pub task: &'a FitTask,
    pub prior: &'a IndexPrior,
    /// The unknowns.
    point: &'a [f64],
    jacobian: Mat<f64>,
    pub residual: Vec<f64>,
    /// Covariance that weights the data: noise, ensemble and grid at each wavelength for itself.
    pub weights: Mat<f64>,
    /// All that is known of the errors, with the correlations over the wavelengths.
    pub errors: Mat<f64>,
    /// Derivatives of the data with respect to the logarithm of the thickness.
    pub thickness: Vec<f64>,
}

impl<'a> Data<'a> {
    /// `systematic` is an error of every value in addition to noise and ensemble: one for each
    /// drawdown, or one for all.
    pub fn new(
        task: &'a FitTask,
        (prior, point): (&'a IndexPrior, &'a [f64]),
        response: &Response,
        systematic: &[f64],
    ) -> Self {
        let waves = task.wavelengths_nm().len();
        let size = task.measured.len() * waves;
        let places: Vec<(usize, usize)> = (0..size).map(|i| (i / waves, i % waves)).collect();
        let jacobian = Mat::from_fn(size, prior.count(), |i, j| derivative(prior, response, places[i], j));
        let (mut weights, mut errors) = (Mat::zeros(size, size), Mat::zeros(size, size));
        let noise = task.settings.noise.powi(2);
        let inflation = few_cells(response.replicates.first().map_or(0, Vec::len));
        for (i, &(d, v)) in places.iter().enumerate() {
            let grid = systematic[d.min(systematic.len() - 1)].powi(2);
            for (j, &(e, w)) in places.iter().enumerate() {
                let one_coat = task.measured[d].coat == task.measured[e].coat;
                let [a, b] = [d, e].map(|drawdown| &response.replicates[drawdown]);
                let ensemble = if one_coat { jackknife(a, b, v, w) } else { 0.0 };
                let own = if v == w { ensemble } else { 0.0 };
                let common = if d == e { grid } else { 0.0 };
                weights[(i, j)] = own + if i == j { noise + grid } else { 0.0 };
                errors[(i, j)] = inflation * ensemble + common + if i == j { noise } else { 0.0 };
            }
        }
        let residual = places.iter().map(|&(d, w)| task.measured[d].measured(w) - response.values[d][w]);
        let thickness = places.iter().map(|&(d, w)| response.slopes[2][d][w]).collect();
        Self { task, prior, point, jacobian, residual: residual.collect(), weights, errors, thickness }
    }

    /// What is left of the data at other unknowns, to first order.
    pub fn left(&self, unknowns: &[f64]) -> Vec<f64> {
        let mut left = self.residual.clone();
        for (i, left) in left.iter_mut().enumerate() {
            let parts = self.point.iter().zip(unknowns).enumerate();
            *left -= parts.map(|(j, (a, b))| self.jacobian[(i, j)] * (b - a)).sum::<f64>();
        }
        left
    }

    pub fn step(&self, strength: f64) -> Option<FitStep> {
        let problem = LinearFit {
            jacobian: &self.jacobian,
            residual: &self.residual,
            covariance: &self.weights,
            point: self.point,
            mean: &self.prior.mean,
            precision: &self.prior.precision(strength),
            positive: &self.prior.positive,
        };
        problem.step()
    }

    /// The largest strength of the prior that the evidence allows, and its step.
    pub fn chosen(&self) -> Option<(f64, FitStep)> {
        let all = STRENGTHS.into_iter().filter_map(|strength| Some((strength, self.step(strength)?)));
        let all: Vec<(f64, FitStep)> = all.collect();
        let most = all.iter().map(|(_, step)| step.log_evidence).fold(f64::NEG_INFINITY, f64::max);
        all.into_iter().rev().find(|(_, step)| step.log_evidence >= most - CONCEDED)
    }

    /// χ² of data and prior together at the point of the linearisation.
    pub fn cost(&self, strength: f64) -> f64 {
        let precision = self.prior.precision(strength);
        let away: Vec<f64> = self.point.iter().zip(&self.prior.mean).map(|(a, b)| a - b).collect();
        let noise = self.residual.iter().enumerate().map(|(i, left)| left.powi(2) / self.weights[(i, i)]);
        let mut pull = 0.0;
        for (i, own) in away.iter().enumerate() {
            pull += away.iter().enumerate().map(|(j, other)| own * precision[(i, j)] * other).sum::<f64>();
        }
        noise.sum::<f64>() + pull
    }

    /// Root mean square change of the data at other unknowns, to first order.
    pub fn moved(&self, to: &[f64]) -> f64 {
        rms(self.residual.iter().zip(self.left(to)).map(|(a, b)| a - b))
    }
}

/// Derivative of a value, by drawdown and wavelength, with respect to an unknown.
fn derivative(prior: &IndexPrior, response: &Response, (d, w): (usize, usize), j: usize) -> f64 {
    let [n, kappa, thickness] = [0, 1, 2].map(|k| response.slopes[k][d][w]);
    let last = f64::from(u8::from(prior.thickness && j + 1 == prior.count()));
    n * prior.n[w][j] + kappa * prior.kappa[w][j] + last * thickness
}

/// Variance of a Student law over that of a normal one: errors estimated from few cells.
pub(super) fn few_cells(cells: usize) -> f64 {
    if cells > 3 { (cells - 1) as f64 / (cells - 3) as f64 } else { 3.0 }
}

/// Jackknife covariance of two values from their leave-one-out replicates.
pub(super) fn jackknife(one: &[Vec<f64>], other: &[Vec<f64>], v: usize, w: usize) -> f64 {
    let pairs: Vec<[f64; 2]> = one.iter().zip(other).map(|(x, y)| [x[v], y[w]]).collect();
    jackknife_covariance(&pairs).map_or(0.0, |covariance| covariance[0][1])
}
