//! Order of convergence across a curved surface: what the normal-field tensor is for.

use inkwave::wave::Mean;
use inkwave::wave::maxwell::Averaging;
use inkwave_validation::support::fitted_slope;
use inkwave_validation::vector::*;

/// Error of p → p on the cylinder `vcyl01` at several numbers of points per period, 200 planes per µm.
fn slope(averaging: Averaging) -> (f64, f64) {
    let reference = reference("vcyl01");
    let error = |points: usize| {
        let solved = solve_as(&reference.case, points, 80, 1e-8, Mean::default(), averaging);
        reference.errors(&solved.far)[1][1]
    };
    let errors: Vec<(f64, f64)> = [9, 15, 21, 27].into_iter().map(|n| (n as f64, error(n))).collect();
    (fitted_slope(&errors), errors[3].1)
}

/// H along the cylinder: E crosses the surface. Li's rules say order 1 without and about 3 with the tensor.
#[test]
fn the_normal_tensor_converges_with_order_three_and_plain_averaging_with_one() {
    let (normal, finest) = slope(Averaging::Normal);
    let (naive, coarse) = slope(Averaging::Naive);
    assert!(normal > 2.5, "normal tensor: order {normal:.2}");
    assert!((0.5..1.5).contains(&naive), "plain averaging: order {naive:.2}");
    assert!(finest < 0.05 * coarse, "{finest:.1e} against {coarse:.1e}");
}
