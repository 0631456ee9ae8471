//! A number with its standard error, the jackknife for statistics that are not linear, and sums of
//! correlated numbers of the same realisations.

use statrs::distribution::{ContinuousCDF, StudentsT};
use std::collections::BTreeMap;

/// A value and its standard error (one standard deviation of the value). The error is `None`, not
/// zero, where a single realisation leaves it unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// to match, to at most six decimals. The value alone if the error is less than that: with
    /// `decimals` if the error is unknown, zero or rounding, else with six digits or `decimals`;
    /// empty for NaN.
    pub fn in_words(&self, decimals: usize) -> String {
        if !self.value.is_finite() {
            return String::new();
        }
        let rounding = (ROUNDING * self.value.abs()).max(LEAST_ERROR);
        let error = self.standard_error.filter(|error| error.is_finite() && *error > rounding);
        let Some(error) = error else { return signed(self.value, decimals) };
        // an error with two significant digits
        let needed = 1 - error.log10().floor() as i32;
        if needed > MOST_DECIMALS && error < 0.5 * 10f64.powi(-MOST_DECIMALS) {
            return signed(self.value, decimals.max(self.decimals_of_six_digits()));
        }
        let decimals = needed.clamp(0, MOST_DECIMALS) as usize;
        format!("{} ± {error:.decimals$}", signed(self.value, decimals))
    }

    /// Decimals with which the value has six significant digits, at most as many as are displayed.
    fn decimals_of_six_digits(&self) -> usize {
        let digits = MOST_DECIMALS - 1 - self.value.abs().max(f64::MIN_POSITIVE).log10().floor() as i32;
        digits.clamp(0, MOST_DECIMALS) as usize
    }
}

/// Errors that are smaller, relative to the value or at all, are rounding.
const ROUNDING: f64 = 1e-9;
const LEAST_ERROR: f64 = 1e-12;
/// Largest number of decimals displayed: no number that is published is known to more.
const MOST_DECIMALS: i32 = 6;

/// The number with a true minus sign, and none before zero.
fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.chars().all(|c| "-0.".contains(c)) { text.replace('-', "") } else { text.replace('-', "−") }
}

/// Factor that turns a standard error of `degrees` degrees of freedom into a 95 % interval
/// (Student's t); `None` for no degrees of freedom.
pub fn coverage_factor_95(degrees: usize) -> Option<f64> {
    StudentsT::new(0.0, 1.0, degrees as f64).ok().map(|law| law.inverse_cdf(0.975))
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

/// A statistic of an ensemble with the contribution of each realisation
/// ([`jackknife_deviations`]). Any further part of its standard error is independent of all others.
#[derive(Clone, Debug, PartialEq)]
pub struct Linked {
    /// The value with its standard error.
    pub estimate: Estimate,
    /// Deviations by number of the realisation.
    pub deviations: BTreeMap<usize, f64>,
}

impl Linked {
    /// Σ weight · number. Shared realisations move several terms together; the others contribute
    /// independently. The error is unknown if that of any term is.
    ///
    /// ```
    /// use inkwave_numerics::estimate::{Estimate, Linked};
    /// let number = |value: f64| Linked {
    ///     estimate: Estimate { value, standard_error: Some(5.0) },
    ///     deviations: [(0, 3.0), (1, -4.0)].into(),
    /// };
    /// // two inks in the same packings: the packings cancel in their difference
    /// let difference = Linked::sum([(1.0, &number(40.0)), (-1.0, &number(30.0))]);
    /// assert_eq!(difference.estimate, Estimate { value: 10.0, standard_error: Some(0.0) });
    /// ```
    pub fn sum<'a>(terms: impl IntoIterator<Item = (f64, &'a Linked)>) -> Linked {
        let mut value = 0.0;
        let mut own = Some(0.0);
        let mut deviations = BTreeMap::new();
        for (weight, term) in terms {
            value += weight * term.estimate.value;
            own = own.zip(term.own_variance()).map(|(sum, one)| sum + weight * weight * one);
            for (&realisation, by) in &term.deviations {
                *deviations.entry(realisation).or_insert(0.0) += weight * by;
            }
        }
        let mut sum = Linked { estimate: Estimate::unknown_error(value), deviations };
        sum.estimate.standard_error = own.map(|own| (own + sum.chance_variance()).sqrt());
        sum
    }

    /// Variance due to the realisations.
    pub fn chance_variance(&self) -> f64 {
        self.deviations.values().map(|by| by * by).sum()
    }

    /// Variance beyond that of the realisations.
    fn own_variance(&self) -> Option<f64> {
        self.estimate.standard_error.map(|error| (error * error - self.chance_variance()).max(0.0))
    }
}

