//! Strong scatterers: what a first cycle leaves goes to guided modes, short recurrences or the
//! elimination of the lowest harmonics.

use super::super::coarse::CoarsePlan;
use super::tests::largest;
use super::*;
use crate::ink::Sphere;
use crate::solve::{Direct, Goal, Silent};
use crate::wave::maxwell::coarse::VectorCoarsePlan;
use crate::wave::maxwell::{Averaging, NormalMoments, Polarised, VectorProblem};
use crate::wave::{
    Body, BodyShape, Incidence, Mean, Media, Polarisation, Problem, Resolution, Scene, Scheme, Side, System,
};
use num_complex::Complex64;
use std::sync::Arc;

fn hard_spheres() -> [Sphere; 5] {
    let centres = [[0.2, 0.2, 0.2], [0.6, 0.3, 0.45], [0.3, 0.6, 0.7], [0.65, 0.65, 0.2], [0.1, 0.45, 0.45]];
    centres.map(|center_um| Sphere { center_um, radius_um: 0.125 })
}

/// Balls in a clear binder, packed into a small cell.
fn hard(index: f64) -> Problem {
    hard_on(index, Resolution { nx: 24, ny: 24, cells: 14, scheme: Scheme::Cubic })
}

fn hard_on(index: f64, resolution: Resolution) -> Problem {
    let ball = |sphere| Body::new(BodyShape::Balls(vec![sphere]), 0);
    let scene = Scene::layer([0.8, 0.8], 0.9, hard_spheres().map(ball).to_vec());
    let one = Complex64::ONE;
    let backgrounds = vec![1.5.into()];
    let inclusions = vec![index.into()];
    let media = Media { incident: one, exit: one, backgrounds, inclusions };
    let incidence = Incidence { wavelength_um: 0.45, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let problem = Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default());
    problem.expect("a valid problem")
}

/// What a first cycle leaves is solved with more guided modes and a longer basis.
/// *Planted*: small cells without their guided modes.
#[test]
fn a_hard_solve_takes_pains() {
    let problem = hard(2.15);
    let goal = Goal { tolerance: 1e-4, ..Goal::default() };
    let near = GuidedModes::default();
    let hard = GuidedModes::default().of_hard_solves();
    assert!(near.correction(&problem).is_none() && hard.correction(&problem).is_some());
    let short = Gmres { restart: 20, ..Gmres::default() };
    let off = GuidedModes { threshold: 0.0, ..near };
    let restarted = Gmres { guided_modes: off, ..short }.solve(&problem, goal, &mut Silent);
    assert!(restarted.is_err(), "restarts alone stall");
    // One cycle of 20 and one of some 30.
    let few = Goal { max_applications: 60, ..goal };
    let pains =
        Growing { settings: short, longest: 240 }.solve(&problem, few, &mut Silent).expect("converges");
    let whole = Gmres { guided_modes: off, restart: 600 }.solve(&problem, goal, &mut Silent);
    let whole = whole.expect("converges");
    // Both residuals are at most 1e-4; resonances amplify them.
    assert!(largest(&whole.field, &pains.field) < 0.05);
}

/// What a first cycle leaves of strong scatterers is left to short recurrences, at most three times
/// the applications of the whole basis (measured: see the constant `SLOW`), or soon to the
/// elimination of the lowest harmonics, which needs a fifth of them by itself.
/// *Planted*: ω never renewed; a wrong sign in the elimination of the nodes or of the inner points.
#[test]
fn strong_scatterers_are_left_to_short_recurrences_and_to_elimination() {
    let problem = hard(2.6);
    let goal = Goal { tolerance: 1e-4, ..Goal::default() };
    let off = GuidedModes { threshold: 0.0, ..GuidedModes::default() };
    let short = Gmres { restart: 60, guided_modes: off };
    let restarted = short.solve(&problem, goal, &mut Silent);
    assert!(restarted.is_err(), "restarts alone do not get there in 2000 applications");
    let whole = Gmres { restart: 600, ..short }.solve(&problem, goal, &mut Silent).expect("converges");
    let most = whole.account.operator_applications as f64;
    let recurrences = Idr::default().solve(&problem, goal, &mut Silent).expect("converges");
    let handed = Growing { settings: short, longest: 240 }.solve(&problem, goal, &mut Silent);
    let handed = handed.expect("converges");
    for (found, share) in [(recurrences, 3.0), (handed, 0.6), (eliminated(&problem, goal), 0.2)] {
        // Both residuals are at most 1e-4; resonances amplify them.
        assert!(largest(&whole.field, &found.field) < 0.05);
        let applications = found.account.operator_applications as f64;
        assert!(applications < share * most, "{applications} against {most}");
        assert!(found.account.bytes < whole.account.bytes);
    }
}

