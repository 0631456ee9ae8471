use super::*;
use crate::appearance::colour::Colorimeter;

fn estimate(value: f64, error: f64) -> Estimate {
    Estimate { value, standard_error: Some(error) }
}

/// Numbers from coarse grids, beside those of accurate studies.
#[test]
fn factors_and_ratios_that_cannot_be_are_withheld() {
    for (value, error, word) in [
        (-16.0, 615.0, "too large"),
        (-0.099, 0.006, "below 0"),
        (f64::NAN, 0.1, "too large"),
        (0.4, f64::NAN, "too large"),
    ] {
        let reason = impossible_factor(estimate(value, error)).unwrap();
        assert!(reason.contains(word), "{reason}");
        assert!(impossible_share(estimate(value, error)).is_some());
    }
    assert!(impossible_share(estimate(1.2, 0.05)).unwrap().contains("above 1"));
    for (value, error) in [(0.0, 1e-6), (-0.001, 1e-3), (-0.004, 0.005), (1.3, 0.02), (0.7, 0.2)] {
        assert_eq!(impossible_factor(estimate(value, error)), None);
    }
    assert_eq!(impossible_share(estimate(1.01, 0.02)), None);
    assert_eq!(impossible_share(Estimate::unknown_error(-0.01)), None);
}

#[test]
fn colours_that_cannot_be_are_withheld() {
    let grid: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    let meter = Colorimeter::new(&grid).unwrap();
    let of = |value: f64| meter.colour(&[value; 31]).unwrap();
    let small = Some([0.3; 3]);
    for (value, error, word) in [
        (-16.0, Some([30.0; 3]), "X = "),
        (-0.01, small, "below 0"),
        (1.1, small, "lighter than white"),
        (1.2, None, "lighter than white"),
        (0.5, Some([4.0, 80.0, 3.0]), "is not meaningful"),
        (0.5, Some([f64::NAN; 3]), "not a number"),
    ] {
        let reason = impossible_colour(&of(value), error).unwrap();
        assert!(reason.contains(word), "{reason}");
    }
    for (value, error) in [(0.0, small), (1.0, small), (1.005, small), (0.5, Some([20.0; 3])), (0.9, None)] {
        assert_eq!(impossible_colour(&of(value), error), None, "{value}");
    }
}

/// A spline through few wavelengths may dip below 0, which is acceptable. What is far outside is
/// left unchanged, and refused.
#[test]
fn totals_keep_within_0_and_1_and_their_errors_hold_the_overshoot() {
    assert_eq!(bounded(estimate(-0.04, 0.03)), estimate(0.0, 0.05));
    assert_eq!(bounded(estimate(0.3, 0.03)), estimate(0.3, 0.03));
    assert_eq!(bounded(Estimate::unknown_error(1.02)), Estimate::unknown_error(1.0));
    assert_eq!(bounded(estimate(-0.2, 0.03)), estimate(-0.2, 0.03));
    assert!(bounded(estimate(f64::NAN, 0.03)).value.is_nan());
}
