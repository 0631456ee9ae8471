//! A number with its standard error, and the jackknife for statistics that are not linear.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A value and its standard error (one standard deviation of the value). The error is `None`, not
/// zero, where a single realisation leaves it unknown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error, in the value's unit.
    pub standard_error: Option<f64>,
}

impl Estimate {
    /// A value without a known error.
    pub fn unknown_error(value: f64) -> Self {
        Self { value, standard_error: None }
    }

    /// Mean of independent samples and s/√n with the unbiased s² (n − 1); no samples give 0, error
    /// unknown.
    pub fn of_mean(samples: &[f64]) -> Self {
        let n = samples.len() as f64;
        let value = samples.iter().sum::<f64>() / n.max(1.0);
        let square = samples.iter().map(|x| (x - value).powi(2)).sum::<f64>();
        let standard_error = (samples.len() > 1).then(|| (square / (n - 1.0) / n).sqrt());
        Self { value, standard_error }
    }

    /// A statistic of the whole ensemble with the jackknife error of its leave-one-out replicates.
    pub fn jackknife(whole: f64, replicates: &[f64]) -> Self {
        let columns: Vec<[f64; 1]> = replicates.iter().map(|&x| [x]).collect();
        let variance = jackknife_covariance(&columns).map(|c| c[0][0]);
        Self { value: whole, standard_error: variance.map(f64::sqrt) }
    }

    /// The estimate with a lower bound on its error, such as a counting error, which few
    /// realisations estimate badly.
    pub fn at_least(self, floor: f64) -> Self {
        Self { standard_error: Some(self.standard_error.unwrap_or(0.0).max(floor)), ..self }
    }

    /// Display such as `35.55 ± 0.56`: the error with two significant digits and the value rounded
    /// to match. The value alone, with `decimals`, if the error is unknown or zero; empty for NaN.
    pub fn in_words(&self, decimals: usize) -> String {
        if !self.value.is_finite() {
            return String::new();
        }
        let error = self.standard_error.filter(|error| error.is_finite() && *error > 0.0);
        let Some(error) = error else { return signed(self.value, decimals) };
        let decimals = decimals_of(error);
        format!("{} ± {error:.decimals$}", signed(self.value, decimals))
    }
}

/// Largest number of decimals displayed.
const MOST_DECIMALS: i32 = 12;

/// Decimals that show an error with two significant digits.
fn decimals_of(error: f64) -> usize {
    (1 - error.log10().floor() as i32).clamp(0, MOST_DECIMALS) as usize
}

/// The number with a true minus sign, and none before zero.
fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let zero = text.chars().all(|c| "-0.".contains(c));
    if zero { text.replace('-', "") } else { text.replace('-', "−") }
}

/// Factor that turns a standard error of `degrees` degrees of freedom into a 95 % interval
/// (Student's t); `None` for no degrees of freedom.
pub fn coverage_factor_95(degrees: usize) -> Option<f64> {
    let law = StudentsT::new(0.0, 1.0, degrees as f64).ok()?;
    Some(law.inverse_cdf(0.975))
}

/// Jackknife covariance (n − 1)/n Σ_r (x_r − x̄)(x_r − x̄)ᵀ of a statistic from its n leave-one-out
/// replicates (Efron & Stein 1981); for a mean it is exactly the square of s/√n. `None` for fewer
/// than two.
pub fn jackknife_covariance<const N: usize>(replicates: &[[f64; N]]) -> Option<[[f64; N]; N]> {
    let n = replicates.len() as f64;
    if replicates.len() < 2 {
        return None;
    }
    let mean: [f64; N] = std::array::from_fn(|i| replicates.iter().map(|x| x[i]).sum::<f64>() / n);
    let entry = |i: usize, j: usize| {
        let products = replicates.iter().map(|x| (x[i] - mean[i]) * (x[j] - mean[j]));
        products.sum::<f64>() * (n - 1.0) / n
    };
    Some(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}

/// Contributions of the samples to the variance of a statistic, √((n − 1)/n) (x̄ − x_r) of its n
/// leave-one-out replicates. Sums of products of these deviations give [`jackknife_covariance`],
/// and, for two statistics of the same samples, the covariance between them. Empty for fewer than
/// two replicates.
pub fn jackknife_deviations<const N: usize>(replicates: &[[f64; N]]) -> Vec<[f64; N]> {
    let n = replicates.len() as f64;
    if replicates.len() < 2 {
        return Vec::new();
    }
    let mean: [f64; N] = std::array::from_fn(|i| replicates.iter().map(|x| x[i]).sum::<f64>() / n);
    let scale = ((n - 1.0) / n).sqrt();
    replicates.iter().map(|x| std::array::from_fn(|i| scale * (mean[i] - x[i]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jackknife_of_a_mean_is_its_standard_error() {
        let samples = [0.3, 1.7, -0.4, 2.2, 0.9];
        let sum: f64 = samples.iter().sum();
        let replicates = samples.map(|x| (sum - x) / (samples.len() - 1) as f64);
        let direct = Estimate::of_mean(&samples);
        let jack = Estimate::jackknife(direct.value, &replicates);
        // identity, five additions
        approx::assert_relative_eq!(
            jack.standard_error.unwrap(),
            direct.standard_error.unwrap(),
            max_relative = 1e-14
        );
    }

    #[test]
    fn numbers_are_rounded_to_their_error() {
        let words = |value: f64, error: f64| Estimate { value, standard_error: Some(error) }.in_words(2);
        assert_eq!(words(35.5520, 0.5568), "35.55 ± 0.56");
        assert_eq!(words(-0.012345, 0.00123), "−0.0123 ± 0.0012");
        assert_eq!(words(1234.5, 67.8), "1234 ± 68");
        assert_eq!(words(-0.0004, 0.03), "0.000 ± 0.030");
        assert_eq!(words(-7.0, 0.0), "−7.00");
        assert_eq!(Estimate::unknown_error(0.12345).in_words(3), "0.123");
    }

    #[test]
    fn intervals_follow_students_law() {
        // tables: t(0.975; 1) = 12.706, t(0.975; 23) = 2.069
        assert!((coverage_factor_95(1).unwrap() - 12.706).abs() < 1e-3);
        assert!((coverage_factor_95(23).unwrap() - 2.069).abs() < 1e-3);
        assert_eq!(coverage_factor_95(0), None);
    }

    #[test]
    fn one_sample_leaves_the_error_unknown() {
        assert_eq!(Estimate::of_mean(&[0.4]), Estimate { value: 0.4, standard_error: None });
        assert_eq!(Estimate::jackknife(0.4, &[0.4]).standard_error, None);
        assert_eq!(Estimate::of_mean(&[]), Estimate { value: 0.0, standard_error: None });
        assert!(jackknife_deviations(&[[0.4]]).is_empty());
    }
}
