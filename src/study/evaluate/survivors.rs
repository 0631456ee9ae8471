//! The effect of packings without room on the mean of the others.
//!
//! A cell without room may also differ from the others in colour. In the worst case one normal
//! variable determines both: a missing fraction f then shifts the mean of the others by λ = φ(z)/(1
//! − f) of the standard deviation of all cells, z = Φ⁻¹(f), and reduces their variance by the
//! factor 1 + zλ − λ² (truncated normal distribution; Heckman, Econometrica 47 (1979) 153).

use serde::Serialize;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// Numbers of a study's packings with and without room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Survivors {
    /// Number of packings with room for their grains.
    pub packed: usize,
    /// Number of packings without room.
    pub refused: usize,
}

impl Survivors {
    /// Share of the packings without room.
    pub fn missing_share(self) -> f64 {
        self.refused as f64 / (self.packed + self.refused).max(1) as f64
    }

    /// Largest shift of a mean of `cells` packings, as a multiple of its standard error; 0 if every
    /// packing has room.
    pub(super) fn largest_shift(self, cells: usize) -> f64 {
        let share = self.missing_share();
        if self.refused == 0 || self.packed == 0 {
            return 0.0;
        }
        let law = Normal::standard();
        let z = law.inverse_cdf(share);
        let shift = law.pdf(z) / (1.0 - share);
        shift / (1.0 + z * shift - shift * shift).sqrt() * (cells as f64).sqrt()
    }

    /// Why there is no result if more than the share `allowed` has no room.
    pub fn refusal(self, allowed: f64) -> Option<String> {
        let Self { packed, refused } = self;
        if self.missing_share() <= allowed {
            return None;
        }
        let tried = packed + refused;
        Some(format!(
            "{refused} of {tried} packings have no room, more than run.failed_packings = {allowed} allows"
        ))
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
            let survivors = Survivors { packed: all.len() - refused, refused };
            let mean = Estimate::of_mean(&all[refused..]);
            let said = survivors.largest_shift(survivors.packed) * mean.standard_error.unwrap();
            // sums instead of integrals of a density with a jump: 1e-3
            assert!((mean.value / said - 1.0).abs() < 1e-3, "{refused}: {} and {said}", mean.value);
        }
        assert_eq!(Survivors { packed: 24, refused: 0 }.largest_shift(24), 0.0);
    }

    #[test]
    fn more_than_the_share_allowed_is_no_result() {
        assert_eq!(Survivors { packed: 9, refused: 1 }.refusal(0.1), None);
        let refusal = Survivors { packed: 10, refused: 6 }.refusal(0.1).unwrap();
        assert!(refusal.starts_with("6 of 16 packings have no room"), "{refusal}");
        assert_eq!(Survivors { packed: 10, refused: 6 }.refusal(0.5), None);
    }
}
