//! The tables of one cell against the theory they come from.

use super::*;
use approx::assert_abs_diff_eq;

fn rule() -> GaussLegendre {
    GaussLegendre::new(12).expect("at least two nodes")
}

/// Identity: tables of degree ≤ 4 hold to a few units of rounding.
const ROUNDING: f64 = 1e-14;

#[test]
fn lobatto_weights_integrate_polynomials_up_to_twice_the_degree_less_one() {
    for degree in 1..=MAX_DEGREE {
        let e = Element::new(degree);
        for power in 0..2 * degree as i32 {
            let sum: f64 = e.points.iter().zip(&e.weights).map(|(t, w)| w * t.powi(power)).sum();
            assert_abs_diff_eq!(sum, 1.0 / f64::from(power + 1), epsilon = ROUNDING);
        }
    }
}

#[test]
fn known_weights_of_low_degrees() {
    assert_eq!(Element::new(1).weights.len(), 2);
    for (weight, sixths) in Element::new(2).weights.iter().zip([1.0, 4.0, 1.0]) {
        assert_abs_diff_eq!(*weight, sixths / 6.0, epsilon = ROUNDING);
    }
}

#[test]
fn points_are_symmetric_and_hold_both_ends() {
    for degree in 1..=MAX_DEGREE {
        let points = Element::new(degree).points;
        assert_eq!((points[0], points[degree]), (0.0, 1.0));
        for q in 0..=degree {
            assert_abs_diff_eq!(points[q] + points[degree - q], 1.0, epsilon = ROUNDING);
        }
    }
}

#[test]
fn shape_functions_are_one_at_their_own_point_and_sum_to_one() {
    for degree in 1..=MAX_DEGREE {
        let e = Element::new(degree);
        for (q, &t) in e.points.iter().enumerate() {
            for (i, value) in e.shape_functions(t).into_iter().enumerate() {
                assert_abs_diff_eq!(value, if i == q { 1.0 } else { 0.0 }, epsilon = ROUNDING);
            }
        }
        assert_abs_diff_eq!(e.shape_functions(0.3).iter().sum::<f64>(), 1.0, epsilon = ROUNDING);
    }
}

#[test]
fn bubbles_vanish_at_the_nodes_and_have_unit_stiffness() {
    let slope = |i: usize, t: f64| {
        let step = 1e-5;
        (integrated_legendre(i, t + step) - integrated_legendre(i, t - step)) / (2.0 * step)
    };
    for i in 1..MAX_DEGREE {
        assert_abs_diff_eq!(integrated_legendre(i, 0.0), 0.0, epsilon = ROUNDING);
        assert_abs_diff_eq!(integrated_legendre(i, 1.0), 0.0, epsilon = ROUNDING);
        for j in 1..MAX_DEGREE {
            let stiffness = rule().integrate(0.0, 1.0, |t| slope(i, t) * slope(j, t));
            // Central differences with step 1e-5: truncation 1e-10, rounding 1e-11.
            assert_abs_diff_eq!(stiffness, if i == j { 1.0 } else { 0.0 }, epsilon = 1e-8);
        }
    }
}

#[test]
fn bubbles_are_orthogonal_in_mass() {
    for degree in 2..=MAX_DEGREE {
        let (lambda, modes) = bubble_modes(degree - 1, &rule());
        let value = |k: usize, t: f64| {
            modes[k].iter().enumerate().map(|(i, c)| c * integrated_legendre(i + 1, t)).sum::<f64>()
        };
        for a in 0..degree - 1 {
            for b in 0..degree - 1 {
                let mass = rule().integrate(0.0, 1.0, |t| value(a, t) * value(b, t));
                assert_abs_diff_eq!(mass, if a == b { lambda[a] } else { 0.0 }, epsilon = ROUNDING);
            }
        }
    }
}

#[test]
fn bubbles_span_all_polynomials_that_vanish_at_the_nodes() {
    // t(1−t) is the only bubble of degree 2: λ = ∫ b² / ∫ b'² = (1/30)/(1/3).
    assert_abs_diff_eq!(Element::new(2).lambda[0], 0.1, epsilon = ROUNDING);
    // Rayleigh quotients of more bubbles approach the string's 1/(π k)² from below.
    let largest = Element::new(4).lambda.into_iter().fold(0.0, f64::max);
    let limit = 1.0 / std::f64::consts::PI.powi(2);
    assert!(largest < limit && largest > 0.9999 * limit, "{largest} against {limit}");
}
