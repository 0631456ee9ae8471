//! The effect of packings without room on the mean of the others.
//!
//! A cell without room may also differ from the others in colour. In the worst case one normal
//! variable determines both: a missing fraction f then shifts the mean of the others by λ = φ(z)/(1
//! − f) of the standard deviation of all cells, z = Φ⁻¹(f), and reduces their variance by the
//! factor 1 + zλ − λ² (truncated normal distribution; Heckman, Econometrica 47 (1979) 153).

use super::uncertainty::nothing;
use crate::input::study::Study;
use crate::run::Collected;
use serde::Serialize;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// Numbers of a study's packings with and without room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Survivors {
    /// Number of packings with room for their grains.
    pub packed: usize,
    /// Number of packings without room.
    pub refused: usize,
    /// Number of packings with room that are left out, as the other one in their cell has none.
    #[serde(skip_serializing_if = "nothing")]
    pub left_out: usize,
}

impl Survivors {
    /// Counts the packings of a study, as far as they are collected.
    pub fn new(study: &Study, collected: &Collected) -> Self {
        let has_no_room = |r: usize| collected.refused.iter().any(|refused| refused.realisation == r);
        let partners = collected.realisations.iter().filter_map(|r| study.partner(r.packing.realisation));
        Self {
            packed: collected.realisations.len(),
            refused: collected.refused.len(),
            left_out: partners.filter(|&partner| has_no_room(partner)).count(),
        }
    }

    /// How many are missing; `None` if every packing has room.
    pub fn missing_in_words(self) -> Option<String> {
        let Self { packed, refused, left_out } = self;
        let told = format!("{refused} of {} packings have no room", packed + refused);
        let paired = format!("{told}, and {left_out} others that share cells with them are left out");
        (refused > 0).then_some(if left_out > 0 { paired } else { told })
    }

    /// A number of packings as a share of all.
    fn share(self, count: usize) -> f64 {
        count as f64 / (self.packed + self.refused).max(1) as f64
    }

    /// Largest shift of a mean over `cells`, as a multiple of its standard error; 0 if every
    /// packing has room.
    pub(super) fn largest_shift(self, cells: usize) -> f64 {
        let share = self.share(self.refused + self.left_out);
        if self.refused == 0 || self.packed <= self.left_out {
            return 0.0;
        }
        let law = Normal::standard();
        let z = law.inverse_cdf(share);
        let shift = law.pdf(z) / (1.0 - share);
        shift / (1.0 + z * shift - shift * shift).sqrt() * (cells as f64).sqrt()
    }

    /// Why there is no result if more than the share `allowed` has no room, or no cell is whole.
    pub fn refusal(self, allowed: f64) -> Option<String> {
        let told = self.missing_in_words()?;
        if self.share(self.refused) > allowed {
            return Some(format!(
                "{told}, more than run.failed_packings = {allowed} allows: the mean over the others would be biased towards \
                 cells that can be packed. A larger run.failed_packings gives the numbers, with error bars that include the largest bias"
            ));
        }
        (self.packed <= self.left_out).then(|| format!("{told}: none is left"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::estimate::Estimate;

    /// Equally spaced quantiles replace draws: the lowest tenth, or half, has no room.
    #[test]
    fn the_worst_selection_moves_the_mean_by_as_much_as_is_said() {
        let law = Normal::standard();
        let all: Vec<f64> = (0..10_000).map(|i| law.inverse_cdf((i as f64 + 0.5) / 1e4)).collect();
        for refused in [1000, 5000] {
            let survivors = Survivors { packed: all.len() - refused, refused, left_out: 0 };
            let mean = Estimate::of_mean(&all[refused..]);
            let said = survivors.largest_shift(survivors.packed) * mean.standard_error.unwrap();
            // sums instead of integrals of a density with a jump: 1e-3
            assert!((mean.value / said - 1.0).abs() < 1e-3, "{refused}: {} and {said}", mean.value);
        }
        assert_eq!(Survivors { packed: 24, ..Survivors::default() }.largest_shift(24), 0.0);
        // three of twelve cells that two packings share
        let paired = Survivors { packed: 21, refused: 3, left_out: 3 }.largest_shift(9);
        assert_eq!(paired, Survivors { packed: 9, refused: 3, left_out: 0 }.largest_shift(9));
    }

    #[test]
    fn more_than_the_share_allowed_is_no_result() {
        let survivors = |packed, refused, left_out| Survivors { packed, refused, left_out };
        assert_eq!(survivors(9, 1, 0).refusal(0.1), None);
        let refusal = survivors(10, 6, 0).refusal(0.1).unwrap();
        assert!(refusal.starts_with("6 of 16 packings have no room"), "{refusal}");
        assert_eq!(survivors(10, 6, 0).refusal(0.5), None);
        assert_eq!(survivors(21, 3, 3).refusal(0.125), None);
        let refusal = survivors(2, 10, 2).refusal(1.0).unwrap();
        assert!(
            refusal.ends_with("2 others that share cells with them are left out: none is left"),
            "{refusal}"
        );
    }
}
