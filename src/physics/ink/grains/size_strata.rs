//! Stratified samples of a size distribution: one size from each of n equal fractions of it.

use super::log_normal::{cut_quantile, kept};
use super::size::SizeDistribution;
use crate::numerics::draws::{Draws, weighted};
use statrs::distribution::{Continuous, Normal};

impl SizeDistribution {
    /// Whether grain sizes vary.
    pub fn has_spread(&self) -> bool {
        match self {
            Self::Constant { .. } => false,
            Self::Normal { standard_deviation_nm, .. } => *standard_deviation_nm > 0.0,
            Self::LogNormal { .. } | Self::Percentiles { .. } => self.log_normal().sigma > 0.0,
            Self::List { values_nm, weights, .. } => {
                let drawn = |i: usize| weights.is_empty() || weights[i] > 0.0;
                let mut sizes = (0..values_nm.len()).filter(|&i| drawn(i)).map(|i| values_nm[i]);
                let first = sizes.next();
                sizes.any(|size| Some(size) != first)
            }
        }
    }

    /// Number mean of the cubed size, nm³: proportional to the mean volume of a shape.
    pub fn mean_cube_nm3(&self) -> f64 {
        match self {
            Self::Constant { value_nm, .. } => value_nm.powi(3),
            Self::Normal { mean_nm, standard_deviation_nm: s, cut_at_sigmas: c, .. } => {
                // E z² of a normal distribution truncated at ±c; odd powers vanish
                let square = 1.0 - 2.0 * c * Normal::standard().pdf(*c) / kept(*c, 0.0);
                mean_nm.powi(3) + 3.0 * mean_nm * s * s * square
            }
            Self::LogNormal { .. } | Self::Percentiles { .. } => self.log_normal().mean_cube_nm3(),
            Self::List { values_nm, weights, .. } => {
                let weight = |i: usize| if weights.is_empty() { 1.0 } else { weights[i] };
                let cubes = values_nm.iter().enumerate().map(|(i, v)| weight(i) * v.powi(3));
                cubes.sum::<f64>() / (0..values_nm.len()).map(weight).sum::<f64>()
            }
        }
    }

    /// Quantile of the sizes at a fraction (0–1) of all grains, nm; for a list, in its order.
    pub fn quantile_nm(&self, share: f64) -> f64 {
        match self {
            Self::Constant { value_nm, .. } => *value_nm,
            Self::Normal { mean_nm, standard_deviation_nm, cut_at_sigmas, .. } => {
                mean_nm + standard_deviation_nm * cut_quantile(share, *cut_at_sigmas, 0.0)
            }
            Self::LogNormal { .. } | Self::Percentiles { .. } => self.log_normal().quantile_nm(share),
            Self::List { values_nm, weights, .. } => weighted(values_nm, weights, share),
        }
    }

    /// A stratified sample of `count` sizes in random order, nm: one from each of `count` equal
    /// fractions of the distribution. The mean of any function of them is unbiased, with a smaller
    /// variance than for independent draws.
    pub fn strata_nm(&self, count: usize, draws: &mut Draws) -> Vec<f64> {
        let size = |i: usize| self.quantile_nm((i as f64 + draws.uniform()) / count as f64);
        let mut sizes: Vec<f64> = (0..count).map(size).collect();
        // Random order, because agglomerates take grains in sequence.
        draws.shuffle(&mut sizes);
        sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::grains::size::{By, Measure};

    fn laws() -> Vec<SizeDistribution> {
        let of = Measure::Radius;
        let log = |sigma, cut_at_sigmas| SizeDistribution::LogNormal {
            median_nm: 90.0,
            sigma,
            by: By::Number,
            cut_at_sigmas,
            of,
        };
        let volume = |sigma, cut_at_sigmas| SizeDistribution::LogNormal {
            median_nm: 90.0,
            sigma,
            by: By::Volume,
            cut_at_sigmas,
            of,
        };
        let normal = |standard_deviation_nm, cut_at_sigmas| SizeDistribution::Normal {
            mean_nm: 100.0,
            standard_deviation_nm,
            cut_at_sigmas,
            of,
        };
        let list = |weights| SizeDistribution::List { values_nm: vec![300.0, 100.0, 200.0], weights, of };
        vec![
            log(0.5, 3.0),
            log(0.2, 10.0),
            log(1.0, 0.5),
            volume(0.3, 3.0),
            volume(0.5, 2.0),
            normal(20.0, 3.0),
            normal(9.0, 10.0),
            normal(60.0, 0.5),
            list(Vec::new()),
            list(vec![1.0, 0.0, 2.0]),
        ]
    }

    #[test]
    fn means_of_cubes_are_those_of_the_quantiles_and_of_the_draws() {
        for law in laws() {
            let steps = 300_000;
            let cubes = (0..steps).map(|i| law.quantile_nm((i as f64 + 0.5) / f64::from(steps)).powi(3));
            let by_quantiles = cubes.sum::<f64>() / f64::from(steps);
            // order: the midpoint rule of steps that are steep at the ends of the law
            assert!((law.mean_cube_nm3() / by_quantiles - 1.0).abs() < 1e-4, "{law:?}");
            let mut draws = Draws::new(2, 0);
            let drawn: Vec<f64> = (0..20_000).map(|_| law.draw_nm(&mut draws).powi(3)).collect();
            let drawn = crate::numerics::estimate::Estimate::of_mean(&drawn);
            let sigmas = (drawn.value - law.mean_cube_nm3()) / drawn.standard_error.unwrap();
            // Significance: four standard errors.
            assert!(sigmas.abs() < 4.0, "{law:?}: {sigmas}");
        }
    }

    #[test]
    fn every_share_of_the_law_gives_one_size() {
        for law in laws() {
            let mut sizes = law.strata_nm(12, &mut Draws::new(2, 0));
            let ends = |i: usize| [i, i + 1].map(|i| law.quantile_nm(i as f64 / 12.0));
            if matches!(law, SizeDistribution::List { .. }) {
                let hundreds = sizes.iter().filter(|s| **s == 300.0).count();
                assert_eq!(hundreds, 4, "{law:?}");
                continue;
            }
            sizes.sort_by(f64::total_cmp);
            for (i, size) in sizes.iter().enumerate() {
                let [from, to] = ends(i);
                assert!((from..=to).contains(size), "{law:?}: {size} {from} {to}");
            }
            let end = law.quantile_nm(1.0) / law.largest_nm();
            // order: the digits of the inverse in a tail of 1e-23, where the law is cut at ten
            // deviations
            assert!((end - 1.0).abs() < 1e-4, "{law:?}: {end}");
        }
    }
}
