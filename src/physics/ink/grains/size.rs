//! Size distributions of grains, truncated so that the size of the largest grain is known.

mod law;

pub use law::By;

use super::shape::Template;
use crate::numerics::allowed::Allowed;
#[cfg(feature = "schema")]
use crate::numerics::allowed::Each;
#[cfg(feature = "serde")]
use crate::numerics::files::ratio;
use crate::numerics::{Draws, are_weights};
use law::{CUT_AT, LogNormalLaw, TENTH};

/// A size of grains.
const SIZE_NM: Allowed = Allowed::above(0.0, f64::MAX, "nm");
/// Sizes of grains.
#[cfg(feature = "schema")]
const SIZES_NM: Each<Allowed> = Each { entry: SIZE_NM, most: usize::MAX >> 12 };
/// Standard deviation of sizes.
const SPREAD_NM: Allowed = Allowed::between(0.0, f64::MAX, "nm");
/// Standard deviation of ln(size).
const SIGMA: Allowed = Allowed::between(0.0, 2.0, "");
/// Truncation in standard deviations.
const CUT: Allowed = Allowed::above(0.0, 10.0, "");

/// Tolerated deviation of d10 and d90 from a log-normal distribution through d50: particle sizers
/// differ by as much.
const SKEW: f64 = 0.05;

/// Length of the grain that a size specifies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Measure {
    /// Diameter of the sphere of equal volume, of the **union** for grains of several spheres (P1
    /// section 5 calls it the effective diameter).
    #[default]
    EffectiveDiameter,
    /// Radius of the thickest sphere; of a convex body half of its `length`.
    Radius,
    /// Tip-to-tip length along the axis; of a convex body its longest axis, diameter or edge.
    Length,
}

/// Distribution of a pigment's grain sizes, by number unless `by` says otherwise. `of` selects the
/// length.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum SizeDistribution {
    /// One size for all grains.
    Constant {
        /// The size, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZE_NM.mark(), example = 250))]
        value_nm: f64,
        /// Length that the size specifies.
        #[cfg_attr(feature = "serde", serde(default))]
        of: Measure,
    },
    /// Normal distribution truncated at ± `cut_at_sigmas` (default 3) standard deviations.
    Normal {
        /// Mean size, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZE_NM.mark(), example = 250))]
        mean_nm: f64,
        /// Standard deviation before truncation, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SPREAD_NM.mark(), example = 30))]
        standard_deviation_nm: f64,
        /// Truncation in standard deviations, above 0 up to 10.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<3, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = CUT.mark()))]
        cut_at_sigmas: f64,
        /// Length that the size specifies.
        #[cfg_attr(feature = "serde", serde(default))]
        of: Measure,
    },
    /// Log-normal distribution: ln(size) is normal around ln(median) with deviation `sigma`,
    /// truncated at ± `cut_at_sigmas` (default 3), by number or by volume.
    LogNormal {
        /// Median size, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZE_NM.mark(), example = 250))]
        median_nm: f64,
        /// Whether median and truncation refer to the number of grains or to their volume.
        #[cfg_attr(feature = "schema", schemars(example = By::Volume))]
        by: By,
        /// Standard deviation of ln(size) before truncation, 0 to 2.
        #[cfg_attr(feature = "schema", schemars(transform = SIGMA.mark(), example = 0.2))]
        sigma: f64,
        /// Truncation in standard deviations of ln(size), above 0 up to 10.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<3, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = CUT.mark()))]
        cut_at_sigmas: f64,
        /// Length that the size specifies.
        #[cfg_attr(feature = "serde", serde(default))]
        of: Measure,
    },
    /// The log-normal distribution through these percentiles, as particle sizers report them,
    /// truncated at ± 3 standard deviations.
    Percentiles {
        /// 10th percentile of the sizes, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZE_NM.mark(), example = 150))]
        d10_nm: f64,
        /// Median of the sizes, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZE_NM.mark(), example = 200))]
        d50_nm: f64,
        /// 90th percentile of the sizes, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZE_NM.mark(), example = 266))]
        d90_nm: f64,
        /// Whether the percentiles refer to the grains' volume, as particle sizers report, or to
        /// their number.
        #[cfg_attr(feature = "serde", serde(default))]
        by: By,
        /// Length that the size specifies.
        #[cfg_attr(feature = "serde", serde(default))]
        of: Measure,
    },
    /// Listed sizes, drawn with the given weights (equal by default).
    List {
        /// The sizes, nm.
        #[cfg_attr(feature = "schema", schemars(transform = SIZES_NM.mark(), example = (200, 300)))]
        values_nm: Vec<f64>,
        /// Frequency of each size by number, at least 0; the weights are normalised.
        #[cfg_attr(feature = "serde", serde(default))]
        #[cfg_attr(feature = "schema", schemars(inner(range(min = 0)), example = (1, 2)))]
        weights: Vec<f64>,
        /// Length that the size specifies.
        #[cfg_attr(feature = "serde", serde(default))]
        of: Measure,
    },
}

