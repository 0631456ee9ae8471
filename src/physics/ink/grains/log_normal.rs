//! Log-normal size distributions, by number or by volume.
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

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// 90th percentile of the standard normal distribution.
pub(super) const TENTH: f64 = 1.281_551_565_544_600_4;
/// Truncation of a distribution given by percentiles, in standard deviations.
pub(super) const CUT_AT: f64 = 3.0;

/// Weighting of a size distribution: by number of grains, or by volume, as particle sizers report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum By {
    /// By number: all grains have equal weight.
    Number,
    /// By volume: grains are weighted with their volume.
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
        match by {
            By::Number => Self { median_nm, sigma, cut, middle: 0.0 },
            By::Volume => {
                let median_nm = median_nm * (-3.0 * sigma * sigma).exp();
                Self { median_nm, sigma, cut, middle: 3.0 * sigma }
            }
        }
    }

    /// Deviation σ of the distribution with these d10 and d90.
    pub fn sigma_of([d10, d90]: [f64; 2]) -> f64 {
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
        let (s, normal) = (3.0 * self.sigma, Normal::standard());
        let [low, high] = [self.middle - self.cut - s, self.middle + self.cut - s];
        let within = normal.cdf(high) - normal.cdf(low);
        self.median_nm.powi(3) * (0.5 * s * s).exp() * within / kept(self.cut, self.middle)
    }
}

/// Fraction of a normal distribution within `cut` standard deviations of `middle`.
pub(super) fn kept(cut: f64, middle: f64) -> f64 {
    let cdf = |x: f64| Normal::standard().cdf(x);
    if middle == 0.0 { 1.0 - 2.0 * cdf(-cut) } else { cdf(cut - middle) - cdf(-cut - middle) }
}

/// Quantile of the normal distribution truncated at `cut` standard deviations from `middle`.
pub(super) fn cut_quantile(share: f64, cut: f64, middle: f64) -> f64 {
    let normal = Normal::standard();
    let [low, high] = [middle - cut, middle + cut];
    // computed in the nearer tail to avoid cancellation
    let z = if middle == 0.0 && share < 0.5 {
        normal.inverse_cdf(normal.cdf(low) + share * kept(cut, middle))
    } else {
        -normal.inverse_cdf(normal.cdf(-high) + (1.0 - share) * kept(cut, middle))
    };
    z.clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::grains::size::{Measure, SizeDistribution};

    /// Quantile of the sizes by number or by volume, from many evenly spaced quantiles.
    fn reached(law: &SizeDistribution, share: f64, power: i32) -> f64 {
        let steps = 400_000;
        let sizes: Vec<f64> =
            (0..steps).map(|i| law.quantile_nm((i as f64 + 0.5) / f64::from(steps))).collect();
        let mut left = share * sizes.iter().map(|d| d.powi(power)).sum::<f64>();
        let below = |d: &&f64| {
            left -= d.powi(power);
            left < 0.0
        };
        *sizes.iter().find(below).unwrap()
    }

    /// The grains' volumes reproduce d10, d50 and d90 as given, and their number the percentiles of
    /// Hatch and Choate.
    /// *Planted*: percentiles by volume taken for those by number differ by 3σ² = 0.69 in ln(size).
    #[test]
    fn percentiles_come_back_by_volume_and_by_number() {
        let of = Measure::EffectiveDiameter;
        let [d10_nm, d50_nm, d90_nm] = [108.0, 200.0, 370.0];
        let sigma = LogNormalLaw::sigma_of([d10_nm, d90_nm]);
        for (by, power, other) in [(By::Volume, 3, -1.0), (By::Number, 0, 1.0)] {
            let laws = [
                SizeDistribution::Percentiles { d10_nm, d50_nm, d90_nm, by, of },
                SizeDistribution::LogNormal { median_nm: d50_nm, sigma, by, cut_at_sigmas: 3.0, of },
            ];
            for law in laws {
                for (share, want) in [(0.1, d10_nm), (0.5, d50_nm), (0.9, d90_nm)] {
                    let got = reached(&law, share, power);
                    // truncation at three deviations shifts d10 and d90 by 0.4 % of a deviation
                    assert!((got / want - 1.0).abs() < 4e-3, "{law:?}: {got} {want}");
                }
                let shifted = d50_nm * (other * 3.0 * sigma * sigma).exp();
                let got = reached(&law, 0.5, 3 - power);
                // truncated by the other weighting: sizes beyond 3 − 3σ deviations are missing
                assert!((got / shifted).ln().abs() < 0.12 * 3.0 * sigma * sigma, "{law:?}: {got} {shifted}");
            }
        }
        assert!((sigma * sigma * 3.0 - 0.69).abs() < 0.01, "{sigma}");
    }
}
