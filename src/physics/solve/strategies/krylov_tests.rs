//! GMRES and Born against a dense solve of the same, assembled system on tiny awkward grids.

use super::super::coarse::CoarsePlan;
use super::*;
use crate::ink::Sphere;
use crate::solve::vectors::norm;
use crate::solve::{Born, Direct, Goal, Idr, Silent, Step, Watch};
use crate::wave::{
    Body, BodyShape, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side, System,
};
use faer::linalg::solvers::Solve;
use num_complex::Complex64;
use std::ops::ControlFlow;

const SCHEMES: [Scheme; 5] =
    [Scheme::SecondDifference, Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic];

/// A cell smaller than the wave, so that even one point in the plane is a valid grid.
fn problem([nx, ny, cells]: [usize; 3], scheme: Scheme, pigment: Complex64, side: Side) -> Problem {
    let ball = Sphere { center_um: [0.1, 0.13, 0.08], radius_um: 0.07 };
    let body = Body::new(BodyShape::Balls(vec![ball]), 0);
    let scene = Scene::layer([0.3, 0.26], 0.16, vec![body]);
    let one = Complex64::ONE;
    let media =
        Media { incident: one, exit: 1.5 * one, backgrounds: vec![1.558.into()], inclusions: vec![pigment] };
    let incidence = Incidence { wavelength_um: 0.9, polar_deg: 25.0, azimuth_deg: 40.0, from: side };
    let resolution = Resolution { nx, ny, cells, scheme };
    Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("a valid problem")
}

fn awkward() -> Vec<[usize; 3]> {
    vec![[1, 1, 1], [1, 2, 2], [2, 1, 3], [2, 2, 4], [5, 1, 2], [1, 7, 1], [5, 7, 2], [7, 5, 3], [7, 2, 4]]
}

/// u₀ and the solution of (1 + A⁻¹V) u = u₀ by dense LU, the matrix from unit vectors.
fn dense_solution(problem: &Problem) -> Field {
    let shape = problem.shape();
    let count = problem.unknowns();
    // Scratch starts as garbage: no column may depend on what the buffer held.
    let mut column = Field::from_elem(shape, Complex64::new(f64::NAN, f64::NAN));
    let mut matrix = faer::Mat::<Complex64>::identity(count, count);
    for j in 0..count {
        let mut unit = Field::zeros(shape);
        unit.as_slice_mut().expect("contiguous")[j] = Complex64::ONE;
        problem.scatter(&unit, &mut column);
        column.iter().enumerate().for_each(|(i, v)| matrix[(i, j)] += v);
    }
    let background = problem.background_wave();
    let right = faer::Mat::from_fn(count, 1, |i, _| flat(&background)[i]);
    let solution = matrix.partial_piv_lu().solve(&right);
    Field::from_shape_fn(shape, |(r, c)| solution[(r * shape.1 + c, 0)])
}

/// Largest difference of two fields.
pub(super) fn largest(a: &Field, b: &Field) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// On all harmonics the operator is the inverse itself, up to rounding.
///
/// *Planted*: a wrong sign of what the inner points load the nodes with, or the factors of an
/// eliminated node in the wrong order.
#[test]
fn the_lowest_harmonics_are_solved_exactly() {
    for size in awkward() {
        for (i, scheme) in SCHEMES.into_iter().enumerate() {
            let side = if i % 2 == 0 { Side::Incident } else { Side::Exit };
            let problem = problem(size, scheme, Complex64::new(2.1, 0.1), side);
            let columns: Vec<usize> = (0..problem.harmonics.len()).collect();
            let plan = || CoarsePlan { problem: &problem, columns: columns.clone() };
            let mut single = problem.background_wave();
            let mut double = single.clone();
            plan().carried_out::<f32>().apply(single.as_slice_mut().expect("contiguous"));
            plan().carried_out::<f64>().apply(double.as_slice_mut().expect("contiguous"));
            // rounding errors, times condition numbers of up to a hundred
            let truth = dense_solution(&problem);
            let errors = [single, double].map(|field| largest(&field, &truth));
            assert!(errors[0] < 2e-5 && errors[1] < 1e-11, "{size:?} {scheme:?}: {errors:?}");
        }
    }
}

/// *Planted* in IDR(s): the residual's part left out of a new direction, a product with the wrong
/// shadow vector, or a correction that does not follow its residual.
#[test]
fn gmres_and_idr_agree_with_the_dense_solve() {
    for size in awkward() {
        for (i, scheme) in SCHEMES.into_iter().enumerate() {
            let side = if i % 2 == 0 { Side::Incident } else { Side::Exit };
            for pigment in [Complex64::new(1.4, 0.2), Complex64::from(2.5)] {
                let problem = problem(size, scheme, pigment, side);
                let goal = Goal { tolerance: 1e-13, ..Goal::default() };
                let dense = dense_solution(&problem);
                let solvers: [Box<dyn Solver>; 3] =
                    [Box::new(Gmres::default()), Box::new(guided()), Box::new(Idr::default())];
                for solver in solvers {
                    let solution = solver.solve(&problem, goal, &mut Silent).expect("converges");
                    let error = largest(&solution.field, &dense);
                    // Identity: the residual asked for times a condition number below 100.
                    assert!(error < 1e-11, "{size:?} {scheme:?} {pigment}: {error:e}");
                }
            }
        }
    }
}

