//! The data of a fit, linearised at some unknowns, with all that is known of their errors.

use super::law::{FitStep, LinearFit, cholesky, column, log_determinant};
use super::load::FitTask;
use super::prior::IndexPrior;
use super::response::Response;
use crate::numerics::estimate::jackknife_covariance;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Strengths of the prior among which the evidence chooses: size of the second differences.
const STRENGTHS: [f64; 12] = [0.005, 0.007, 0.01, 0.014, 0.02, 0.03, 0.04, 0.06, 0.08, 0.12, 0.2, 0.4];
/// Logarithm of the evidence that the strength may cost: one standard error of it. The prior that
/// bends most within it is taken, which errs towards wider intervals.
const CONCEDED: f64 = 0.5;

/// One number of a fit's data: a measured value of a spectrum, or a number made of one.
struct Datum {
    drawdown: usize,
    /// Its wavelength by its place; none of a number made of a spectrum.
    wave: Option<usize>,
    /// Derivatives of it with respect to the values of the drawdown's spectrum: place and slope.
    slopes: Vec<(usize, f64)>,
    /// Measured less predicted.
    residual: f64,
    /// Variance of the measurement.
    noise: f64,
}

impl Datum {
    /// A sum over the values of its spectrum.
    fn sum(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.slopes.iter().map(|&(wave, slope)| slope * of(wave)).sum()
    }

