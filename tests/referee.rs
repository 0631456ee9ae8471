//! The referee: every strategy against the dense solve of the same discrete system, and the hypotheses behind them.

use inkwave::solve::{
    Bicgstab, Born, ConvergentBorn, Direct, Gmres, Goal, Relaxation, Silent, SolveError, Solver, Step, Watch,
};
use inkwave::wave::banded::ShiftedMean;
use inkwave::wave::{
    Ball, Body, Field, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Shape, Side,
};
use ndarray::Array2;
use num_complex::Complex64;
use std::ops::ControlFlow;

const REAL: Mean = Mean { depends_on_z: true, absorbing: false };
const SCHEMES: [Scheme; 5] =
    [Scheme::Cubic, Scheme::Quadratic, Scheme::Quartic, Scheme::Tents, Scheme::SecondDifference];

/// nx, ny, cells, κ, polar, azimuth, side: awkward sizes, absorbing and lossless, normal, oblique and conical.
type Setting = (usize, usize, usize, f64, f64, f64, Side);
const SETTINGS: [Setting; 6] = [
    (5, 5, 4, 0.1, 0.0, 0.0, Side::Above),
    (7, 5, 4, 0.0, 25.0, 0.0, Side::Above),
    (6, 7, 5, 0.05, 40.0, 33.0, Side::Below),
    (11, 1, 4, 0.0, 10.0, 0.0, Side::Above),
    (1, 1, 5, 0.2, 60.0, 0.0, Side::Below),
    (2, 9, 4, 0.1, 0.0, 0.0, Side::Above),
];

fn problem(setting: Setting, scheme: Scheme, mean: Mean) -> Problem {
    let (nx, ny, cells, kappa, polar_deg, azimuth_deg, from) = setting;
    let ball = |x: f64, z: f64| Ball { center_um: [x, 0.12, z], radius_um: 0.09 };
    let grain = |b: Ball| Body { shape: Shape::Balls(vec![b]), inclusion: 0 };
    let bodies = match (nx, ny) {
        (1, 1) => vec![Body { shape: Shape::Sheet { z_um: [0.11, 0.27] }, inclusion: 0 }],
        (_, 1) => {
            vec![Body { shape: Shape::CylinderY { x_um: 0.1, z_um: 0.2, radius_um: 0.09 }, inclusion: 0 }]
        }
        _ => vec![grain(ball(0.08, 0.15)), grain(ball(0.22, 0.3))],
    };
    let scene = Scene::layer([0.33, 0.3], 0.4, bodies);
    let media = Media {
        above: 1.0.into(),
        below: 1.2.into(),
        backgrounds: vec![1.5.into()],
        inclusions: vec![Complex64::new(1.4, kappa)],
    };
    let incidence = Incidence { wavelength_um: 0.75, polar_deg, azimuth_deg, from };
    let resolution = Resolution { nx, ny, cells, scheme };
    Problem::from_scene(&scene, &media, &incidence, resolution, mean).expect("a small problem")
}

/// Numbers of size one without any structure: what a reused buffer might hold.
fn garbage(problem: &Problem) -> Field {
    Field::from_shape_fn(problem.shape(), |(i, j)| Complex64::cis((7 * i * i + 13 * j) as f64))
}

fn strategies(mean: Mean) -> Vec<Box<dyn Solver>> {
    let mut all: Vec<Box<dyn Solver>> =
        vec![Box::new(Gmres::default()), Box::new(Bicgstab::default()), Box::new(ConvergentBorn::default())];
    if !mean.absorbing {
        all.push(Box::new(Relaxation::default()));
    }
    all
}

fn distance(a: &Field, b: &Field) -> f64 {
    let largest = |f: &Field| f.iter().map(|z| z.norm()).fold(0.0, f64::max);
    largest(&(a - b)) / largest(b)
}

