//! The mean operator: exact on the mean medium's own solutions, symmetric, and undone by its solve.

use super::*;
use crate::numerics::fourier::narrow;
use crate::wave::operator::cell::SMALL;
use crate::wave::operator::cell::{NodeCoefficients, decaying_root, left_share};
use crate::wave::{Resolution, Scene};
use num_complex::Complex;
use proptest::prelude::*;

const EXACT: [Scheme; 4] = [Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic];
const ALL: [Scheme; 5] =
    [Scheme::SecondDifference, Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic];
const HEIGHT: f64 = 0.9;

fn grid(cells: usize, scheme: Scheme) -> Grid {
    let scene = Scene::layer([1.0; 2], HEIGHT, Vec::new());
    Grid::new(&scene, Resolution { nx: 1, ny: 1, cells, scheme }).expect("a plain layer has a grid")
}

/// One harmonic whose kz² is `kz2` in every cell.
fn operator(grid: &Grid, kz2: Complex64, kappa: Complex64) -> MeanOperator {
    MeanOperator::new(grid, vec![kz2; grid.cells()], vec![0.0], [&[kappa], &[kappa]])
}

/// Propagating, absorbing, evanescent, and both sides of the switch between series and
/// exponentials.
fn kz2_values() -> [Complex64; 7] {
    [(95.0, 0.0), (80.0, 12.0), (-400.0, 0.0), (1e-9, 0.0), (0.0, 0.0), (0.04, 0.03), (-0.9, 0.1)]
        .map(|(re, im)| Complex64::new(re, im))
}

/// cos(kz (z − z₀)), a solution of the mean medium that is neither incoming nor outgoing.
fn standing_wave(kz2: Complex64, z: f64) -> Complex64 {
    (kz2.sqrt() * (z - 0.31)).cos()
}

fn nodal_field(grid: &Grid, kz2: Complex64) -> Array2<Complex64> {
    let mut u = Array2::zeros((grid.planes(), 1));
    for (j, &z) in grid.nodes_um.iter().enumerate() {
        u[[grid.element.degree * j, 0]] = standing_wave(kz2, z);
    }
    u
}

#[test]
fn exact_scheme_annihilates_the_mean_mediums_solutions() {
    for scheme in EXACT {
        let grid = grid(7, scheme);
        for kz2 in kz2_values() {
            let a = operator(&grid, kz2, Complex64::ONE);
            let u = nodal_field(&grid, kz2);
            let rows = product(&a, &u, [&[Complex64::ONE], &[Complex64::ONE]]);
            let off = NodeCoefficients::new(kz2, grid.height_um(0), scheme).off.norm();
            for j in 1..grid.cells() {
                let local =
                    (j - 1..=j + 1).map(|i| u[[grid.element.degree * i, 0]].norm()).fold(0.0, f64::max);
                let row = rows[[grid.element.degree * j, 0]].norm();
                // Identity: three terms of size off·u, a few units of rounding each.
                assert!(row <= 2e-14 * off * local, "{scheme:?}, kz² = {kz2}, row {j}: {row:e}");
            }
        }
    }
}

#[test]
fn values_inside_a_cell_are_the_mean_mediums_solution() {
    for scheme in EXACT {
        let grid = grid(7, scheme);
        for kz2 in kz2_values() {
            let u = nodal_field(&grid, kz2);
            let a = operator(&grid, kz2, Complex64::ONE);
            for plane in 0..grid.planes() {
                let (cell, point) = (plane / grid.element.degree, plane % grid.element.degree);
                let step = if point == 0 { 0.0 } else { grid.height_um(cell) * grid.element.points[point] };
                let expected = standing_wave(kz2, grid.nodes_um[cell] + step);
                let mut value = [Complex64::new(7.0, 7.0)];
                a.inverse.plane_values(&u.view(), plane, &mut value);
                let scale = expected.norm().max(1.0);
                // Identity; evanescent shares are quotients of exponentials with some ten
                // roundings.
                assert!((value[0] - expected).norm() <= 1e-13 * scale, "{scheme:?} {kz2} plane {plane}");
            }
        }
    }
}

