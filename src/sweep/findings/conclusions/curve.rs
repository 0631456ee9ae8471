//! Finds the place on a curve of variants that has a given value, such as the diameter of the
//! spheres that act like an agglomerate.

use super::{Claim, no_value};
use crate::numerics::estimate::Linked;
use crate::sweep::findings::outcome::Outcome;

/// Abscissa of the value on the curve, interpolated linearly, with the errors of the value and of
/// the curve.
///
/// # Errors
/// Why there is no such place: values are missing, or the curve does not take the value exactly
/// once.
pub(super) fn place(claim: &Claim, outcomes: &[Outcome], value: &Linked) -> Result<Linked, String> {
    let mut points = Vec::new();
    for (at, outcome) in claim.curve().map(|(at, v)| (at, &outcomes[v])) {
        let found = outcome.quantity(claim.table.quantity, claim.table.wavelength_nm);
        points.push((at, found.ok_or_else(|| no_value(outcome))?));
    }
    on_curve(&points, value)
}

fn on_curve(points: &[(f64, Linked)], wanted: &Linked) -> Result<Linked, String> {
    let value = wanted.estimate.value;
    let crosses = |w: &&[(f64, Linked)]| {
        let [a, b] = [w[0].1.estimate.value, w[1].1.estimate.value];
        (a <= value && value < b) || (b < value && value <= a)
    };
    let found: Vec<&[(f64, Linked)]> = points.windows(2).filter(crosses).collect();
    match found[..] {
        [[start, end]] => Ok(within(start, end, wanted)),
        [] => Err(format!("the curve has {value:.4} nowhere")),
        _ => Err(format!("the curve has {value:.4} at {} places", found.len())),
    }
}

/// Interpolates between two points; an error of the value or of the curve moves the abscissa by
/// that error over the slope.
fn within((from, a): &(f64, Linked), (to, b): &(f64, Linked), wanted: &Linked) -> Linked {
    let [low, high, value] = [a, b, wanted].map(|number| number.estimate.value);
    let slope = (high - low) / (to - from);
    let share = (value - low) / (high - low);
    let mut place = Linked::sum([(1.0 / slope, wanted), ((share - 1.0) / slope, a), (-share / slope, b)]);
    place.estimate.value = from + share * (to - from);
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::estimate::Estimate;

    fn number(value: f64) -> Linked {
        let estimate = Estimate { value, standard_error: Some(0.3) };
        Linked { estimate, deviations: [(0, 0.0)].into() }
    }

    #[test]
    fn a_value_is_found_between_two_points_with_its_error() {
        let points = [(100.0, number(50.0)), (200.0, number(40.0)), (300.0, number(38.0))];
        let found = on_curve(&points, &number(45.0)).unwrap().estimate;
        assert!((found.value - 150.0).abs() < 1e-12);
        // heights 0.3 and twice 0.15 add up to 0.367, over a slope of 0.1
        assert!((found.standard_error.unwrap() - 3.674).abs() < 1e-3);
        assert!(on_curve(&points, &number(37.0)).is_err());
        let twice = [(1.0, number(0.0)), (2.0, number(2.0)), (3.0, number(0.5))];
        assert!(on_curve(&twice, &number(1.0)).is_err());
    }

    #[test]
    fn what_moves_the_value_and_the_curve_alike_leaves_the_place() {
        let moved = |value: f64| Linked { deviations: [(0, 0.3)].into(), ..number(value) };
        let points = [(100.0, moved(50.0)), (200.0, moved(40.0))];
        let found = on_curve(&points, &moved(45.0)).unwrap().estimate;
        // rounding errors of a few additions, over the slope
        assert!(found.standard_error.unwrap() < 1e-12, "{found:?}");
    }
}