    /// All data: spectra by drawdown, then wavelength; after them the numbers.
    fn all(task: &FitTask, response: &Response, added: f64) -> Vec<Self> {
        let nm = task.wavelengths_nm();
        let (mut spectra, mut numbers) = (Vec::new(), Vec::new());
        for (drawdown, sample) in task.measured.iter().enumerate() {
            let on_face = if sample.is_reflected() { added } else { 0.0 };
            for wave in 0..sample.values.as_ref().map_or(0, Vec::len) {
                let residual = sample.measured(wave) - response.values[drawdown][wave] - on_face;
                let noise = task.settings.noise.powi(2);
                spectra.push(Self { drawdown, wave: Some(wave), slopes: vec![(wave, 1.0)], residual, noise });
            }
            let predicted: Vec<f64> = response.values[drawdown].iter().map(|value| value + on_face).collect();
            for number in &sample.numbers {
                let there = number.at(nm, &predicted);
                let slopes = there.slopes.into_iter().enumerate().collect();
                let residual = number.value - there.value;
                let noise = number.error.powi(2) + there.wavelength_error.powi(2);
                numbers.push(Self { drawdown, wave: None, slopes, residual, noise });
            }
        }
        spectra.extend(numbers);
        spectra
    }
}

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
    /// `systematic` is an error of every value in addition to noise and ensemble, common to all of a
    /// drawdown: one for each value (by drawdown, then wavelength), one for each drawdown, or one for
    /// all.
    pub fn new(
        task: &'a FitTask,
        prior: &'a IndexPrior,
        point: &'a [f64],
        response: &Response,
        systematic: &[f64],
    ) -> Self {
        let waves = task.wavelengths_nm().len();
        let all = Datum::all(task, response, prior.face_light(point));
        let size = all.len();
        let is_reflected = |d: usize| task.measured[d].is_reflected();
        let jacobian = Mat::from_fn(size, prior.count(), |i, j| {
            let d = all[i].drawdown;
            let on_face = f64::from(u8::from(prior.face_light == Some(j) && is_reflected(d)));
            all[i].sum(|w| derivative(prior, response, (d, w), j) + on_face)
        });
        let (mut weights, mut errors) = (Mat::zeros(size, size), Mat::zeros(size, size));
        let systematic_at = |d: usize, w: usize| match systematic.len() {
            1 => systematic[0],
            count if count == task.measured.len() => systematic[d],
            _ => systematic[d * waves + w],
        };
        let own: Vec<f64> = all.iter().map(|datum| datum.sum(|w| systematic_at(datum.drawdown, w))).collect();
        let inflation = few_cells(response.replicates.first().map_or(0, Vec::len));
        let replicates: Vec<Vec<f64>> = all
            .iter()
            .map(|datum| {
                response.replicates[datum.drawdown].iter().map(|cell| datum.sum(|w| cell[w])).collect()
            })
            .collect();
        for (i, one) in all.iter().enumerate() {
            for (j, other) in all.iter().enumerate() {
                let one_coat = task.measured[one.drawdown].coat == task.measured[other.drawdown].coat;
                let ensemble = if one_coat { jackknife(&replicates[i], &replicates[j]) } else { 0.0 };
                let is_together = i == j || (one.wave.is_some() && one.wave == other.wave);
                let at_one_wavelength = if is_together { ensemble } else { 0.0 };
                let common = if one.drawdown == other.drawdown { own[i] * own[j] } else { 0.0 };
                let noise = if i == j { one.noise } else { 0.0 };
                weights[(i, j)] = at_one_wavelength + if i == j { noise + own[i] * own[i] } else { 0.0 };
                errors[(i, j)] = inflation * ensemble + common + noise;
            }
        }
        let residual = all.iter().map(|datum| datum.residual).collect();
        let thickness =
            all.iter().map(|datum| datum.sum(|w| response.slopes[2][datum.drawdown][w])).collect();
        Self { task, prior, point, jacobian, residual, weights, errors, thickness }
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
        self.linear(strength, |problem| problem.step())
    }

    /// The unknowns of the linearisation, as [`LinearFit::here`] has them.
    pub fn here(&self, strength: f64) -> Option<FitStep> {
        self.linear(strength, |problem| problem.here())
    }

    fn linear<T>(&self, strength: f64, of: impl Fn(&LinearFit) -> Option<T>) -> Option<T> {
        let Self { jacobian, residual, weights: covariance, point, prior, .. } = self;
        let positive = &prior.positive;
        let (precision, mean) = &prior.expectation(strength)?;
        of(&LinearFit { jacobian, residual, covariance, point, mean, precision, positive })
    }

    /// Covariance of the unknowns of a step, with all that is known of the errors. What is left of
    /// the way counts as an error of its size.
    pub fn covariance(&self, step: &FitStep) -> Mat<f64> {
        let way = column(&step.away);
        let more = &step.gain * (&self.errors - &self.weights) * step.gain.transpose();
        &step.posterior + more + &way * way.transpose()
    }

    /// The largest strength of the prior that the evidence allows, and its step.
    pub fn chosen(&self) -> Option<(f64, FitStep)> {
        let all = STRENGTHS.into_iter().filter_map(|strength| Some((strength, self.step(strength)?)));
        let all: Vec<(f64, FitStep)> = all.collect();
        let most = all.iter().map(|(_, step)| step.log_evidence).fold(f64::NEG_INFINITY, f64::max);
        all.into_iter().rev().find(|(_, step)| step.log_evidence >= most - CONCEDED)
    }

    /// χ² of data and prior together at the point of the linearisation: the function whose minimum
    /// [`Data::step`] finds to first order, with the same covariance. `None` if that is not
    /// positive definite.
    pub fn cost(&self, strength: f64) -> Option<f64> {
        let left = column(&self.residual);
        let misfit = left.transpose() * cholesky(&self.weights)?.solve(&left);
        let (precision, mean) = self.prior.expectation(strength)?;
        let away = column(self.point) - column(&mean);
        let pull = away.transpose() * (precision * &away);
        Some(misfit[(0, 0)] + pull[(0, 0)])
    }

    /// [`Data::cost`] where the covariance differs from point to point: with its logarithm.
    pub fn loss(&self, strength: f64) -> Option<f64> {
        Some(self.cost(strength)? + log_determinant(&cholesky(&self.weights)?))
    }
}

/// Derivative of a value, by drawdown and wavelength, with respect to an unknown.
pub(super) fn derivative(prior: &IndexPrior, response: &Response, (d, w): (usize, usize), j: usize) -> f64 {
    let [along_n, along_kappa, along_thickness] = [0, 1, 2].map(|k| response.slopes[k][d][w]);
    let of_thickness = f64::from(u8::from(prior.thickness == Some(j)));
    along_n * prior.n[w][j] + along_kappa * prior.kappa[w][j] + of_thickness * along_thickness
}

/// Variance of a Student law over that of a normal one: errors estimated from few cells.
pub(super) fn few_cells(cells: usize) -> f64 {
    if cells > 3 { (cells - 1) as f64 / (cells - 3) as f64 } else { 3.0 }
}

/// Jackknife covariance of two values from their leave-one-out replicates.
pub(super) fn jackknife(one: &[f64], other: &[f64]) -> f64 {
    let pairs: Vec<[f64; 2]> = one.iter().zip(other).map(|(x, y)| [*x, *y]).collect();
    jackknife_covariance(&pairs).map_or(0.0, |covariance| covariance[0][1])
}
