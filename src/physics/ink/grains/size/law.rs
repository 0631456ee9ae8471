//! Quantiles of size distributions and stratified samples of them: one size from each of n equal
//! fractions.
//!
//! A distribution that is log-normal by number with median m and deviation σ of ln(size) is
//! log-normal by volume as well, with the same σ and the median (T. Hatch and S. P. Choate, J.
//! Franklin Inst. 207, 369–387, 1929)
//!
//! ```text
//! ln m_V = ln m_N + 3 σ²
//! ```
//!
//! A standardised deviation z by number is then z − 3σ by volume, so that truncation at ± c by
//! volume lies at 3σ ± c by number.

use super::SizeDistribution;
use crate::numerics::{Draws, weighted};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// 90th percentile of the standard normal distribution.
pub(super) const TENTH: f64 = 1.281_551_565_544_600_4;
/// Truncation of a distribution given by percentiles, in standard deviations.
pub(super) const CUT_AT: f64 = 3.0;

/// Weighting of a size distribution: by number of grains, or by volume, as particle sizers report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum By {
    /// By number: all grains have equal weight.
    Number,
    /// By volume: grains are weighted with their volume.
    #[default]
    Volume,
}

/// A truncated log-normal distribution, by number.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogNormalLaw {
    /// Median by number before truncation, nm.
    median_nm: f64,
    /// Standard deviation of ln(size).
    pub sigma: f64,
    /// Half-width of the truncated range, in standard deviations.
    cut: f64,
    /// Centre of the truncated range, in standard deviations by number: 0, or 3σ for truncation by
    /// volume.
    middle: f64,
}

impl LogNormalLaw {
    pub fn new(median_nm: f64, sigma: f64, by: By, cut: f64) -> Self {
        let (factor, middle) = match by {
            By::Number => (1.0, 0.0),
            By::Volume => ((-3.0 * sigma * sigma).exp(), 3.0 * sigma),
        };
        Self { median_nm: median_nm * factor, sigma, cut, middle }
    }

    /// Deviation σ of the distribution with these d10 and d90.
    pub fn sigma_of(d10: f64, d90: f64) -> f64 {
        (d90 / d10).ln() / (2.0 * TENTH)
    }

    pub fn largest_nm(&self) -> f64 {
        self.at(self.middle + self.cut)
    }

    /// Size at a standardised deviation by number, nm.
    fn at(&self, deviations: f64) -> f64 {
        self.median_nm * (self.sigma * deviations).exp()
    }

    /// Quantile of the sizes at a fraction (0–1) of all grains, nm.
    pub fn quantile_nm(&self, share: f64) -> f64 {
        self.at(cut_quantile(share, self.cut, self.middle))
    }

    /// Number mean of the cubed size, nm³: ∫ e^{sz} φ(z) dz = e^{s²/2} ∫ φ(z − s) dz with s = 3σ.
    pub fn mean_cube_nm3(&self) -> f64 {
        let s = 3.0 * self.sigma;
        let normal = Normal::standard();
        let low = self.middle - self.cut - s;
        let high = self.middle + self.cut - s;
        let within = normal.cdf(high) - normal.cdf(low);
        self.median_nm.powi(3) * (0.5 * s * s).exp() * within / kept(self.cut, self.middle)
    }
}

/// Fraction of a normal distribution within `cut` standard deviations of `middle`.
fn kept(cut: f64, middle: f64) -> f64 {
    let cdf = |x: f64| Normal::standard().cdf(x);
    if middle == 0.0 { 1.0 - 2.0 * cdf(-cut) } else { cdf(cut - middle) - cdf(-cut - middle) }
}

/// Quantile of the normal distribution truncated at `cut` standard deviations from `middle`.
pub(super) fn cut_quantile(share: f64, cut: f64, middle: f64) -> f64 {
    let normal = Normal::standard();
    let low = middle - cut;
    let high = middle + cut;
    // computed in the nearer tail to avoid cancellation
    let z = if middle == 0.0 && share < 0.5 {
        normal.inverse_cdf(normal.cdf(low) + share * kept(cut, middle))
    } else {
        -normal.inverse_cdf(normal.cdf(-high) + (1.0 - share) * kept(cut, middle))
    };
    z.clamp(low, high)
}

impl SizeDistribution {
    /// Whether grain sizes vary.
    pub fn has_spread(&self) -> bool {
        match self {
            Self::Constant { .. } => false,
            Self::Normal { standard_deviation_nm, .. } => *standard_deviation_nm > 0.0,
            Self::LogNormal { .. } | Self::Percentiles { .. } => self.log_normal().sigma > 0.0,
            Self::List { values_nm, weights, .. } => {
                let drawn = (0..values_nm.len()).filter(|&i| weights.get(i).is_none_or(|w| *w > 0.0));
                let mut sizes = drawn.map(|i| values_nm[i]);
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