impl SizeDistribution {
    /// Grains of one effective diameter.
    pub fn diameter_nm(value_nm: f64) -> Self {
        Self::Constant { value_nm, of: Measure::EffectiveDiameter }
    }

    /// The length that the sizes specify.
    pub fn measure(&self) -> Measure {
        match self {
            Self::Constant { of, .. }
            | Self::Normal { of, .. }
            | Self::LogNormal { of, .. }
            | Self::Percentiles { of, .. }
            | Self::List { of, .. } => *of,
        }
    }

    /// The first invalid number, if any: field, value found, allowed range.
    pub fn defect(&self) -> Option<(&'static str, String, &'static str)> {
        match self {
            Self::Constant { value_nm: v, .. } if !SIZE_NM.holds(*v) => {
                Some(("size.value_nm", v.to_string(), "a finite size above 0"))
            }
            Self::Normal { cut_at_sigmas: c, .. } | Self::LogNormal { cut_at_sigmas: c, .. }
                if !CUT.holds(*c) =>
            {
                Some(("size.cut_at_sigmas", c.to_string(), "above 0 up to 10"))
            }
            Self::Normal { mean_nm, standard_deviation_nm: s, cut_at_sigmas, .. }
                if !(SIZE_NM.holds(*mean_nm) && SPREAD_NM.holds(*s) && mean_nm - cut_at_sigmas * s > 0.0) =>
            {
                let found = format!("mean {mean_nm}, deviation {s}, cut at {cut_at_sigmas} sigmas");
                Some(("size", found, "mean − cut × deviation above 0: a normal law has mass at zero"))
            }
            Self::LogNormal { median_nm, sigma, .. }
                if !(SIZE_NM.holds(*median_nm) && SIGMA.holds(*sigma)) =>
            {
                let found = format!("median {median_nm}, sigma {sigma}");
                Some(("size", found, "a median above 0 and sigma from 0 to 2"))
            }
            Self::Percentiles { d10_nm, d50_nm, d90_nm, .. } => percentiles_defect(*d10_nm, *d50_nm, *d90_nm),
            Self::List { values_nm, weights, .. } => list_defect(values_nm, weights),
            _ => None,
        }
    }

    /// The underlying log-normal distribution; NaN sizes for all other distributions.
    fn log_normal(&self) -> LogNormalLaw {
        match *self {
            Self::LogNormal { median_nm, sigma, by, cut_at_sigmas, .. } => {
                LogNormalLaw::new(median_nm, sigma, by, cut_at_sigmas)
            }
            Self::Percentiles { d10_nm, d50_nm, d90_nm, by, .. } => {
                LogNormalLaw::new(d50_nm, LogNormalLaw::sigma_of(d10_nm, d90_nm), by, CUT_AT)
            }
            _ => LogNormalLaw::new(f64::NAN, 0.0, By::Number, CUT_AT),
        }
    }