/// The memory planned holds what the elimination keeps, and less than twice that. The rest is the
/// construction of one cell.
/// *Planted*: a plan without the nodes' matrices.
#[test]
fn the_memory_of_the_elimination_is_planned() {
    let problem = hard(2.6);
    let planned = CoarsePlan::new(&problem).bytes();
    let kept = CoarsePlan::new(&problem).carried_out::<f32>().bytes() as f64;
    assert!(kept < planned && planned < 2.0 * kept, "{planned:e} for {kept:e}");
}

/// Maxwell's equations on the cell of strong scatterers, for s and p light.
fn hard_in_vector_mode(index: f64) -> [Polarised; 2] {
    let problem = hard(index);
    let ball = |sphere: &Sphere| Body::new(BodyShape::Balls(vec![*sphere]), 0);
    let scene = Scene::layer([0.8, 0.8], 0.9, hard_spheres().iter().map(ball).collect());
    let resolution = Resolution { nx: 16, ny: 16, cells: 14, scheme: Scheme::Quadratic };
    let moments = Arc::new(NormalMoments::new(&scene, resolution).expect("a sound scene"));
    let problem =
        VectorProblem::new(&moments, &problem.media, &problem.incidence, Mean::default(), Averaging::Normal);
    let problem = problem.expect("a valid problem");
    Polarisation::BOTH.map(|polarisation| problem.polarised(polarisation))
}

/// The vector wave through strong scatterers: a trial, then GMRES with the lowest harmonics
/// eliminated, which leaves the solution as it is; without the memory for that, short recurrences.
/// What one polarisation has made for the other changes nothing but the time.
///
/// *Planted*: a wrong sign of what is eliminated, no trial, an elimination beyond the memory.
#[test]
fn strong_scatterers_of_the_vector_wave_are_eliminated() {
    let [s, p] = hard_in_vector_mode(2.7);
    let goal = Goal { tolerance: 1e-5, ..Goal::default() };
    let growing = |longest: usize| Growing { settings: Gmres { restart: 60, ..Gmres::default() }, longest };
    for system in [&s, &p] {
        let known =
            Idr::default().solve(system, Goal { tolerance: 1e-8, ..goal }, &mut Silent).expect("converges");
        let found = growing(480).solve(system, goal, &mut Silent).expect("converges");
        let scarce = growing(61).solve(system, goal, &mut Silent).expect("converges");
        // the residual times a condition number of up to some hundreds
        assert!(largest(&known.field, &found.field) < 2e-3, "{:e}", largest(&known.field, &found.field));
        let with = found.account.operator_applications;
        let without = scarce.account.operator_applications;
        assert!(3 * with < without, "{with} applications, {without} without elimination");
        let vectors = |count: usize| count * size_of_val(flat(&found.field));
        assert!(found.account.bytes < vectors(480 + 9) && scarce.account.bytes < vectors(61 + 9));
    }
    let [_, alone] = hard_in_vector_mode(2.7);
    let after = growing(480).solve(&p, goal, &mut Silent).expect("converges");
    let alone = growing(480).solve(&alone, goal, &mut Silent).expect("converges");
    assert_eq!(after.field, alone.field);
}

/// Scarce memory is shared between the first basis and the elimination.
/// *Planted*: all of it for the basis, with which restarts stall.
#[test]
fn scarce_memory_leaves_room_for_the_elimination() {
    let [s, _] = hard_in_vector_mode(2.7);
    let resolution = Resolution { nx: 16, ny: 16, cells: 14, scheme: Scheme::Quadratic };
    let layer_um = [0.8, 0.8, 0.9];
    let size = Size { resolution, channels: 1, crystals: 0, layer_um, wavenumbers: [0.0; 2], vector: true };
    let goal = Goal { tolerance: 1e-4, max_applications: 300 };
    let plan = VectorCoarsePlan::within(s.vector().expect("a vector wave"), f64::INFINITY);
    let elimination = plan.expect("a plan").bytes() / size_of_val(flat(&s.background_wave())) as f64;
    let vectors = elimination + SHORT_RESTART as f64 + 1.0;
    let bytes = size.fields(vectors + OTHER_VECTORS);
    assert!(vectors < Gmres::default().restart as f64, "scarce: {vectors} vectors");
    let fit = Gmres::default().demand(&size, bytes);
    assert!(fit.bytes <= bytes);
    let found = fit.solver.expect("a shorter basis").solve(&s, goal, &mut Silent).expect("converges");
    let with = found.account.operator_applications;
    let basis = Growing { settings: Gmres { restart: vectors as usize, ..Gmres::default() }, longest: 0 };
    let alone = basis.solve(&s, Goal { max_applications: 2000, ..goal }, &mut Silent);
    let alone = alone.map_or(2000, |solution| solution.account.operator_applications);
    assert!(2 * with < alone, "{with} applications, {alone} with all memory in the basis");
}

