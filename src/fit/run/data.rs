//! The data of a fit, linearised at some unknowns, with all that is known of their errors.

use crate::fit::law::{FitStep, LinearFit};
use crate::fit::load::FitTask;
use crate::fit::prior::IndexPrior;
use crate::fit::response::Response;
use faer::Mat;

/// Strengths of the prior among which the evidence chooses: size of the second differences.
const STRENGTHS: [f64; 8] = [0.005, 0.01, 0.02, 0.035, 0.06, 0.1, 0.2, 0.4];

/// The data, linearised at some unknowns.
pub(super) struct Data {
    jacobian: Mat<f64>,
    pub residual: Vec<f64>,
    /// Covariance that weights the data: noise, ensemble and grid at each wavelength for itself.
    pub weights: Mat<f64>,
    /// All that is known of the errors, with the correlations over the wavelengths.
    pub errors: Mat<f64>,
    /// Derivatives of the data with respect to the logarithm of the thickness.
    pub thickness: Vec<f64>,
}

impl Data {
    /// `systematic` is an error of every value in addition to noise and ensemble: one for each
    /// drawdown, or one for all.
    pub fn new(task: &FitTask, prior: &IndexPrior, response: &Response, systematic: &[f64]) -> Self {
        let (waves, count) = (task.wavelengths_nm().len(), task.measured.len());
        let at = |i: usize| (i / waves, i % waves);
        let last = |j: usize| f64::from(u8::from(prior.thickness && j + 1 == prior.len()));
        let slope = |i: usize, j: usize| {
            let (d, w) = at(i);
            let [n, kappa, thickness] = [0, 1, 2].map(|k| response.slopes[k][d][w]);
            n * prior.n[w][j] + kappa * prior.kappa[w][j] + last(j) * thickness
        };
        let jacobian = Mat::from_fn(count * waves, prior.len(), slope);
        let measured = |d: usize, w: usize| task.measured[d].values.as_ref().map_or(f64::NAN, |v| v[w]);
        let residual = |i: usize| measured(at(i).0, at(i).1) - response.values[at(i).0][at(i).1];
        let noise = task.settings.noise.powi(2);
        let coat = |d: usize| task.measured[d].coat;
        let grid = |d: usize| systematic[d.min(systematic.len() - 1)].powi(2);
        let ensemble = |i: usize, j: usize| {
            let ((d, v), (e, w)) = (at(i), at(j));
            let common = || jackknife(&response.replicates[d], &response.replicates[e], v, w);
            if coat(d) == coat(e) { common() } else { 0.0 }
        };
        let size = count * waves;
        let inflation = few_cells(response.replicates.first().map_or(0, Vec::len));
        let weights = Mat::from_fn(size, size, |i, j| {
            let own = if at(i).1 == at(j).1 { ensemble(i, j) } else { 0.0 };
            own + if i == j { noise + grid(at(i).0) } else { 0.0 }
        });
        let errors = Mat::from_fn(size, size, |i, j| {
            let common = if at(i).0 == at(j).0 { grid(at(i).0) } else { 0.0 };
            inflation * ensemble(i, j) + common + if i == j { noise } else { 0.0 }
        });
        let residual = (0..size).map(residual).collect();
        let thickness = (0..size).map(|i| response.slopes[2][at(i).0][at(i).1]).collect();
        Self { jacobian, residual, weights, errors, thickness }
    }

    /// What is left of the data at other unknowns, to first order.
    pub fn left(&self, point: &[f64], unknowns: &[f64]) -> Vec<f64> {
        let change = |i: usize| {
            let parts = point.iter().zip(unknowns).enumerate();
            parts.map(|(j, (a, b))| self.jacobian[(i, j)] * (b - a)).sum::<f64>()
        };
        self.residual.iter().enumerate().map(|(i, left)| left - change(i)).collect()
    }

    pub fn step(&self, prior: &IndexPrior, point: &[f64], strength: f64) -> Option<FitStep> {
        let problem = LinearFit {
            jacobian: &self.jacobian,
            residual: &self.residual,
            covariance: &self.weights,
            point,
            mean: &prior.mean,
            precision: &prior.precision(strength),
            positive: &prior.positive,
        };
        problem.step()
    }

    /// The strength of the prior with the largest evidence, and its step.
    pub fn strongest(&self, prior: &IndexPrior, point: &[f64]) -> Option<(f64, FitStep)> {
        let of = |strength: f64| Some((strength, self.step(prior, point, strength)?));
        let all: Vec<(f64, FitStep)> = STRENGTHS.into_iter().filter_map(of).collect();
        all.into_iter().max_by(|a, b| a.1.log_evidence.total_cmp(&b.1.log_evidence))
    }

    /// χ² of data and prior together at the point of the linearisation.
    pub fn cost(&self, prior: &IndexPrior, point: &[f64], strength: f64) -> f64 {
        let precision = prior.precision(strength);
        let away: Vec<f64> = point.iter().zip(&prior.mean).map(|(a, b)| a - b).collect();
        let pull = |i: usize| (0..away.len()).map(|j| away[i] * precision[(i, j)] * away[j]).sum::<f64>();
        let noise = |i: usize| self.residual[i].powi(2) / self.weights[(i, i)];
        (0..self.residual.len()).map(noise).sum::<f64>() + (0..away.len()).map(pull).sum::<f64>()
    }

    /// Root mean square change of the data between two sets of unknowns, to first order.
    pub fn moved(&self, from: &[f64], to: &[f64]) -> f64 {
        let changes = self.residual.iter().zip(self.left(from, to)).map(|(a, b)| (a - b).powi(2));
        (changes.sum::<f64>() / self.residual.len().max(1) as f64).sqrt()
    }
}

/// Variance of a Student law over that of a normal one: errors estimated from few cells.
pub(super) fn few_cells(cells: usize) -> f64 {
    if cells > 3 { (cells - 1) as f64 / (cells - 3) as f64 } else { 3.0 }
}

/// Jackknife covariance of two values from their leave-one-out replicates.
pub(super) fn jackknife(one: &[Vec<f64>], other: &[Vec<f64>], v: usize, w: usize) -> f64 {
    let n = one.len() as f64;
    if one.len() < 2 {
        return 0.0;
    }
    let mean = |all: &[Vec<f64>], k: usize| all.iter().map(|row| row[k]).sum::<f64>() / n;
    let (a, b) = (mean(one, v), mean(other, w));
    one.iter().zip(other).map(|(x, y)| (x[v] - a) * (y[w] - b)).sum::<f64>() * (n - 1.0) / n
}