#[test]
fn series_and_exponentials_meet() {
    // On both sides of the switch the function itself changes by 2e-12 of its value at most.
    let h = 0.1;
    for scheme in EXACT {
        for phase in [0.0, 1.0, 2.5] {
            let entries = |x2: f64| {
                let kz2 = Complex64::from_polar(x2, phase) / (h * h);
                let c = NodeCoefficients::new(kz2, h, scheme);
                [c.off * h, c.diagonal * h, left_share(kz2, h, 0.3, scheme)]
            };
            let series = entries(SMALL * (1.0 - 1e-12));
            let exponentials = entries(SMALL * (1.0 + 1e-12));
            for (a, b) in series.into_iter().zip(exponentials) {
                // Identity: 1 − e^{2ix} cancels to about |2x| = 0.1, so ten units of rounding.
                assert!((a - b).norm() < 1e-14 * 10.0, "{scheme:?}: {a} {b}");
            }
        }
    }
}

#[test]
fn strongly_evanescent_cells_neither_overflow_nor_couple() {
    let c = NodeCoefficients::new(Complex64::from(-1e8), 0.5, Scheme::Cubic);
    assert!(c.off.norm() < 1e-300 && (c.diagonal - Complex64::from(-1e4)).norm() < 1e-9);
    assert!(left_share(Complex64::from(-1e8), 0.5, 0.4, Scheme::Cubic).norm() < 1e-300);
}

#[test]
fn second_differences_have_a_local_error_of_order_four() {
    // P2 section 3: the symbol 2 cos(kz h)/h + kz² h − 2/h = h³ kz⁴/12 + O(h⁵).
    let kz2 = Complex64::from(50.0);
    for h in [0.02, 0.01] {
        let c = NodeCoefficients::new(kz2, h, Scheme::SecondDifference);
        let symbol = 2.0 * c.off * (kz2.sqrt() * h).cos() + 2.0 * c.diagonal;
        let ratio = symbol / (h.powi(3) * kz2 * kz2 / 12.0);
        // Order: the next term is smaller by kz²h²/30 < 1e-3.
        assert!((ratio - 1.0).norm() < 1e-3, "{ratio}");
    }
}

/// Three harmonics, cells of two different means.
fn mixed(cells: usize, scheme: Scheme) -> (Grid, MeanOperator, [Vec<Complex64>; 2]) {
    let grid = grid(cells, scheme);
    let mean = (0..cells).map(|j| Complex64::new(200.0 + 40.0 * (j % 2) as f64, 3.0)).collect();
    let lateral = vec![0.0, 130.0, 900.0];
    let kappa = |k2: f64| lateral.iter().map(|&q| decaying_root(Complex64::from(k2 - q))).collect::<Vec<_>>();
    let kappa = [kappa(130.0), kappa(290.0)];
    let operator = MeanOperator::new(&grid, mean, lateral.clone(), [&kappa[0], &kappa[1]]);
    (grid, operator, kappa)
}

fn sizes() -> impl Iterator<Item = (usize, Scheme)> {
    [1, 2, 5].into_iter().flat_map(|cells| ALL.map(|scheme| (cells, scheme)))
}

#[test]
fn mean_operator_is_symmetric_as_a_full_matrix() {
    for (cells, scheme) in sizes() {
        let (grid, a, kappa) = mixed(cells, scheme);
        let planes = grid.planes();
        for harmonic in 0..3 {
            let column = |row: usize| {
                let mut unit = Array2::zeros((planes, 3));
                unit[[row, harmonic]] = Complex64::ONE;
                product(&a, &unit, [&kappa[0], &kappa[1]]).column(harmonic).to_vec()
            };
            let matrix: Vec<Vec<Complex64>> = (0..planes).map(column).collect();
            for i in 0..planes {
                for j in 0..planes {
                    // Identity: both entries are the same expression.
                    assert_eq!(matrix[i][j], matrix[j][i], "{scheme:?}, {cells} cells");
                }
            }
        }
    }
}

