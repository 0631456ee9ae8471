//! Linear least squares with a prior: the step of Gauss–Newton, the evidence of the data, and the
//! covariance of the unknowns.

use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};

/// A linear problem: data less the prediction at some unknowns x₀, with derivatives there.
pub struct LinearFit<'a> {
    /// Derivatives of the data: rows of the unknowns' weights.
    pub jacobian: &'a Mat<f64>,
    /// Data less prediction at `point`.
    pub residual: &'a [f64],
    /// Covariance of the data.
    pub covariance: &'a Mat<f64>,
    /// The unknowns at which the data are linearised.
    pub point: &'a [f64],
    /// Expected values of the unknowns.
    pub mean: &'a [f64],
    /// Precision of the expectation.
    pub precision: &'a Mat<f64>,
    /// Unknowns that must not be negative.
    pub positive: &'a [bool],
}

/// The most likely unknowns, and what speaks for them.
#[derive(Clone, Debug)]
pub struct FitStep {
    /// The unknowns.
    pub unknowns: Vec<f64>,
    /// χ² of the data, to first order.
    pub chi_squared: f64,
    /// Logarithm of the probability of the data, up to a constant.
    pub log_evidence: f64,
    /// Unknowns that the data determine.
    pub effective: f64,
    /// Derivatives of the unknowns with respect to the data.
    pub gain: Mat<f64>,
    /// Covariance of the unknowns for data of the stated covariance.
    pub posterior: Mat<f64>,
    /// From these unknowns to the most likely ones by the linear problem.
    pub away: Vec<f64>,
    /// By how much the cost would fall on that way.
    pub promised: f64,
}

/// Root mean square; 0 of no numbers.
pub fn rms(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let (count, sum) = numbers.into_iter().fold((0, 0.0), |(count, sum), x| (count + 1, sum + x * x));
    (sum / f64::from(count.max(1))).sqrt()
}

pub(super) fn cholesky(matrix: &Mat<f64>) -> Option<Llt<f64>> {
    matrix.llt(Side::Lower).ok()
}

pub(super) fn log_determinant(factors: &Llt<f64>) -> f64 {
    (0..factors.L().nrows()).map(|i| 2.0 * factors.L()[(i, i)].ln()).sum()
}

pub(super) fn column(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), 1, |i, _| values[i])
}

impl LinearFit<'_> {
    /// The most likely unknowns; `None` if a matrix is not positive definite.
    pub fn step(&self) -> Option<FitStep> {
        self.solved(false)
    }

    /// The unknowns at which the data are linearised, where nothing is extrapolated, and the way
    /// from there to the most likely ones; `None` if a matrix is not positive definite.
    pub fn here(&self) -> Option<FitStep> {
        self.solved(true)
    }

    fn solved(&self, is_here: bool) -> Option<FitStep> {
        let covariance = cholesky(self.covariance)?;
        let weighted = covariance.solve(self.jacobian); // C⁻¹ J
        let normal = self.jacobian.transpose() * &weighted + self.precision;
        let factors = cholesky(&normal)?;
        let gain = factors.solve(weighted.transpose()); // H⁻¹ Jᵀ C⁻¹
        let mean = column(self.mean);
        let data = column(self.residual) + self.jacobian * column(self.point);
        let right = weighted.transpose() * &data + self.precision * &mean;
        let likeliest = self.bounded(&normal, &right)?;
        let unknowns = if is_here { column(self.point) } else { likeliest.clone() };
        let way = &likeliest - &unknowns;
        let promised = ((&right * 2.0 - &normal * (&unknowns + &likeliest)).transpose() * &way)[(0, 0)];
        let left = &data - self.jacobian * &unknowns;
        let away = &unknowns - &mean;
        let chi_squared = (left.transpose() * covariance.solve(&left))[(0, 0)];
        let occam = log_determinant(&factors) - log_determinant(&cholesky(self.precision)?)
            + log_determinant(&covariance);
        let pull = (away.transpose() * (self.precision * &away))[(0, 0)];
        let log_evidence = -0.5 * (chi_squared + pull + occam);
        let effective = (&gain * self.jacobian).diagonal().column_vector().iter().sum();
        let listed = |column: &Mat<f64>| (0..column.nrows()).map(|i| column[(i, 0)]).collect();
        Some(FitStep {
            unknowns: listed(&unknowns),
            chi_squared,
            log_evidence,
            effective,
            gain,
            posterior: factors.inverse(),
            away: listed(&way),
            promised: promised.max(0.0),
        })
    }

    /// Solves H x = g with x ≥ 0 where that is required, by an active set.
    fn bounded(&self, normal: &Mat<f64>, right: &Mat<f64>) -> Option<Mat<f64>> {
        let count = right.nrows();
        let mut held = vec![false; count];
        for _ in 0..2 * count + 1 {
            let free: Vec<usize> = (0..count).filter(|&i| !held[i]).collect();
            let part = Mat::from_fn(free.len(), free.len(), |i, j| normal[(free[i], free[j])]);
            let solved = cholesky(&part)?.solve(Mat::from_fn(free.len(), 1, |i, _| right[(free[i], 0)]));
            let mut x = Mat::zeros(count, 1);
            free.iter().enumerate().for_each(|(k, &i)| x[(i, 0)] = solved[(k, 0)]);
            let worst =
                free.iter().copied().filter(|i| self.positive[*i] && x[(*i, 0)] < 0.0).collect::<Vec<_>>();
            if worst.is_empty() {
                let pull = normal * &x - right;
                let Some(i) = (0..count).find(|&i| held[i] && pull[(i, 0)] < -1e-9) else { return Some(x) };
                held[i] = false;
            }
            worst.into_iter().for_each(|i| held[i] = true);
        }
        let mut x = cholesky(normal)?.solve(right);
        (0..count).filter(|&i| self.positive[i]).for_each(|i| x[(i, 0)] = x[(i, 0)].max(0.0));
        Some(x)
    }
}

impl FitStep {
    /// The way that is left, in standard errors of the unknowns that the data determine.
    pub fn to_go(&self) -> f64 {
        (self.promised / self.effective.max(1.0)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_with_its_errors_and_bounds() {
        let jacobian = Mat::from_fn(6, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        let covariance = Mat::from_fn(6, 6, |i, j| if i == j { 0.01 } else { 0.0 });
        let precision = Mat::from_fn(2, 2, |i, j| if i == j { 1e-6 } else { 0.0 });
        let fit = |slope: f64| {
            let residual: Vec<f64> = (0..6).map(|i| 2.0 + slope * f64::from(i)).collect();
            let problem = LinearFit {
                jacobian: &jacobian,
                residual: &residual,
                covariance: &covariance,
                point: &[0.0; 2],
                mean: &[0.0; 2],
                precision: &precision,
                positive: &[false, true],
            };
            problem.step().unwrap()
        };
        let step = fit(0.5);
        assert!((step.unknowns[0] - 2.0).abs() < 1e-6 && (step.unknowns[1] - 0.5).abs() < 1e-6);
        // σ² / Σ (x − x̄)² for the slope
        assert!((step.posterior[(1, 1)] - 0.01 / 17.5).abs() < 1e-6);
        assert!((step.effective - 2.0).abs() < 1e-6 && step.chi_squared < 1e-9);
        let held = fit(-0.5);
        assert_eq!(held.unknowns[1], 0.0);
        assert!((held.unknowns[0] - 0.75).abs() < 1e-6, "the mean of the data");
    }
}
