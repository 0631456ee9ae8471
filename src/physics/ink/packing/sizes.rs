//! Number and sizes of a pigment's grains in the cell.

use crate::ink::Template;
use crate::ink::{PackError, PigmentGrains, Share, ShareRule};
use crate::numerics::Draws;

/// Larger numbers of grains suggest a mistake in the units.
pub const MOST_GRAINS: usize = 5_000_000;

/// Expected numbers of grains below this round to none.
const LEAST_GRAINS: f64 = 0.5;

/// Relative deviation of the drawn volume that is worth a note.
const UNLIKE: f64 = 0.1;

impl PigmentGrains {
    /// Number of grains that hold the fraction of a layer's volume (µm³) in the mean of their
    /// sizes.
    pub fn expected(&self, volume_um3: f64) -> f64 {
        self.volume_fraction * volume_um3 / self.mean_um3(&self.shape.template())
    }

    /// The smallest fraction of a volume (µm³) that rounds to one grain rather than none.
    pub fn least_share(&self, volume_um3: f64) -> f64 {
        LEAST_GRAINS * self.mean_um3(&self.shape.template()) / volume_um3
    }

    /// Mean volume of a grain, µm³.
    fn mean_um3(&self, template: &Template) -> f64 {
        template.volume.um3 * self.size.radius_um(1.0, template).powi(3) * self.size.mean_cube_nm3()
    }

    /// Thickest radii (µm) of the grains that hold the fraction of `volume`, by [`ShareRule`].
    pub(super) fn draw_sizes(
        &self,
        template: &Template,
        volume: f64,
        draws: &mut Draws,
    ) -> Result<(Vec<f64>, Share), PackError> {
        let target = self.volume_fraction * volume;
        let drawn = if self.size.has_spread() { Self::of_a_law } else { Self::alike };
        let mut radii = drawn(self, template, target, draws)?;
        let sum = radii.iter().fold(0.0, |sum, radius| sum + template.volume.um3 * radius.powi(3));
        let scaled = self.share == ShareRule::ScaleSizes && sum > 0.0;
        let size_factor = if scaled { (target / sum).cbrt() } else { 1.0 };
        radii.iter_mut().for_each(|r| *r *= size_factor);
        let achieved_fraction = sum * size_factor.powi(3) / volume;
        let fraction_error = achieved_fraction * template.volume.error_um3 / template.volume.um3;
        let share = Share {
            requested_fraction: self.volume_fraction,
            achieved_fraction,
            fraction_error,
            grains: radii.len(),
            size_factor,
        };
        Ok((radii, share))
    }

    /// Grains of one size: the number nearest to the volume.
    fn alike(&self, template: &Template, target: f64, draws: &mut Draws) -> Result<Vec<f64>, PackError> {
        let mut radii = Vec::new();
        let mut sum = 0.0;
        while sum < target {
            let radius = self.size.radius_um(self.size.draw_nm(draws), template);
            let um3 = template.volume.um3 * radius.powi(3);
            if sum + um3 - target > target - sum {
                break;
            }
            radii.push(radius);
            sum += um3;
            if radii.len() > MOST_GRAINS {
                return Err(too_many(format!("radius {radius} µm")));
            }
        }
        Ok(radii)
    }

    /// Grains with a spread of sizes: the number follows from the mean volume of the distribution.
    /// Stopping at the grain that overshoots would reject large grains: for a log-normal
    /// distribution with σ = 0.5, the mean volume at 5 grains per cell would be 0.69 of the
    /// distribution's.
    fn of_a_law(&self, template: &Template, target: f64, draws: &mut Draws) -> Result<Vec<f64>, PackError> {
        let expected = target / self.mean_um3(template);
        if expected.is_nan() || expected > MOST_GRAINS as f64 {
            return Err(too_many(format!("{expected:.1e} grains")));
        }
        // The fraction is met in the mean over cells; only a fraction of one grain is rounded, as
        // for grains of one size.
        let count = if expected < LEAST_GRAINS {
            0
        } else if expected < 1.0 {
            1
        } else {
            expected as usize + usize::from(draws.uniform() < expected.fract())
        };
        let sizes = self.size.strata_nm(count, draws);
        Ok(sizes.into_iter().map(|nm| self.size.radius_um(nm, template)).collect())
    }