    /// Largest size of the distribution, nm.
    pub fn largest_nm(&self) -> f64 {
        match self {
            Self::Constant { value_nm, .. } => *value_nm,
            Self::Normal { mean_nm, standard_deviation_nm: s, cut_at_sigmas: c, .. } => mean_nm + c * s,
            Self::LogNormal { .. } | Self::Percentiles { .. } => self.log_normal().largest_nm(),
            Self::List { values_nm, .. } => values_nm.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Smallest size of the distribution, nm.
    pub fn smallest_nm(&self) -> f64 {
        match self {
            Self::List { values_nm, .. } => values_nm.iter().copied().fold(f64::MAX, f64::min),
            law => law.quantile_nm(0.0),
        }
    }

    /// Draws one size, nm.
    pub fn draw_nm(&self, draws: &mut Draws) -> f64 {
        match self {
            Self::Constant { value_nm, .. } => *value_nm,
            Self::Normal { mean_nm, standard_deviation_nm, cut_at_sigmas, .. } => {
                mean_nm + standard_deviation_nm * cut_normal(draws, *cut_at_sigmas)
            }
            Self::LogNormal { median_nm, sigma, cut_at_sigmas, by: By::Number, .. } => {
                median_nm * (sigma * cut_normal(draws, *cut_at_sigmas)).exp()
            }
            law => law.quantile_nm(draws.uniform()),
        }
    }

    /// Thickest radius in µm of a grain of size `size_nm` with this template.
    pub fn radius_um(&self, size_nm: f64, template: &Template) -> f64 {
        let per_radius = match self.measure() {
            Measure::EffectiveDiameter => template.effective_diameter(),
            Measure::Radius => 1.0,
            Measure::Length => template.length,
        };
        size_nm * 1e-3 / per_radius
    }
}

fn percentiles_defect(d10: f64, d50: f64, d90: f64) -> Option<(&'static str, String, &'static str)> {
    let found = format!("d10 {d10}, d50 {d50}, d90 {d90} nm");
    if ![d10, d50, d90].iter().all(|d| SIZE_NM.holds(*d)) || d10 >= d50 || d50 >= d90 {
        let allowed = "d10_nm below d50_nm below d90_nm, all above 0; kind = \"constant\" for one size";
        return Some(("size", found, allowed));
    }
    let sigma = LogNormalLaw::sigma_of(d10, d90);
    if !SIGMA.holds(sigma) {
        return Some(("size", found, "a deviation ln(d90/d10)/2.56 of up to 2"));
    }
    let d10_of_law = d50 * (-TENTH * sigma).exp();
    let d90_of_law = d50 * (TENTH * sigma).exp();
    let found = format!("{found}; the log-normal law has d10 {d10_of_law:.1}, d90 {d90_of_law:.1} nm");
    let allowed = "d10 and d90 within 5 % of the log-normal law through d50 (d50 = √(d10 d90)); for other laws kind = \"list\"";
    ((d10_of_law / d10 - 1.0).abs() > SKEW).then_some(("size", found, allowed))
}

fn list_defect(values: &[f64], weights: &[f64]) -> Option<(&'static str, String, &'static str)> {
    if values.is_empty() || !values.iter().all(|v| SIZE_NM.holds(*v)) {
        return Some(("size.values_nm", format!("{values:?}"), "one or more finite sizes above 0"));
    }
    let fits = weights.is_empty() || (weights.len() == values.len() && are_weights(weights));
    let allowed = "no weights, or one weight of at least 0 per value with a sum above 0";
    (!fits).then(|| ("size.weights", format!("{weights:?}"), allowed))
}

/// Truncation, in standard deviations, below which the normal density is flat to 1e-4 and
/// rejection, which keeps a share of 0.8 cut, would take hundreds of draws.
const FLAT: f64 = 1e-2;

fn cut_normal(draws: &mut Draws, cut: f64) -> f64 {
    if cut < FLAT {
        return cut * (2.0 * draws.uniform() - 1.0);
    }
    loop {
        let x = draws.normal();
        if x.abs() <= cut {
            return x;
        }
    }
}

#[cfg(test)]
#[path = "size_tests.rs"]
mod tests;
