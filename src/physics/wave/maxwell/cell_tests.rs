//! The closed forms against quadrature of their definitions.

use super::*;
use gauss_quad::GaussLegendre;

fn node_function(x: Complex64, t: f64) -> Complex64 {
    (x * (1.0 - t)).sin() / x.sin()
}

/// l₊ = 2∫L dt and l₋ = 2∫√3(2t−1) L dt are 1 + x²b and −(1 + x²c)/√3.
#[test]
fn node_moments_agree_with_quadrature() {
    let rule = GaussLegendre::new(40).unwrap();
    let integrate = |f: &dyn Fn(f64) -> Complex64| {
        let part = |g: &dyn Fn(Complex64) -> f64| rule.integrate(0.0, 1.0, |t| g(f(t)));
        Complex64::new(part(&|z| z.re), part(&|z| z.im))
    };
    for x in [0.03, 0.4, 0.9, 1.1, 1.9, 2.1, 2.9].map(Complex64::from).into_iter().chain([
        Complex64::new(0.3, 0.2),
        Complex64::new(1.5, 0.6),
        Complex64::new(0.0, 0.7),
        Complex64::new(0.0, 9.0),
    ]) {
        let CellFunctions { b, c } = CellFunctions::new(x * x);
        let plus = integrate(&|t| 2.0 * node_function(x, t));
        let minus = integrate(&|t| 2.0 * 3f64.sqrt() * (2.0 * t - 1.0) * node_function(x, t));
        assert!((plus - (1.0 + x * x * b)).norm() < 1e-13, "{x}: {plus}");
        assert!((minus + (1.0 + x * x * c) / 3f64.sqrt()).norm() < 1e-13, "{x}: {minus}");
    }
}

/// Both sides of the switches between series and closed form agree to the cancellation that they
/// are set for.
#[test]
fn series_and_closed_forms_meet() {
    for limit in [SERIES_B, SERIES_C] {
        for turn in [0.0, 0.7, 2.0, 3.1] {
            let functions = |factor: f64| CellFunctions::new(Complex64::from_polar(limit * factor, turn));
            let (inside, outside) = (functions(1.0 - 1e-12), functions(1.0 + 1e-12));
            assert!((inside.b - outside.b).norm() < 1e-12 && (inside.c - outside.c).norm() < 1e-12);
        }
    }
}

/// Far below the light line b and c fall like 1/|x|² and stay finite.
#[test]
fn strongly_evanescent_harmonics_do_not_overflow() {
    let far = CellFunctions::new(Complex64::from(-1e6));
    assert!((far.b - 1e-6 * (1.0 - 2e-3)).norm() < 1e-12 && (far.c - 1e-6).norm() < 1e-8);
}