/// Identity: one discrete system has one solution. Tolerance 1e-10 for a residual of 1e-12: small grids amplify the
/// residual by less than 100 (their smallest singular value is above 0.01).
#[test]
fn strategies_agree_with_the_dense_solve() {
    let goal = Goal { tolerance: 1e-12, max_applications: 20_000 };
    for setting in SETTINGS {
        for scheme in SCHEMES {
            for mean in [REAL, Mean::default()] {
                let problem = problem(setting, scheme, mean);
                let truth = Direct::default().solve(&problem, goal, &mut Silent).expect("dense").field;
                for solver in strategies(mean) {
                    let solved = solver.solve_from(&problem, Some(&garbage(&problem)), goal, &mut Silent);
                    let field =
                        solved.unwrap_or_else(|e| panic!("{setting:?} {scheme:?} {mean:?}: {e}")).field;
                    let error = distance(&field, &truth);
                    assert!(error < 1e-10, "{} {setting:?} {scheme:?} {mean:?}: {error:.1e}", solver.name());
                }
            }
        }
    }
}

/// Born adds up to the same solution where it converges, and says by how much its terms grow where it does not.
#[test]
fn born_agrees_or_says_that_it_diverges() {
    let goal = Goal { tolerance: 1e-12, ..Goal::default() };
    let weak = problem(SETTINGS[0], Scheme::Cubic, Mean::default());
    let truth = Direct::default().solve(&weak, goal, &mut Silent).expect("dense").field;
    let born = Born::default().solve(&weak, goal, &mut Silent).expect("weak contrast converges");
    assert!(distance(&born.field, &truth) < 1e-10);
    let strong = strong_problem();
    match Born::default().solve(&strong, goal, &mut Silent) {
        Err(SolveError::Diverged { ratio, account }) => {
            assert!(ratio > 1.0 && account.operator_applications < 100, "{ratio}: {account:?}");
        }
        other => panic!("expected divergence, got {:?}", other.map(|s| s.account)),
    }
}

/// High contrast and a thick layer: the Born series cannot converge.
fn strong_problem() -> Problem {
    let body = Body { shape: Shape::CylinderY { x_um: 0.3, z_um: 0.4, radius_um: 0.2 }, inclusion: 0 };
    let scene = Scene::layer([0.6, 0.6], 0.8, vec![body]);
    let media = Media {
        above: 1.0.into(),
        below: 1.0.into(),
        backgrounds: vec![1.5.into()],
        inclusions: vec![2.5.into()],
    };
    let incidence = Incidence { wavelength_um: 0.55, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Above };
    let resolution = Resolution { nx: 15, ny: 1, cells: 16, scheme: Scheme::Cubic };
    Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("problem")
}

/// Identity: the fixed point does not depend on τ, over two decades; the bound is the residual's, amplified.
#[test]
fn relaxation_ends_in_the_same_state_for_every_tau() {
    let goal = Goal { tolerance: 1e-11, max_applications: 50_000 };
    let problem = problem(SETTINGS[1], Scheme::Tents, REAL);
    let truth = Direct::default().solve(&problem, goal, &mut Silent).expect("dense").field;
    for tau in [0.3, 1.0, 3.0, 10.0, 30.0] {
        let relaxation = Relaxation { tau, ..Relaxation::default() };
        let field = relaxation.solve(&problem, goal, &mut Silent).expect("converges").field;
        assert!(distance(&field, &truth) < 1e-9, "tau {tau}: {:.1e}", distance(&field, &truth));
    }
}

#[test]
fn relaxation_refuses_a_complex_mean() {
    let problem = problem(SETTINGS[0], Scheme::Cubic, Mean::default());
    let error =
        Relaxation::default().solve(&problem, Goal::default(), &mut Silent).expect_err("complex mean");
    assert!(error.to_string().contains("real"), "{error}");
}

#[test]
fn the_dense_solver_names_its_limit() {
    let problem = problem(SETTINGS[0], Scheme::Cubic, REAL);
    let error =
        Direct { max_unknowns: 10 }.solve(&problem, Goal::default(), &mut Silent).expect_err("too large");
    assert!(error.to_string().contains("at most 10"), "{error}");
}