fn noise(shape: (usize, usize), seed: u32) -> Array2<Complex64> {
    let value = |i: usize| ((i as f64 + 1.0) * (1.0 + f64::from(seed)) * 0.7391).sin();
    Array2::from_shape_fn(shape, |(r, c)| Complex64::new(value(7 * r + c), value(5 * r + 3 * c + 1)))
}

fn product(a: &MeanOperator, u: &Array2<Complex64>, kappa: [&[Complex64]; 2]) -> Array2<Complex64> {
    let mut out = Array2::zeros(u.dim());
    a.add_product(u, Some(kappa), &mut out);
    out
}

fn bilinear(a: &Array2<Complex64>, b: &Array2<Complex64>) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn solve_undoes_apply(cells in 1usize..9, scheme in 0usize..5, seed in 0u32..1000) {
        let (grid, a, kappa) = mixed(cells, ALL[scheme]);
        let u = noise((grid.planes(), 3), seed);
        let mut back = product(&a, &u, [&kappa[0], &kappa[1]]);
        a.inverse.solve(&mut back);
        let error = (&back - &u).iter().map(|z| z.norm()).fold(0.0, f64::max);
        // Identity: rounding times the condition number of a few waves' worth of layer, below 1e4.
        prop_assert!(error < 1e-11, "{error:e}");
    }

    #[test]
    fn loads_are_the_transpose_of_plane_values(cells in 1usize..9, scheme in 0usize..5, seed in 0u32..1000) {
        let (grid, a, _) = mixed(cells, ALL[scheme]);
        let u = noise((grid.planes(), 3), seed);
        let mut y = noise((grid.planes(), 3), seed + 1);
        let mut values = Array2::zeros(u.dim());
        for (plane, mut row) in values.outer_iter_mut().enumerate() {
            a.inverse.plane_values(&u.view(), plane, row.as_slice_mut().expect("contiguous"));
        }
        let forward = bilinear(&y, &values);
        a.inverse.load(&mut y);
        // Identity: about 100 terms of size one.
        prop_assert!((forward - bilinear(&y, &u)).norm() < 1e-12);
    }

    #[test]
    fn solving_loads_is_loading_then_solving(cells in 1usize..9, scheme in 0usize..5, seed in 0u32..1000) {
        let (grid, a, _) = mixed(cells, ALL[scheme]);
        let loads = noise((grid.planes(), 3), seed);
        let (mut one, mut two) = (loads.clone(), loads.clone());
        a.inverse.solve_loads(&mut one);
        a.inverse.load(&mut two);
        a.inverse.solve(&mut two);
        let largest = two.iter().map(|z| z.norm()).fold(0.0, f64::max);
        prop_assert!((&one - &two).iter().all(|z| z.norm() < 1e-12 * (1.0 + largest)));
        let mut single = loads.mapv(narrow::<f32>);
        a.inverse.narrowed::<f32>().solve_loads(&mut single);
        // Roundings of 6e-8 times the condition number of a few waves' worth of layer.
        let error = |(z, w): (&Complex<f32>, &Complex64)| (Complex64::new(z.re.into(), z.im.into()) - w).norm();
        let worst = single.iter().zip(&two).map(error).fold(0.0, f64::max);
        prop_assert!(worst < 1e-4 * (1.0 + largest), "{worst:e} of {largest:e}");
    }
}

#[test]
fn roots_decay_or_stay_bounded() {
    let signs = [(3.0, 1e-3), (-3.0, 1e-3), (3.0, -1e-3), (-3.0, -1e-3), (0.0, 2.0), (0.0, -2.0)];
    for (re, im) in [(4.0, 0.0), (-4.0, 0.0), (-4.0, -0.0), (0.0, 0.0)].into_iter().chain(signs) {
        let root = decaying_root(Complex64::new(re, im));
        assert!(root.im >= 0.0 && (root * root - Complex64::new(re, im)).norm() < 1e-15 * 16.0, "{root}");
    }
}
