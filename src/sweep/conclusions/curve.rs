//! The place on a curve of variants that has a value, such as the diameter of the spheres that an agglomerate acts like.

use super::{Claim, no_value};
use crate::numerics::estimate::Estimate;
use crate::sweep::outcome::Outcome;

/// Place of the value, by straight lines between the curve's points; with the errors of the value and of the curve there.
///
/// # Errors
/// Why there is no such place: values are missing, or the curve reaches the value nowhere, or more than once.
pub(super) fn place(claim: &Claim, outcomes: &[Outcome], value: Estimate) -> Result<Estimate, String> {
    let point = |&(at, v): &(f64, usize)| {
        let outcome = &outcomes[v];
        let found = outcome.quantity(claim.quantity, claim.wavelength_nm);
        found.map(|estimate| (at, estimate)).ok_or_else(|| no_value(&outcome.name))
    };
    let points: Vec<(f64, Estimate)> = claim.curve.iter().map(point).collect::<Result<_, _>>()?;
    on_curve(&points, value)
}

fn on_curve(points: &[(f64, Estimate)], value: Estimate) -> Result<Estimate, String> {
    let crosses = |w: &&[(f64, Estimate)]| {
        let [a, b] = [w[0].1.value, w[1].1.value];
        (a <= value.value && value.value < b) || (b < value.value && value.value <= a)
    };
    let found: Vec<&[(f64, Estimate)]> = points.windows(2).filter(crosses).collect();
    match found[..] {
        [segment] => Ok(within(segment, value)),
        [] => Err(format!("the curve has {:.4} nowhere", value.value)),
        _ => Err(format!("the curve has {:.4} at {} places", value.value, found.len())),
    }
}

fn within(segment: &[(f64, Estimate)], value: Estimate) -> Estimate {
    let [(from, a), (to, b)] = [segment[0], segment[1]];
    let slope = (b.value - a.value) / (to - from);
    let share = (value.value - a.value) / (b.value - a.value);
    let error = |weight: f64, one: Estimate| weight * one.standard_error.unwrap_or(0.0);
    let height = error(1.0, value).hypot(error(1.0 - share, a)).hypot(error(share, b));
    Estimate {
        value: from + share * (to - from),
        standard_error: value.standard_error.map(|_| height / slope.abs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value: f64) -> Estimate {
        Estimate { value, standard_error: Some(0.3) }
    }

    #[test]
    fn a_value_is_found_between_two_points_with_its_error() {
        let points = [(100.0, estimate(50.0)), (200.0, estimate(40.0)), (300.0, estimate(38.0))];
        let found = on_curve(&points, estimate(45.0)).unwrap();
        assert!((found.value - 150.0).abs() < 1e-12);
        // heights 0.3 and twice 0.15 together 0.367, over a slope of 0.1
        assert!((found.standard_error.unwrap() - 3.674).abs() < 1e-3);
        assert!(on_curve(&points, estimate(37.0)).is_err());
        let twice = [(1.0, estimate(0.0)), (2.0, estimate(2.0)), (3.0, estimate(0.5))];
        assert!(on_curve(&twice, estimate(1.0)).is_err());
    }
}