/// The mean operator as a full matrix, by columns.
fn mean_matrix(problem: &Problem) -> Array2<Complex64> {
    let n = problem.unknowns();
    let mut matrix = Array2::zeros((n, n));
    for j in 0..n {
        let mut unit = Field::zeros(problem.shape());
        unit.as_slice_mut().expect("contiguous")[j] = Complex64::ONE;
        let image = problem.mean.apply(&unit, [&problem.kappa[0], &problem.kappa[1]]);
        matrix.column_mut(j).assign(&image.into_shape_with_order(n).expect("one column"));
    }
    matrix
}

/// Identity, to rounding: A is complex symmetric, and A⁻¹A = 1.
#[test]
fn the_mean_operator_is_symmetric_and_inverted_exactly() {
    for scheme in SCHEMES {
        let problem = problem(SETTINGS[1], scheme, Mean::default());
        let matrix = mean_matrix(&problem);
        let size = matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let skew = (&matrix - &matrix.t()).iter().map(|z| z.norm()).fold(0.0, f64::max);
        assert!(skew < 1e-13 * size, "{scheme:?}: {skew:.1e}");
        let u = garbage(&problem);
        let mut solved = problem.mean.apply(&u, [&problem.kappa[0], &problem.kappa[1]]);
        problem.mean.solve(&mut solved, false);
        // Pivots of guided harmonics may cost a few digits.
        assert!(distance(&solved, &u) < 1e-10, "{scheme:?}: {:.1e}", distance(&solved, &u));
    }
}

/// Hypothesis of the splitting: Im⟨u, Au⟩ ≥ 0 with a real mean (radiation), so that 1 − cA is accretive for c = iτ/2.
#[test]
fn the_mean_half_of_the_splitting_is_dissipative() {
    for scheme in SCHEMES {
        let problem = problem(SETTINGS[1], scheme, REAL);
        for seed in 0..20 {
            let u = Field::from_shape_fn(problem.shape(), |(i, j)| {
                Complex64::cis((seed * i * i + 5 * j + i) as f64)
            });
            let image = problem.mean.apply(&u, [&problem.kappa[0], &problem.kappa[1]]);
            let flux: f64 = u.iter().zip(&image).map(|(u, a)| (u.conj() * a).im).sum();
            let size: f64 = u.iter().zip(&image).map(|(u, a)| (u.conj() * a).norm()).sum();
            assert!(flux > -1e-12 * size, "{scheme:?}: {flux:.1e}");
        }
    }
}

/// Identity: in plane values, A − shift and its banded factors are inverse to each other.
#[test]
fn banded_factors_invert_the_shifted_mean() {
    for scheme in SCHEMES {
        let problem = problem(SETTINGS[2], scheme, REAL);
        let (a, b) = (Complex64::new(0.3, 0.7), Complex64::new(1.0, 0.2));
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

/// Regression pins, not validation: work per solve must not creep up unnoticed (one application of slack).
#[test]
fn operator_applications_are_pinned() {
    let goal = Goal { tolerance: 1e-6, ..Goal::default() };
    let problem = problem(SETTINGS[0], Scheme::Cubic, Mean::default());
    for (solver, most) in
        [(Box::new(Gmres::default()) as Box<dyn Solver>, 9), (Box::new(Born::default()), 12)]
    {
        let account = solver.solve(&problem, goal, &mut Silent).expect("converges").account;
        assert!(
            account.operator_applications <= most,
            "{}: {}",
            solver.name(),
            account.operator_applications
        );
        assert!(account.residual <= goal.tolerance && account.history.len() > 2);
    }
}

/// Stops at the first step it is shown.
struct Impatient;

impl Watch for Impatient {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        ControlFlow::Break(())
    }
}

#[test]
fn every_strategy_can_be_cancelled() {
    let problem = problem(SETTINGS[1], Scheme::Cubic, REAL);
    let mut all = strategies(REAL);
    all.push(Box::new(Born::default()));
    for solver in all {
        let stopped = solver.solve(&problem, Goal::default(), &mut Impatient);
        assert!(matches!(stopped, Err(SolveError::Cancelled { .. })), "{}", solver.name());
    }
}
