//! Achieved sizes: percentiles of the packed grains, as particle sizers report them.

use crate::ink::{Method, Packing};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Fractions of the grains below d10, d50 and d90.
const SHARES: [f64; 3] = [0.1, 0.5, 0.9];

/// d10, d50 and d90 of the effective diameters of packed grains, nm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReachedSizes {
    /// Percentiles by number of grains.
    pub by_number_nm: [f64; 3],
    /// Percentiles by volume.
    pub by_volume_nm: [f64; 3],
}

impl ReachedSizes {
    /// Percentiles of one pigment's grains; `None` without grains, and of voxels.
    pub fn of(packing: &Packing, pigment: usize) -> Option<Self> {
        let counts = packing.method() != Method::Voxels;
        let grains = packing.grains().iter().filter(|grain| counts && grain.pigment == pigment);
        Self::of_volumes(grains.map(|grain| grain.volume_um3).collect())
    }

    fn of_volumes(mut um3: Vec<f64>) -> Option<Self> {
        um3.sort_by(f64::total_cmp);
        (!um3.is_empty()).then(|| Self {
            by_number_nm: SHARES.map(|share| percentile_nm(&um3, share, |_| 1.0)),
            by_volume_nm: SHARES.map(|share| percentile_nm(&um3, share, |volume| volume)),
        })
    }

    /// Display of both sets of percentiles.
    pub fn in_words(&self) -> String {
        let listed = |[d10, d50, d90]: [f64; 3]| format!("{d10:.0}, {d50:.0}, {d90:.0} nm");
        format!("{} by number; {} by volume", listed(self.by_number_nm), listed(self.by_volume_nm))
    }
}

/// Weighted quantile of the effective diameters, nm: each grain is placed at the middle of its own
/// weight, with linear interpolation between grains.
fn percentile_nm(um3: &[f64], share: f64, weight: fn(f64) -> f64) -> f64 {
    let diameter = |volume: f64| 1e3 * (6.0 * volume / PI).cbrt();
    let wanted = share * um3.iter().map(|v| weight(*v)).sum::<f64>();
    let (mut below, mut last) = (0.0, None);
    for &volume in um3 {
        let (middle, here) = (below + 0.5 * weight(volume), diameter(volume));
        if middle >= wanted {
            return last.map_or(here, |(at, d): (f64, f64)| d + (here - d) * (wanted - at) / (middle - at));
        }
        (below, last) = (below + weight(volume), Some((middle, here)));
    }
    last.map_or(0.0, |(_, d)| d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{By, Measure, SizeDistribution};
    use crate::numerics::Draws;

    /// Grains drawn by volume have the requested percentiles by volume, and those of Hatch and
    /// Choate by number. *Planted*: numbers for volumes.
    #[test]
    fn packed_sizes_have_the_percentiles_asked_for() {
        let (d10_nm, d50_nm, d90_nm, of) = (154.8, 200.0, 258.4, Measure::EffectiveDiameter);
        let law = SizeDistribution::Percentiles { d10_nm, d50_nm, d90_nm, by: By::Volume, of };
        let sizes = law.strata_nm(4000, &mut Draws::new(3, 0));
        let volumes = sizes.iter().map(|nm| PI / 6.0 * (1e-3 * nm).powi(3)).collect();
        let reached = ReachedSizes::of_volumes(volumes).unwrap();
        for (got, want) in reached.by_volume_nm.iter().zip([d10_nm, d50_nm, d90_nm]) {
            // truncation at three deviations, and steps of 4000 grains
            assert!((got / want - 1.0).abs() < 5e-3, "{reached:?}");
        }
        // σ = 0.2: the median by number is e^{−0.12} of that by volume
        assert!((reached.by_number_nm[1] / 177.4 - 1.0).abs() < 0.01, "{reached:?}");
        assert!(reached.in_words().ends_with("by volume") && ReachedSizes::of_volumes(Vec::new()).is_none());
    }
}
