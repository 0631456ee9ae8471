//! Observed orders of convergence against the references, in the plane and across the layer.

use crate::support::*;
use inkwave::wave::Scheme;

fn errors_across(reference: &Reference, points: usize, cells: &[usize], scheme: Scheme) -> Vec<(f64, f64)> {
    let error = |&cells: &usize| {
        let solved = solve_at(&reference.case, reference.resolution(points, cells, scheme), 1e-8);
        (cells as f64, reference.largest_error(&solved.far))
    };
    cells.iter().map(error).collect()
}

fn assert_slope(name: &str, errors: &[(f64, f64)], low: f64, high: f64) {
    let slope = fitted_slope(errors);
    println!("{name}: order {slope:.2} from {errors:?}");
    assert!((low..high).contains(&slope), "{name}: order {slope:.2} from {errors:?}");
}

#[test]
fn every_scheme_has_its_order_across_an_ink_layer() {
    // Orders by theory: 2 for second differences and tents; 4 for quadratic moments (twice the degree). A grain's
    // cut vanishes with a corner at its poles, which allows 4 and no more beyond; where the poles fall within a cell
    // varies from grid to grid, so single slopes scatter and a line through them is judged.
    let ink = reference("inka1");
    let cells = [8, 11, 16, 23, 32];
    // 48 points per µm: the plane's own error is below 1e-6.
    let errors = |scheme: Scheme| errors_across(ink, 57, &cells, scheme);
    assert_slope("second differences", &errors(Scheme::SecondDifference)[1..], 1.7, 2.4);
    let tents = errors(Scheme::Tents);
    assert_slope("tents", &tents, 1.7, 2.3);
    let quadratic = errors(Scheme::Quadratic);
    assert_slope("quadratic", &quadratic, 3.6, 4.6);
    let cubic = errors(Scheme::Cubic);
    assert_slope("cubic", &cubic, 3.8, 5.2);
    let quartic = errors_across(ink, 57, &cells[..3], Scheme::Quartic);
    for ((tents, quadratic), (cubic, quartic)) in tents.iter().zip(&quadratic).zip(cubic.iter().zip(&quartic))
    {
        assert!(tents.1 > quadratic.1 && quadratic.1 > cubic.1 && cubic.1 > quartic.1, "higher is better");
    }
}

#[test]
fn grids_in_the_plane_converge_with_order_five_for_ink_contrast() {
    // Order: band-limited contrast of grains with smooth edges gives 3; folding the outer harmonics makes it
    // about 5 (measured; the next terms of the partitioning are two orders smaller). Scatter as above.
    for (id, cells) in [("inka1", 16), ("sph10", 20), ("sph05", 20), ("cyl01", 20)] {
        let case = reference(id);
        let period = case.case.scene.period_um[0];
        let error = |per_um: f64| {
            let points = (per_um * period).round() as usize;
            let solved = solve_at(&case.case, case.resolution(points, cells, Scheme::Quartic), 1e-8);
            (points as f64, case.largest_error(&solved.far))
        };
        let errors: Vec<_> = [10.0, 12.0, 15.0, 18.0, 24.0].map(error).to_vec();
        assert_slope(id, &errors, 4.0, 7.5);
    }
}

#[test]
fn the_exact_scheme_needs_far_fewer_planes_than_second_differences() {
    // The claim behind the discretisation: with the same unknowns, a hundredth of the error and less.
    let ink = reference("inka1");
    let error = |scheme, cells| errors_across(ink, 24, &[cells], scheme)[0].1;
    let (papers, exact) = (error(Scheme::SecondDifference, 33), error(Scheme::Cubic, 11));
    assert!(exact < 0.01 * papers, "{exact:e} against {papers:e}");
}
