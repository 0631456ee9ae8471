//! Both halves of the discrete operator as full matrices: symmetry, inverses, dissipation.

use super::tiny::*;
use faer::{Mat, Side};
use inkwave::wave::ShiftedMean;
use inkwave::wave::{Field, Mean, Problem};
use num_complex::Complex64;

/// A linear map of fields as a full matrix, by columns.
fn assemble(problem: &Problem, map: impl Fn(Field) -> Field) -> Mat<Complex64> {
    let n = problem.unknowns();
    let mut matrix = Mat::zeros(n, n);
    for j in 0..n {
        let mut unit = Field::zeros(problem.shape());
        unit.as_slice_mut().expect("contiguous")[j] = Complex64::ONE;
        map(unit).iter().enumerate().for_each(|(i, &z)| matrix[(i, j)] = z);
    }
    matrix
}

/// A on nodes and bubbles, with the half-spaces' conditions.
fn mean_matrix(problem: &Problem) -> Mat<Complex64> {
    assemble(problem, |u| applied(problem, &u))
}

/// A u, with the half-spaces' conditions.
fn applied(problem: &Problem, u: &Field) -> Field {
    let mut out = Field::zeros(u.dim());
    problem.mean.add_product(u, Some([&problem.kappa[0], &problem.kappa[1]]), &mut out);
    out
}

/// V in the harmonics of the planes, over the planes' masses.
fn contrast_matrix(problem: &Problem) -> Mat<Complex64> {
    let mass = problem.mean.plane_mass();
    assemble(problem, |mut planes| {
        problem.mean.to_unknowns(&mut planes);
        let mut loads = Field::zeros(problem.shape());
        problem.double().contrast_loads(planes.view(), &mut loads);
        loads.outer_iter_mut().zip(&mass).for_each(|(mut row, m)| row.mapv_inplace(|z| z / m));
        loads
    })
}

fn largest(matrix: &Mat<Complex64>) -> f64 {
    matrix.col_iter().flat_map(|c| c.iter()).map(|z| z.norm()).fold(0.0, f64::max)
}

/// Smallest and largest eigenvalue of (M − M†)/2i: negative ones are directions that gain energy.
fn dissipation(matrix: &Mat<Complex64>) -> [f64; 2] {
    let half = |i, j| (matrix[(i, j)] - matrix[(j, i)].conj()) * Complex64::new(0.0, -0.5);
    let values = Mat::from_fn(matrix.nrows(), matrix.nrows(), half)
        .self_adjoint_eigenvalues(Side::Lower)
        .expect("finite");
    [values[0], *values.last().expect("a matrix has eigenvalues")]
}

/// Identity, to rounding: A is complex symmetric, and A⁻¹A = 1.
#[test]
fn the_mean_operator_is_symmetric_and_inverted_exactly() {
    for scheme in SCHEMES {
        let problem = problem(SETTINGS[1], scheme, Mean::default());
        let matrix = mean_matrix(&problem);
        let skew = largest(&(&matrix - matrix.transpose()));
        assert!(skew < 1e-13 * largest(&matrix), "{scheme:?}: {skew:.1e}");
        let u = garbage(&problem);
        let mut solved = applied(&problem, &u);
        problem.mean.inverse.solve(&mut solved);
        // Pivots of guided harmonics may cost a few digits.
        assert!(distance(&solved, &u) < 1e-10, "{scheme:?}: {:.1e}", distance(&solved, &u));
    }
}

