//! The strategies on the vector problem: one discrete system, one solution, one yardstick.

use inkwave::solve::{
    Bicgstab, Born, ConvergentBorn, Direct, Gmres, Goal, Idr, Relaxation, Silent, SolveError, Solver,
};
use inkwave::wave::maxwell::{Averaging, Polarisation};
use inkwave::wave::{Field, Mean, System};
use inkwave_validation::vector::*;

const GOAL: Goal = Goal { tolerance: 1e-12, max_applications: 5000 };

fn distance(a: &Field, b: &Field) -> f64 {
    let norm = |f: &Field| f.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
    norm(&(a - b)) / norm(b)
}

/// Identity: 1e-10 for a residual of 1e-12 (the smallest singular value is above 0.01).
#[test]
fn strategies_agree_with_the_dense_solve() {
    let case = &reference("vsph02").case;
    let problem = problem(case, resolution(case, 5, 5), Mean::default(), Averaging::Normal);
    for polarisation in Polarisation::BOTH {
        let system = problem.polarised(polarisation);
        let truth = Direct::default().solve(&system, GOAL, &mut Silent).expect("dense").field;
        let all: [Box<dyn Solver>; 4] = [
            Box::new(Gmres::default()),
            Box::new(Bicgstab::default()),
            Box::new(Idr::default()),
            Box::new(Born::default()),
        ];
        for solver in all {
            let solution = solver.solve(&system, GOAL, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
            let error = distance(&solution.field, &truth);
            assert!(error < 1e-10, "{} {polarisation:?}: {error:.1e}", solver.name());
            assert!(solution.account.residual <= GOAL.tolerance);
        }
    }
}

/// Strategies that split the operator at points say why they cannot.
#[test]
fn splitting_strategies_are_refused_with_a_reason() {
    let case = &reference("vsph02").case;
    let problem = problem(case, resolution(case, 5, 5), Mean::default(), Averaging::Normal);
    let system = problem.polarised(Polarisation::S);
    for solver in [&Relaxation::default() as &dyn Solver, &ConvergentBorn::default()] {
        match solver.solve(&system, GOAL, &mut Silent) {
            Err(error @ SolveError::Setting { .. }) => assert!(error.to_string().contains("moments")),
            other => panic!("{}: {:?}", solver.name(), other.map(|s| s.account)),
        }
    }
}

/// Output is written over whatever the buffer held, and −A⁻¹V is complex symmetric in the flux weights: reciprocity.
#[test]
fn one_application_does_not_depend_on_the_buffer() {
    let case = &reference("vsph02").case;
    let problem = problem(case, resolution(case, 5, 5), Mean::default(), Averaging::Normal);
    let system = problem.polarised(Polarisation::P);
    let wave = system.background_wave();
    let mut clean = Field::zeros(system.shape());
    let mut dirty = Field::from_elem(system.shape(), f64::NAN.into());
    system.scatter(wave.view(), &mut clean);
    system.scatter(wave.view(), &mut dirty);
    assert_eq!(clean, dirty);
}