/// Guided modes treated even where that does not pay.
fn guided() -> Gmres {
    let modes =
        GuidedModes { threshold: 10.0, least_harmonics: 0, damped: f64::INFINITY, ..Default::default() };
    Gmres { guided_modes: modes, ..Gmres::default() }
}

/// Without contrast the mean operator's inverse needs no correction. *Planted*: the inverse of the
/// mean block added, not taken off.
#[test]
fn guided_modes_change_nothing_where_there_is_no_contrast() {
    for scheme in SCHEMES {
        let problem = problem([5, 7, 3], scheme, 1.558.into(), Side::Incident);
        let correction = guided().guided_modes.correction(&problem).expect("near-null modes");
        let wave = problem.background_wave();
        let mut corrected = flat(&wave).to_vec();
        correction.apply(&mut corrected);
        let change = corrected.iter().zip(flat(&wave)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        // Rounding times the modes' condition.
        assert!(change < 1e-9, "{scheme:?}: {change:e}");
    }
}

/// A film in its own medium at a thickness where a standing wave would fit: what it holds radiates
/// at once, which is as far from null as its damping, 4k/H. *Planted*: damping forgotten.
#[test]
fn a_mode_that_radiates_is_no_guided_mode() {
    let n = 1.558;
    let wavelength_um = 0.9;
    let modes = |outside: f64| {
        let scene = Scene::layer([0.3, 0.26], 2.5 * wavelength_um / n, Vec::new());
        let index = Complex64::from(n);
        let media = Media {
            incident: outside.into(),
            exit: outside.into(),
            backgrounds: vec![index],
            inclusions: vec![index],
        };
        let incidence = Incidence { wavelength_um, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
        let resolution = Resolution { nx: 1, ny: 1, cells: 24, scheme: Scheme::Cubic };
        let problem = Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default());
        let near = GuidedModes { least_harmonics: 0, damped: f64::INFINITY, ..Default::default() };
        near.correction(&problem.expect("a valid problem")).is_some()
    };
    assert!(!modes(n) && modes(0.05), "index-matched half-spaces carry it off, thin ones hold it");
}

#[test]
fn single_precision_is_judged_by_the_residual_in_double_precision() {
    let goal = Goal { tolerance: 1e-5, ..Goal::default() };
    for (size, solver) in awkward().into_iter().flat_map(|size| [(size, Gmres::default()), (size, guided())])
    {
        let problem = problem(size, Scheme::Quartic, Complex64::from(2.5), Side::Incident);
        let solution = solver.solve(&problem, goal, &mut Silent).expect("converges");
        let background = problem.background_wave();
        let mut rest = Field::zeros(problem.shape());
        System::residual(&problem, &background, &solution.field, &mut rest);
        let residual = norm(flat(&rest)) / norm(flat(&background));
        assert!(residual <= goal.tolerance && (residual / solution.account.residual - 1.0).abs() < 1e-6);
        // The residual times a condition number below 100.
        let error = largest(&solution.field, &dense_solution(&problem));
        assert!(error < 1e-3, "{size:?}: {error:e}");
    }
}

#[test]
fn the_direct_referee_agrees_with_another_factorisation() {
    // With the feature `lapack` this sets LAPACK against faer; without it, two assemblies of the
    // same matrix.
    for size in awkward() {
        for scheme in SCHEMES {
            let problem = problem(size, scheme, Complex64::new(1.4, 0.2), Side::Exit);
            let goal = Goal { tolerance: 1e-12, ..Goal::default() };
            let direct = Direct::default().solve(&problem, goal, &mut Silent).expect("a regular matrix");
            let error = largest(&direct.field, &dense_solution(&problem));
            // Identity: rounding times a condition number below 100.
            assert!(error < 1e-12, "{size:?} {scheme:?}: {error:e}");
        }
    }
    let problem = problem([7, 7, 4], Scheme::Cubic, Complex64::from(1.4), Side::Incident);
    let refused = Direct { max_unknowns: 100 }.solve(&problem, Goal::default(), &mut Silent);
    let message = refused.expect_err("too large").to_string();
    assert!(message.contains("at most 100"), "{message}");
}

#[test]
fn restarts_and_guesses_lead_to_the_same_field() {
    let problem = problem([7, 5, 3], Scheme::Cubic, Complex64::from(2.5), Side::Incident);
    let goal = Goal { tolerance: 1e-12, ..Goal::default() };
    let whole = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges");
    let short =
        Gmres { restart: 5, ..Gmres::default() }.solve(&problem, goal, &mut Silent).expect("converges");
    assert!(largest(&whole.field, &short.field) < 1e-10);
    let again =
        Gmres::default().solve_from(&problem, Some(&whole.field), goal, &mut Silent).expect("converges");
    // A converged guess costs the one application that measures it.
    assert_eq!((again.account.steps, again.account.operator_applications), (0, 1));
}

/// A basis that is too short says which length to try; with leave to grow it converges.
#[test]
fn a_basis_that_is_too_short_grows_within_its_leave() {
    let problem = problem([7, 5, 3], Scheme::Cubic, Complex64::from(6.0), Side::Incident);
    let goal = Goal { tolerance: 1e-6, ..Goal::default() };
    let whole =
        Gmres { restart: 512, ..Gmres::default() }.solve(&problem, goal, &mut Silent).expect("converges");
    let goal = Goal { max_applications: 3 * whole.account.operator_applications, ..goal };
    let short = Gmres { restart: 1, ..Gmres::default() };
    let failed = |solver: &dyn Solver| match solver.solve(&problem, goal, &mut Silent) {
        Err(error) => error.to_string(),
        Ok(solution) => format!("{} applications", solution.account.operator_applications),
    };
    let alone = failed(&short);
    assert!(alone.contains("krylov = { restart = 2 }"), "{alone}");
    let bound = failed(&Growing { settings: short, longest: 2 });
    assert!(bound.contains("--memory-gb"), "{bound}");
    let roomy =
        Growing { settings: short, longest: 512 }.solve(&problem, goal, &mut Silent).expect("converges");
    let one = Goal { max_applications: 1, ..goal };
    let hurried = Gmres::default().solve(&problem, one, &mut Silent).expect_err("too few").to_string();
    assert!(hurried.contains("allow more applications") && !hurried.contains("too short"), "{hurried}");
    // Both residuals are 1e-6; the matrix of a strong contrast amplifies them.
    assert!(largest(&roomy.field, &whole.field) < 1e-3);
}

#[test]
fn born_agrees_where_it_converges_and_says_so_where_it_does_not() {
    let goal = Goal { tolerance: 1e-12, ..Goal::default() };
    for size in awkward() {
        let problem = problem(size, Scheme::Cubic, Complex64::new(1.4, 0.05), Side::Incident);
        let born = Born::default().solve(&problem, goal, &mut Silent).expect("weak contrast converges");
        let krylov = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges");
        // Both stop at 1e-12; the condition number is of order one.
        assert!(largest(&born.field, &krylov.field) < 1e-10, "{size:?}");
    }
    let strong = problem([5, 7, 2], Scheme::Cubic, Complex64::from(6.0), Side::Incident);
    let error = Born::default().solve(&strong, goal, &mut Silent).expect_err("strong contrast diverges");
    assert!(
        matches!(error, SolveError::Diverged { ratio, .. } if ratio > 1.0 && ratio.is_finite()),
        "{error}"
    );
    assert!(error.to_string().contains("krylov"), "{error}");
}

#[test]
fn operator_applications_are_pinned() {
    let goal = Goal { tolerance: 1e-6, ..Goal::default() };
    let problem = problem([7, 5, 3], Scheme::Cubic, Complex64::new(1.4, 0.2), Side::Incident);
    let solution = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges");
    // One application per step, and one for the true residual at the end.
    assert_eq!(solution.account.operator_applications, solution.account.steps + 1);
    assert_eq!(solution.account.steps, PINNED_STEPS);
    assert!(solution.account.residual <= goal.tolerance);
}

/// Steps of the case above; a change of the algorithm that changes it must say why.
const PINNED_STEPS: usize = 4;

#[test]
fn limits_and_cancellation_are_errors_with_an_account() {
    let problem = problem([5, 5, 3], Scheme::Cubic, Complex64::from(2.5), Side::Incident);
    let goal = Goal { tolerance: 1e-12, max_applications: 3 };
    let error = Gmres::default().solve(&problem, goal, &mut Silent).expect_err("three are too few");
    assert!(matches!(error, SolveError::NotConverged { .. }), "{error}");
    assert!(error.account().expect("an account").residual < 1.0);
    struct Impatient;
    impl Watch for Impatient {
        fn step(&mut self, step: &Step) -> ControlFlow<()> {
            if step.step == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }
    for solver in [&Gmres::default() as &dyn Solver, &Born::default()] {
        let error = solver.solve(&problem, Goal { tolerance: 1e-12, ..Goal::default() }, &mut Impatient);
        let error = error.expect_err("cancelled");
        assert!(matches!(error, SolveError::Cancelled { .. }), "{}: {error}", solver.name());
        assert_eq!(error.account().expect("an account").steps, 2);
    }
}