    /// Rejects pigments that rounding to whole grains would remove.
    pub(super) fn check_presence(&self, k: usize, volume_um3: f64, sizes: &[f64]) -> Result<(), PackError> {
        if !sizes.is_empty() || self.volume_fraction == 0.0 {
            return Ok(());
        }
        let field = format!("pigment[{k}].volume_fraction");
        let found = format!("{:?}", self.volume_fraction);
        let allowed = too_few_grains(self.least_share(volume_um3), "the cell");
        Err(PackError::input(field, found, allowed, MORE_ROOM))
    }

    /// Note on a cell too small for its size distribution: the drawn sizes hold far more or less
    /// than the fraction.
    pub(super) fn unlike(&self, k: usize, share: &Share) -> Option<String> {
        let Share { requested_fraction, achieved_fraction, grains, size_factor, .. } = share;
        let drawn = achieved_fraction / requested_fraction / size_factor.powi(3);
        if !self.size.has_spread() || drawn.is_nan() || (drawn - 1.0).abs() <= UNLIKE {
            return None;
        }
        let effect = match self.share {
            ShareRule::NearestGrain => format!("{drawn:.2} of the requested volume is in this cell"),
            ShareRule::ScaleSizes => format!("all sizes are multiplied by {size_factor:.2}"),
        };
        Some(format!(
            "pigment[{k}]: {grains} grains cannot represent their size distribution, {effect}; the mean over many cells is right, \
             and a larger period_um brings every cell near it"
        ))
    }
}

fn too_many(found: String) -> PackError {
    let allowed = format!("at most {MOST_GRAINS} grains in the cell");
    PackError::input("pigment.size", found, allowed, "check the units of size and period")
}

/// Remedy if the volume fraction is less than a grain.
pub const MORE_ROOM: &str = "widen period_um, take smaller grains, or let the cells vary (layer.cell)";

