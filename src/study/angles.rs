//! Angles of incidence that make hemispherical means exact for smooth layers.

use super::fault::{Fault, Faults};
use gauss_quad::GaussJacobi;

/// Gauss–Radau nodes for 2∫₀¹ f(μ) μ dμ, μ = cos θ, with the normal (μ = 1) as the fixed node: angles in
/// degrees, rising from 0, with their weights, which sum to 1. Exact for polynomials in μ up to degree
/// 2 `count` − 2; `count` is at least 3.
///
/// The free nodes are the Gauss nodes of the weight (1 − μ) μ, that is the zeros of the Jacobi polynomial
/// P^(1,1) (Davis and Rabinowitz, Methods of Numerical Integration, 1984, section 2.7).
pub fn hemisphere_rule(count: usize) -> Vec<(f64, f64)> {
    let inner = GaussJacobi::new(count - 1, 1.0, 1.0).expect("at least two inner nodes");
    // On [-1, 1] with x = 2μ − 1: 2 μ dμ = (1 + x)/2 dx.
    let node = |&(x, weight): &(f64, f64)| ((1.0 + x) / 2.0, weight / (1.0 - x) / 2.0);
    let mut rule: Vec<(f64, f64)> = inner.iter().map(node).collect();
    let inner_sum: f64 = rule.iter().map(|(_, weight)| weight).sum();
    rule.push((1.0, 1.0 - inner_sum));
    rule.sort_by(|a, b| b.0.total_cmp(&a.0));
    rule.into_iter().map(|(mu, weight)| (mu.acos().to_degrees(), weight)).collect()
}

/// The rule's angles for a study, or a fault and none.
pub(super) fn quadrature_angles(count: usize, faults: &mut Faults) -> Vec<f64> {
    if !(3..=64).contains(&count) {
        let remedy = "5 is usual; the normal is always one of them";
        faults.push(Fault::new("angles.count", count, "whole numbers from 3 to 64", remedy));
        return Vec::new();
    }
    hemisphere_rule(count).into_iter().map(|(polar_deg, _)| polar_deg).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_polynomials_in_mu() {
        for count in 3..=12 {
            let rule = hemisphere_rule(count);
            assert_eq!(rule[0].0, 0.0);
            for degree in 0..=2 * count as i32 - 2 {
                let mean: f64 = rule.iter().map(|(a, w)| w * a.to_radians().cos().powi(degree)).sum();
                // 2∫ μ^(p+1) dμ = 2/(p + 2); rounding of a dozen terms and of acos
                assert!((mean - 2.0 / (f64::from(degree) + 2.0)).abs() < 1e-13, "{count} {degree} {mean}");
            }
        }
    }

    #[test]
    fn four_angles_are_known() {
        let angles: Vec<f64> = hemisphere_rule(4).into_iter().map(|(a, _)| a).collect();
        let expected = [1.0, 0.5 + (3.0_f64 / 7.0).sqrt() / 2.0, 0.5, 0.5 - (3.0_f64 / 7.0).sqrt() / 2.0];
        for (angle, mu) in angles.iter().zip(expected) {
            assert!((angle - mu.acos().to_degrees()).abs() < 1e-11);
        }
    }
}
