//! Log-normal laws of sizes, by number or by volume.
//!
//! A law that is log-normal by number with median m and deviation σ of ln(size) is log-normal by volume as well, with the
//! same σ and the median (T. Hatch and S. P. Choate, J. Franklin Inst. 207, 369–387, 1929)
//!
//! ```text
//! ln m_V = ln m_N + 3 σ²
//! ```
//!
//! A deviation z by number is then z − 3σ by volume, so that a cut at ± c by volume lies at 3σ ± c by number.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Deviations of the normal law that a tenth lies beyond.
pub(super) const TENTH: f64 = 1.281_551_565_544_600_4;
/// Cut of a law through percentiles, deviations.
pub(super) const CUT_AT: f64 = 3.0;

/// What a law of sizes counts: grains, or their volume, as sizers print it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum By {
    /// Every grain counts alike.
    Number,
    /// Every grain counts by its volume.
    Volume,
}

/// A log-normal law with its cut, by number.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogNormalLaw {
    /// Median by number before the cut, nm.
    median_nm: f64,
    /// Deviation of ln(size).
    sigma: f64,
    /// Half of the width between the cuts, deviations.
    cut: f64,
    /// Middle between the cuts, deviations by number: 0, or 3σ where the law is cut by volume.
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

    /// σ of the law with these d10 and d90.
    pub fn sigma_of([d10, d90]: [f64; 2]) -> f64 {
        (d90 / d10).ln() / (2.0 * TENTH)
    }

    pub fn has_spread(&self) -> bool {
        self.sigma > 0.0
    }

    pub fn largest_nm(&self) -> f64 {
        self.at(self.middle + self.cut)
    }

    /// The size at a deviation by number, nm.
    fn at(&self, deviations: f64) -> f64 {
        self.median_nm * (self.sigma * deviations).exp()
    }

    /// The size that a share (0–1) of all grains stays below, nm.
    pub fn quantile_nm(&self, share: f64) -> f64 {
        let normal = Normal::standard();
        let [low, high] = [self.middle - self.cut, self.middle + self.cut];
        // from the nearer tail: the far one has no digits left
        let z = if self.middle == 0.0 && share < 0.5 {
            normal.inverse_cdf(normal.cdf(low) + share * self.kept())
        } else {
            -normal.inverse_cdf(normal.cdf(-high) + (1.0 - share) * self.kept())
        };
        self.at(z.clamp(low, high))
    }

    /// Mean of the cube of the size over the grains, by number, nm³: ∫ e^{sz} φ(z) dz = e^{s²/2} ∫ φ(z − s) dz with s = 3σ.
    pub fn mean_cube_nm3(&self) -> f64 {
        let (s, normal) = (3.0 * self.sigma, Normal::standard());
        let [low, high] = [self.middle - self.cut - s, self.middle + self.cut - s];
        self.median_nm.powi(3) * (0.5 * s * s).exp() * (normal.cdf(high) - normal.cdf(low)) / self.kept()
    }

    /// Share of the number of grains between the cuts.
    fn kept(&self) -> f64 {
        let cdf = |x: f64| Normal::standard().cdf(x);
        if self.middle == 0.0 {
            return 1.0 - 2.0 * cdf(-self.cut);
        }
        cdf(self.cut - self.middle) - cdf(-self.cut - self.middle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::grains::size::{Measure, SizeDistribution};

    /// Size that a share of the number or of the volume stays below, from many even quantiles.
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

    /// d10, d50 and d90 as a sizer prints them come back from the grains' volumes, and by number those of Hatch and Choate.
    /// *Planted*: percentiles by volume taken for those by number are 3σ² = 0.69 off in ln(size).
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
                    // the cut at three deviations moves tenths by 0.4 % of a deviation
                    assert!((got / want - 1.0).abs() < 4e-3, "{law:?}: {got} {want}");
                }
                let shifted = d50_nm * (other * 3.0 * sigma * sigma).exp();
                let got = reached(&law, 0.5, 3 - power);
                // the cut is that of the other count: what lies beyond 3 − 3σ deviations is missing from this one
                assert!((got / shifted).ln().abs() < 0.12 * 3.0 * sigma * sigma, "{law:?}: {got} {shifted}");
            }
        }
        assert!((sigma * sigma * 3.0 - 0.69).abs() < 0.01, "{sigma}");
    }
}