/// Hypothesis of the splitting: Im A ≥ 0 as a matrix with a real mean, so that 1 − cA is accretive for c = iτ/2. Its
/// largest eigenvalue is radiation through a face, Re κ.
#[test]
fn the_mean_half_of_the_splitting_is_dissipative() {
    for scheme in SCHEMES {
        for setting in [SETTINGS[0], SETTINGS[1], SETTINGS[5]] {
            let problem = problem(setting, scheme, REAL);
            let matrix = mean_matrix(&problem);
            let [least, most] = dissipation(&matrix);
            let radiation = problem.kappa.iter().flatten().map(|k| k.re).fold(0.0, f64::max);
            // Rounding of eigenvalues, relative to the largest entry.
            let rounding = 1e-13 * largest(&matrix);
            assert!(least > -rounding, "{scheme:?}: {least:e}");
            assert!((most - radiation).abs() < rounding, "{scheme:?}: {most} {radiation}");
        }
    }
}

/// Hypothesis of the splitting for V: it is diagonal at the points, so that the eigenvalues of Im V/D are its values
/// there; they vanish without absorption, and with it they are negative only where the band-limited contrast rings.
#[test]
fn the_contrast_half_is_dissipative_but_for_ringing() {
    for scheme in SCHEMES {
        let lossless = problem(SETTINGS[1], scheme, REAL);
        let matrix = contrast_matrix(&lossless);
        let [least, most] = dissipation(&matrix);
        let rounding = 1e-13 * largest(&matrix);
        assert!(least.abs() < rounding && most.abs() < rounding, "{scheme:?}: {least:e} {most:e}");

        let absorbing = problem(SETTINGS[0], scheme, REAL);
        let mass = absorbing.mean.plane_mass();
        let values: Vec<f64> =
            (0..mass.len()).flat_map(|p| absorbing.contrast_per_mass(p, mass[p])).map(|v| v.im).collect();
        let [low, high] =
            [values.iter().copied().fold(0.0, f64::min), values.iter().copied().fold(0.0, f64::max)];
        let [least, most] = dissipation(&contrast_matrix(&absorbing));
        println!("{scheme:?}: Im V/D from {least} to {most}");
        assert!((least - low).abs() < 1e-12 * high && (most - high).abs() < 1e-12 * high, "{scheme:?}");
    }
}

/// Why relaxation asks for a real mean: a complex one leaves the binder with Im V = −Im ⟨k²⟩ < 0, which is gain.
#[test]
fn a_complex_mean_gives_the_binder_gain() {
    for scheme in SCHEMES {
        let least = |problem: &Problem| dissipation(&contrast_matrix(problem))[0];
        let real = least(&problem(SETTINGS[0], scheme, REAL));
        let problem = problem(SETTINGS[0], scheme, Mean::default());
        let complex = least(&problem);
        let absorption = problem.mean.mean_absorption();
        println!("{scheme:?}: {real} with a real mean, {complex} with a complex one of {absorption}");
        assert!(complex < -0.9 * absorption, "{scheme:?}: {complex} {absorption}");
        assert!(complex < real - 0.5 * absorption, "{scheme:?}: {real} {complex} {absorption}");
    }
}

/// Identity: in plane values, A − shift and its banded factors are inverse to each other.
#[test]
fn banded_factors_invert_the_shifted_mean() {
    for scheme in SCHEMES {
        let problem = problem(SETTINGS[2], scheme, REAL);
        let a = Complex64::new(0.3, 0.7);
        let b = Complex64::new(1.0, 0.2);
        let factors = ShiftedMean::new(&problem, a, b);
        let u = garbage(&problem);
        let mut image = Field::zeros(u.dim());
        let mass = problem.mean.plane_mass();
        for i in 0..u.ncols() {
            let band = problem.mean.plane_band(i, problem.end_conditions(i));
            for r in 0..u.nrows() {
                image[[r, i]] += (a * mass[r] + b * band[[r, 0]]) * u[[r, i]];
                for k in 1..band.ncols().min(r + 1) {
                    image[[r, i]] += b * band[[r, k]] * u[[r - k, i]];
                    image[[r - k, i]] += b * band[[r, k]] * u[[r, i]];
                }
            }
        }
        factors.solve(&mut image);
        assert!(distance(&image, &u) < 1e-10, "{scheme:?}: {:.1e}", distance(&image, &u));
    }
}