/// Weak scatterers of the vector wave are solved by whole cycles of plain GMRES, and what needs one
/// keeps the number of its steps. *Planted*: a trial for every vector wave.
#[test]
fn weak_scatterers_of_the_vector_wave_need_no_elimination() {
    let [s, _] = hard_in_vector_mode(1.85);
    let goal = Goal { tolerance: 1e-5, ..Goal::default() };
    let plain = Gmres::default().solve(&s, goal, &mut Silent).expect("converges").account;
    let grown = Growing { settings: Gmres::default(), longest: 900 };
    let grown = grown.solve(&s, goal, &mut Silent).expect("converges").account;
    assert!((13..60).contains(&plain.steps), "{}", plain.steps);
    assert_eq!(plain.steps, grown.steps);
    assert_eq!(plain.bytes, grown.bytes);
}

/// A solve that has not begun.
fn fresh<'a>(problem: &'a Problem, goal: Goal, silent: &'a mut Silent) -> KrylovRun<'a> {
    let ledger = Ledger::new("krylov", problem, goal, silent);
    let field = Field::zeros(problem.shape());
    let work = ledger.background.clone();
    KrylovRun { ledger, field, work, correction: None, single: None, restart: 60, first_cycle: true }
}

/// A solve whose lowest harmonics are eliminated at once.
fn eliminated(problem: &Problem, goal: Goal) -> Solution {
    let mut silent = Silent;
    let mut run = fresh(problem, goal, &mut silent);
    run.correction = Some(RightFactor::Coarse(CoarsePlan::new(problem).carried_out()));
    for _ in 0..10 {
        run.cycle(&Double(problem), 60).expect("goes on");
        if run.ledger.measure(&run.field, &mut run.work) <= goal.tolerance {
            break;
        }
    }
    run.ledger.finish(run.field)
}

/// Short recurrences stop at half of what the elimination costs, and never leave a worse field than
/// they found, nor a residual that is not the field's.
#[test]
fn short_recurrences_are_given_up_without_harm() {
    let problem = hard(2.6);
    let goal = Goal { tolerance: 1e-8, ..Goal::default() };
    for cost in [0.0, 6.0, 60.0] {
        let mut silent = Silent;
        let mut run = fresh(&problem, goal, &mut silent);
        run.ledger.note(1.0).expect("goes on");
        assert!(run.short_recurrences(Some(cost)).is_err());
        let stated = run.ledger.account.residual;
        let applications = run.ledger.account.operator_applications;
        // after the recurrence's own count, one measures the true residual
        assert!(applications as f64 <= 0.5 * cost + 2.0, "{applications} of {cost}");
        let true_residual = run.ledger.measure(&run.field, &mut run.work);
        assert!(stated <= 1.0 && (stated - true_residual).abs() < 1e-9, "{stated:e} {true_residual:e}");
    }
}

/// A small problem whose inner points of some cell resonate by themselves: in the grains a cell is
/// more than half a wave high, and the index is sought at which the residual after a cycle with the
/// elimination in single precision is largest. That residual and the problem.
fn spoilt_by_rounding() -> (f64, Problem) {
    let resolution = Resolution { nx: 8, ny: 8, cells: 8, scheme: Scheme::Cubic };
    let left = |index: f64| {
        let problem = hard_on(index, resolution);
        let mut silent = Silent;
        let mut run = fresh(&problem, Goal { tolerance: 1e-6, ..Goal::default() }, &mut silent);
        run.correction = Some(RightFactor::Coarse(CoarsePlan::new(&problem).carried_out()));
        run.cycle(&Double(&problem), 6).expect("goes on");
        run.ledger.measure(&run.field, &mut run.work)
    };
    let mut worst = (0.0, 2.6);
    let mut step = 0.01;
    for round in 0..9 {
        let middle = worst.1;
        let each = if round == 0 { -25..=20 } else { -3..=3 };
        for k in each {
            let index = middle + f64::from(k) * step;
            let residual = left(index);
            if residual > worst.0 {
                worst = (residual, index);
            }
        }
        step *= 0.3;
    }
    (worst.0, hard_on(worst.1, resolution))
}