/// Allowed range if the volume fraction is less than a grain.
pub fn too_few_grains(least_share: f64, cell: &str) -> String {
    format!("from {least_share:.1e}, which is half a grain in {cell}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::grains::size::{By, Measure, SizeDistribution};
    use crate::numerics::estimate::Estimate;

    const CELLS: u64 = 20_000;

    fn law(sigma: f64) -> SizeDistribution {
        let of = Measure::EffectiveDiameter;
        SizeDistribution::LogNormal { median_nm: 200.0, sigma, by: By::Number, cut_at_sigmas: 3.0, of }
    }

    /// Per cell: the volume over that asked, less 1, and the sums over grains of v/v̄ − 1, of d/d̄
    /// − 1 and of (v/v̄)² over its mean, less 1.
    fn deviations(draw: impl Fn(&PigmentGrains, f64, &mut Draws) -> Vec<f64>, grains: f64) -> [Estimate; 4] {
        let pigment = PigmentGrains { size: law(0.5), ..PigmentGrains::spheres(200.0, 0.3) };
        // moments of the law by its quantiles, which the strata do not share a sum with
        let steps = 200_000;
        let moment = |power: i32| {
            let at =
                |i: usize| (1e-3 * pigment.size.quantile_nm((i as f64 + 0.5) / steps as f64)).powi(power);
            (0..steps).map(at).sum::<f64>() / steps as f64
        };
        let means = [3, 1, 6].map(moment);
        let target = grains * std::f64::consts::PI / 6.0 * means[0];
        let of_cell = |stream: u64| {
            let radii = draw(&pigment, target, &mut Draws::new(5, stream));
            let sum = |power: i32| radii.iter().map(|r| (2.0 * r).powi(power)).sum::<f64>();
            let count = radii.len() as f64;
            let of_law = |i: usize, power: i32| sum(power) / means[i] - count;
            [sum(3) / means[0] / grains - 1.0, of_law(0, 3), of_law(1, 1), of_law(2, 6)]
        };
        let cells: Vec<[f64; 4]> = (0..CELLS).map(of_cell).collect();
        std::array::from_fn(|i| Estimate::of_mean(&cells.iter().map(|c| c[i]).collect::<Vec<_>>()))
    }

    /// Over many small cells the share is met, and number, volume and diameter of the grains are
    /// those of the law. *Planted*: the rule for grains of one size turns large grains away.
    #[test]
    fn sizes_that_spread_follow_their_law_in_small_cells() {
        let template = crate::ink::grains::shape::Shape::Sphere.template();
        let drawn = |rule: Rule| {
            let template = &template;
            move |p: &PigmentGrains, target: f64, draws: &mut Draws| rule(p, template, target, draws).unwrap()
        };
        for grains in [1.5, 5.3, 20.0] {
            let sigmas = |e: Estimate| e.value / e.standard_error.unwrap();
            let ours = deviations(drawn(PigmentGrains::of_a_law), grains).map(sigmas);
            let old = deviations(drawn(PigmentGrains::alike), grains).map(sigmas);
            println!("{grains} grains: {ours:.1?}, turning large ones away {old:.1?}");
            // Significance: four standard errors of 20 000 cells, in each of twelve numbers.
            assert!(ours.iter().all(|z| z.abs() < 4.0), "{grains}: {ours:?}");
            assert!(old[1] < -20.0 && old[2] < -10.0, "{grains}: {old:?}");
        }
    }

    type Rule = fn(&PigmentGrains, &Template, f64, &mut Draws) -> Result<Vec<f64>, PackError>;

    /// Without a spread of sizes the number of grains is fixed; a cell that holds half a grain or
    /// more is never empty.
    #[test]
    fn grains_of_one_size_are_counted_and_no_cell_is_empty() {
        let template = crate::ink::grains::shape::Shape::Sphere.template();
        let one_nm = |values_nm: Vec<f64>, weights: Vec<f64>| SizeDistribution::List {
            values_nm,
            weights,
            of: Measure::EffectiveDiameter,
        };
        let size = SizeDistribution::diameter_nm(200.0);
        for same in [law(0.0), one_nm(vec![200.0, 300.0], vec![1.0, 0.0]), size] {
            assert!(!same.has_spread());
            let pigment = PigmentGrains { size: same, ..PigmentGrains::spheres(200.0, 0.3) };
            // 0.3 µm³ hold 71.6 grains of π/6 · 0.2³ µm³.
            let (radii, _) = pigment.draw_sizes(&template, 1.0, &mut Draws::new(1, 0)).unwrap();
            assert_eq!(radii.len(), 72);
        }
        let pigment = PigmentGrains { size: law(0.5), ..PigmentGrains::spheres(200.0, 0.3) };
        let mean_um3 = template.volume.um3 * (1e-3_f64 / template.effective_diameter()).powi(3);
        let whole = mean_um3 * pigment.size.mean_cube_nm3() / 0.3;
        for (cells, empty) in [(0.49, true), (0.51, false), (1.0, false)] {
            let lone = |stream| {
                let (radii, share) =
                    pigment.draw_sizes(&template, cells * whole, &mut Draws::new(1, stream)).unwrap();
                (radii.is_empty(), pigment.unlike(0, &share).is_some())
            };
            let all: Vec<_> = (0..20).map(lone).collect();
            assert!(all.iter().all(|(none, _)| *none == empty), "{cells}");
            assert!(empty || all.iter().any(|(_, told)| *told), "{cells}");
        }
        let slip = PigmentGrains { size: law(0.5), ..PigmentGrains::spheres(200.0, 0.7) };
        let error = slip.draw_sizes(&template, 1e9, &mut Draws::new(1, 0)).unwrap_err().to_string();
        assert!(error.contains("5000000") && error.contains("units"), "{error}");
    }
}
