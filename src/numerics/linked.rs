//! Correlated numbers of the same realisations: their sums and differences with standard errors.

use super::estimate::Estimate;
use std::collections::BTreeMap;

/// A statistic of an ensemble with the contribution of each realisation
/// ([`jackknife_deviations`](super::estimate::jackknife_deviations)). Any further part of its
/// standard error is independent of all others.
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
    /// use inkwave_physics::numerics::{Estimate, linked::Linked};
    /// let number = |value: f64| Linked {
    ///     estimate: Estimate { value, standard_error: Some(5.0) },
    ///     deviations: [(0, 3.0), (1, -4.0)].into(),
    /// };
    /// // two inks in the same packings: the packings cancel in their difference
    /// let difference = Linked::sum([(1.0, &number(40.0)), (-1.0, &number(30.0))]);
    /// assert_eq!(difference.estimate, Estimate { value: 10.0, standard_error: Some(0.0) });
    /// ```
    pub fn sum<'a>(terms: impl IntoIterator<Item = (f64, &'a Linked)>) -> Linked {
        let (mut value, mut own) = (0.0, Some(0.0));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Draws;
    use crate::estimate::jackknife_deviations;

    /// A mean of samples, as an ensemble gives it.
    fn mean(samples: &[f64]) -> Linked {
        let (n, sum) = (samples.len() as f64, samples.iter().sum::<f64>());
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
}
