//! All strategies against the dense solve, what they refuse, and what they cost.

use super::tiny::*;
use inkwave::solve::Entry;
use inkwave::solve::{
    Born, Direct, Gmres, Goal, Registry, Relaxation, Silent, SolveError, Solver, Step, Watch,
};
use inkwave::wave::{Body, BodyShape, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use inkwave_validation::referee;
use std::ops::ControlFlow;

/// Every strategy that converges on each of the tiny problems; the Born series has a test of its own.
fn sure() -> impl Iterator<Item = Box<dyn Solver>> {
    let all: Vec<Box<dyn Solver>> = Registry::default().entries().iter().map(Entry::build).collect();
    all.into_iter().filter(|s| s.most_unknowns().is_none() && s.name() != "born")
}

/// Identity: one discrete system has one solution.
#[test]
fn strategies_agree_with_the_dense_solve() {
    for solver in sure() {
        let worst = referee::worst_distance(&*solver).unwrap_or_else(|e| panic!("{e}"));
        assert!(worst < referee::BOUND, "{}: {worst:.1e}", solver.name());
    }
}

/// Identity: without contrast the wave in the mean medium is the solution, wherever a strategy starts; rounding of the
/// mean solve. BiCGSTAB's second half step is 0/0 there.
#[test]
fn without_contrast_every_strategy_gives_the_wave_in_the_mean_medium() {
    let goal = Goal { tolerance: 1e-12, ..Goal::default() };
    for setting in SETTINGS {
        for scheme in [Scheme::Cubic, Scheme::SecondDifference] {
            let problem = problem_of(1.5.into(), setting, scheme, REAL);
            let truth = Direct::default().solve(&problem, goal, &mut Silent).expect("dense").field;
            let born: Box<dyn Solver> = Box::new(Born::default());
            for solver in sure().chain([born]) {
                for start in [None, Some(garbage(&problem))] {
                    let solved = solver.solve_from(&problem, start.as_ref(), goal, &mut Silent);
                    let field = solved.unwrap_or_else(|e| panic!("{} {setting:?}: {e}", solver.name())).field;
                    let error = distance(&field, &truth);
                    assert!(error < 1e-11, "{} {setting:?} {scheme:?}: {error:.1e}", solver.name());
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
    let body = Body::new(BodyShape::CylinderY { x_um: 0.3, z_um: 0.4, radius_um: 0.2 }, 0);
    let scene = Scene::layer([0.6, 0.6], 0.8, vec![body]);
    let media = Media {
        incident: 1.0.into(),
        exit: 1.0.into(),
        backgrounds: vec![1.5.into()],
        inclusions: vec![2.5.into()],
    };
    let incidence = Incidence { wavelength_um: 0.55, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let resolution = Resolution { nx: 15, ny: 1, cells: 16, scheme: Scheme::Cubic };
    Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("problem")
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
    for entry in Registry::default().entries() {
        let solver = entry.build();
        let stopped = solver.solve(&problem, Goal::default(), &mut Impatient);
        assert!(matches!(stopped, Err(SolveError::Cancelled { .. })), "{}", solver.name());
    }
}