/// The largest of some numbers, NaN if any of them is NaN; 0 if there are none.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a: f64, b: f64| if a.is_nan() || a > b { a } else { b })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Draws;

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
        // *Planted*: twelve decimals
        assert_eq!(words(0.2144, 3.1e-8), "0.214400");
        assert_eq!(words(1e-5, 1e-11), "0.000010");
        assert_eq!(words(35.552, 4e-8), "35.5520");
        assert_eq!(words(0.2144, 1.4e-6), "0.214400 ± 0.000001");
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

    /// A mean of samples, as an ensemble gives it.
    fn mean(samples: &[f64]) -> Linked {
        let n = samples.len() as f64;
        let sum = samples.iter().sum::<f64>();
        let replicates: Vec<[f64; 1]> = samples.iter().map(|x| [(sum - x) / (n - 1.0)]).collect();
        let deviations = jackknife_deviations(&replicates).into_iter().map(|[by]| by);
        Linked { estimate: Estimate::of_mean(samples), deviations: deviations.enumerate().collect() }
    }

    #[test]
    fn the_error_of_a_difference_is_that_of_paired_samples() {
        let mut draws = Draws::new(5, 0);
        let a: Vec<f64> = (0..12).map(|_| draws.uniform()).collect();
        let b: Vec<f64> = a.iter().map(|x| 0.9 * x + 0.05 * draws.uniform()).collect();
        let paired: Vec<f64> = a.iter().zip(&b).map(|(x, y)| x - y).collect();
        let (found, wanted) =
            (Linked::sum([(1.0, &mean(&a)), (-1.0, &mean(&b))]), Estimate::of_mean(&paired));
        let error = |e: Estimate| e.standard_error.unwrap();
        // an identity; some thirty additions
        approx::assert_relative_eq!(error(found.estimate), error(wanted), max_relative = 1e-12);
        let apart = error(mean(&a).estimate).hypot(error(mean(&b).estimate));
        assert!(error(found.estimate) < 0.2 * apart);
    }

    #[test]
    fn what_two_numbers_do_not_share_adds_as_squares() {
        let one = |key: usize, error: f64| Linked {
            estimate: Estimate { value: 1.0, standard_error: Some(error) },
            deviations: [(key, 3.0)].into(),
        };
        let sum = Linked::sum([(1.0, &one(0, 5.0)), (1.0, &one(1, 3.0))]);
        // 3² + 3² by chance, 4² of the first one's own
        assert_eq!(sum.estimate.standard_error, Some(34.0_f64.sqrt()));
        let unknown = Linked { estimate: Estimate::unknown_error(1.0), deviations: BTreeMap::new() };
        assert_eq!(Linked::sum([(1.0, &one(0, 5.0)), (1.0, &unknown)]).estimate.standard_error, None);
    }

    #[test]
    fn maxima_keep_what_is_no_number() {
        assert!(largest([1.0, f64::NAN, 2.0]).is_nan() && largest([f64::NAN]).is_nan());
        assert_eq!((largest([1.0, 3.0, 2.0]), largest([])), (3.0, 0.0));
    }
}