/// Where rounding spoils the elimination in single precision, GMRES goes on with one in double
/// precision, and finds the solution of the dense system.
///
/// *Planted*: the second elimination left out, or what the first made of the field kept.
#[test]
fn an_elimination_spoilt_by_rounding_is_made_in_double_precision() {
    let (residual, problem) = spoilt_by_rounding();
    assert!(residual > 0.5, "{residual:e}");
    let goal = Goal { tolerance: 1e-6, max_applications: 120 };
    let off = GuidedModes { threshold: 0.0, ..GuidedModes::default() };
    let settings = Gmres { restart: 20, guided_modes: off };
    let found = Growing { settings, longest: 240 }.solve(&problem, goal, &mut Silent);
    let found = found.expect("converges");
    let truth = Direct::default().solve(&problem, Goal::default(), &mut Silent).expect("small");
    // the residual times a condition number of up to some hundreds
    let error = largest(&truth.field, &found.field);
    assert!(error < 1e-3, "{error:e}");

    let mut silent = Silent;
    let mut run = fresh(&problem, goal, &mut silent);
    let plan = CoarsePlan::new(&problem);
    let little = 1.9 * plan.bytes();
    run.correction = Some(RightFactor::Coarse(plan.carried_out()));
    run.cycle(&Double(&problem), 20).expect("goes on");
    run.ledger.measure(&run.field, &mut run.work);
    assert!(!run.eliminate_more(1.0, 20, little), "no memory for double precision");
    assert!(run.eliminate_more(1.0, 20, f64::INFINITY));
    assert!(matches!(run.correction, Some(RightFactor::Double(_))));
    assert!(run.ledger.account.residual <= 1.0);
}

/// What GMRES gives up is left to short recurrences, however bad the field.
///
/// *Planted*: a field without a residual kept.
#[test]
fn short_recurrences_are_the_last_resort() {
    let problem = hard_on(2.4, Resolution { nx: 8, ny: 8, cells: 8, scheme: Scheme::Cubic });
    let goal = Goal { tolerance: 1e-6, ..Goal::default() };
    let mut silent = Silent;
    let mut run = fresh(&problem, goal, &mut silent);
    run.correction = Some(RightFactor::Coarse(CoarsePlan::new(&problem).carried_out()));
    run.field.fill(Complex64::new(f64::NAN, 0.0));
    run.ledger.measure(&run.field, &mut run.work);
    let failure = run.ledger.not_converged("");
    run.last_resort(failure).expect("converges");
    assert!(run.ledger.measure(&run.field, &mut run.work) <= goal.tolerance);
}

/// Few harmonics of the vector wave eliminated do not help: then more are, as far as memory allows.
///
/// *Planted*: a plan that is no wider.
#[test]
fn more_harmonics_of_the_vector_wave_are_eliminated_where_few_do_not_help() {
    let [s, _] = hard_in_vector_mode(2.7);
    let problem = &s.problem;
    let goal = Goal { tolerance: 1e-10, ..Goal::default() };
    let mut silent = Silent;
    let ledger = Ledger::new("krylov", &s, goal, &mut silent);
    let field = Field::zeros(s.shape());
    let work = ledger.background.clone();
    let mut run =
        KrylovRun { ledger, field, work, correction: None, single: None, restart: 60, first_cycle: true };
    let few = VectorCoarsePlan::new(problem, 0.2);
    let wide = few.wider(problem, f64::INFINITY).expect("a wider plan");
    assert_eq!(few.wider(problem, 0.9 * wide.bytes()), None);
    run.correction = Some(RightFactor::Vector(problem, problem.eliminated(few)));
    run.cycle(&Double(&s), 12).expect("goes on");
    let before = run.ledger.measure(&run.field, &mut run.work);
    assert!(run.eliminate_more(1.0, 12, f64::INFINITY), "{before:e}");
    run.cycle(&Double(&s), 12).expect("goes on");
    let after = run.ledger.measure(&run.field, &mut run.work);
    assert!(after < 0.05 * before, "{before:e} → {after:e}");
    assert!(!run.eliminate_more(before, 12, 0.0), "no memory for more");
}
