//! What holds exactly on any grid, and what the geometry's symmetries demand. Residuals of 1e-10; the bound of two solves
//! is 1e-8: amplitudes follow the residual up to a factor of some ten.

use inkwave::input::case::Case;
use inkwave::solve::accuracy::largest_of_all;
use inkwave::wave::maxwell::Averaging;
use inkwave::wave::{BodyShape, FarField, Incidence, Mean, Order, Side};
use inkwave_validation::vector::*;
use num_complex::Complex64;

const RESIDUAL: f64 = 1e-10;
const TWO_SOLVES: f64 = 1e-8;

/// Identity: V is real symmetric without absorption, whatever the resolution; contrast up to 2.6.
#[test]
fn lossless_layers_keep_the_energy() {
    for id in ["vsph01", "vsph05", "vink01", "vlam02", "vcyl02"] {
        let solved = solve(&reference(id).case, 9, 12, RESIDUAL);
        for (error, absorbed) in solved.far.iter().map(|far| (far.energy_error(), far.absorptance)) {
            assert!(
                error.abs() < TWO_SOLVES && absorbed.abs() < TWO_SOLVES,
                "{id}: {error:.1e} {absorbed:.1e}"
            );
        }
    }
}

/// Identity: A is the volume integral of the loss, the contrast's and the mean's, and closes the balance with any mean.
#[test]
fn absorption_in_the_volume_closes_the_balance() {
    for (id, absorbing) in
        ["vsph02", "vsph03", "vink02", "vlam01"].into_iter().flat_map(|id| [(id, true), (id, false)])
    {
        let mean = Mean { absorbing, ..Mean::default() };
        let solved = solve_as(&reference(id).case, 9, 12, RESIDUAL, mean, Averaging::Normal);
        for (error, absorbed) in solved.far.iter().map(|far| (far.energy_error(), far.absorptance)) {
            assert!(error.abs() < TWO_SOLVES && absorbed > 0.05, "{id}: {error:.1e} {absorbed}");
        }
    }
}

/// The wave that runs against an outgoing order.
fn against([x, y]: [f64; 2], from: Side, light: &Incidence) -> Incidence {
    let polar_deg = x.hypot(y).asin().to_degrees();
    Incidence { polar_deg, azimuth_deg: (-y).atan2(-x).to_degrees(), from, ..*light }
}

/// Identity: κ_o X_ba(o ← i) = σ_a σ_b κ_i X_ab(−i ← −o), σ_s = −1, σ_p = +1; harmonics are centred on zero and V is
/// symmetric, so both directions are one matrix and its transpose.
#[test]
fn polarised_light_finds_its_way_back() {
    for id in ["vsph02", "vsph04"] {
        let case = &reference(id).case;
        let there = solve(case, 9, 12, RESIDUAL).far;
        let cosine = |o: &Order| -> f64 { (1.0 - o.direction[0].powi(2) - o.direction[1].powi(2)).sqrt() };
        let incident = cosine(order(&there, 0, 0)[0]);
        for o in there[0].orders.iter().filter(|o| o.reflected_propagates).take(4) {
            let to = pairs(order(&there, o.m, o.n));
            for from in [Side::Incident, Side::Exit] {
                let incidence = against(o.direction, from, &case.incidence);
                let back = solve(&Case { incidence, ..case.clone() }, 9, 12, RESIDUAL).far;
                let side = usize::from(from == Side::Exit);
                let to = to[side];
                let fro = pairs(order(&back, o.m, o.n))[side];
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let sign = if a == b { 1.0 } else { -1.0 };
                    let error: Complex64 = cosine(o) * to[a][b] - sign * incident * fro[b][a];
                    let error = error.norm();
                    assert!(error < TWO_SOLVES, "{id} ({}, {}) {from:?} {a}{b}: {error:.1e}", o.m, o.n);
                }
            }
        }
    }
}

/// Largest difference of amplitudes, where `map` gives the other field's (m, n) and the signs of s → p and p → s.
fn difference(a: &[FarField], b: &[FarField], map: impl Fn(i32, i32) -> (i32, i32), cross: f64) -> f64 {
    let sign = |i: usize, j: usize| if i == j { 1.0 } else { cross };
    let mut largest = 0.0_f64;
    for o in a[0].orders.iter().filter(|o| o.reflected_propagates || o.transmitted_propagates) {
        let (m, n) = map(o.m, o.n);
        let own = pairs(order(a, o.m, o.n));
        let other = pairs(order(b, m, n));
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for (own, other) in own.into_iter().zip(other) {
                largest = largest.max((own[i][j] - sign(i, j) * other[i][j]).norm());
            }
        }
    }
    largest
}

fn move_balls(case: &mut Case, place: impl Fn([f64; 3]) -> [f64; 3]) {
    for body in &mut case.scene.bodies {
        let BodyShape::Balls(balls) = &mut body.shape else { unreachable!("cases of balls only") };
        balls.iter_mut().for_each(|b| b.center_um = place(b.center_um));
    }
}

/// Symmetry: a quarter turn of scene and light changes no amplitude, since s and p turn with the light.
#[test]
fn a_quarter_turn_changes_nothing() {
    for id in ["vsph02", "vsph04"] {
        let mut turned = reference(id).case.clone();
        turned.incidence.azimuth_deg += 90.0;
        move_balls(&mut turned, |[x, y, z]| [-y, x, z]);
        let straight = solve(&reference(id).case, 9, 12, RESIDUAL).far;
        let turned = solve(&turned, 9, 12, RESIDUAL).far;
        let error = difference(&straight, &turned, |m, n| (-n, m), 1.0);
        assert!(error < TWO_SOLVES, "{id}: {error:.1e}");
    }
}

/// Symmetry: the mirror y → −y turns s over, so that s → p and p → s change sign.
#[test]
fn a_mirror_turns_cross_polarisation_over() {
    for id in ["vsph02", "vsph04"] {
        let mut mirrored = reference(id).case.clone();
        mirrored.incidence.azimuth_deg *= -1.0;
        move_balls(&mut mirrored, |[x, y, z]| [x, -y, z]);
        let straight = solve(&reference(id).case, 9, 12, RESIDUAL).far;
        let mirrored = solve(&mirrored, 9, 12, RESIDUAL).far;
        let error = difference(&straight, &mirrored, |m, n| (m, -n), -1.0);
        assert!(error < TWO_SOLVES, "{id}: {error:.1e}");
    }
}

/// Symmetry: light from the exit side on the scene upside down; P(±) → −P(∓) while s stays, so s → p and p → s turn over.
#[test]
fn light_from_the_exit_side_sees_the_scene_upside_down() {
    for id in ["vsph02", "vsph04"] {
        let mut upright = reference(id).case.clone();
        upright.media.exit = 1.33.into();
        let mut flipped = upright.clone();
        let height = flipped.scene.thickness_um();
        move_balls(&mut flipped, |[x, y, z]| [x, y, height - z]);
        std::mem::swap(&mut flipped.media.incident, &mut flipped.media.exit);
        flipped.incidence.from = Side::Exit;
        let upright = solve(&upright, 9, 12, RESIDUAL).far;
        let flipped = solve(&flipped, 9, 12, RESIDUAL).far;
        let error = difference(&upright, &flipped, |m, n| (m, n), -1.0);
        assert!(error < TWO_SOLVES, "{id}: {error:.1e}");
    }
}

/// Accuracy asked for, 1e-4 in both codes: in y-invariant cells at φ = 0 s light obeys the scalar equation; s turns over
/// with k_x.
#[test]
fn s_light_on_gratings_is_the_scalar_wave() {
    for id in ["vlam01", "vcyl01"] {
        let case = &reference(id).case;
        let vector = solve_to(case, 1e-4).unwrap_or_else(|e| panic!("{id}: {e}")).far_fields;
        let scalar = inkwave_validation::support::solve_to(case, 1e-4)
            .unwrap_or_else(|e| panic!("{id}: {e}"))
            .far_fields
            .remove(0);
        for o in scalar.orders.iter().filter(|o| o.reflected_propagates) {
            let [own, _] = order(&vector, o.m, o.n);
            let sign = if o.direction[0] < 0.0 { -1.0 } else { 1.0 };
            let error = |vector: Complex64, scalar: Complex64| (vector - sign * scalar).norm();
            let error = error(own.reflected, o.reflected).max(error(own.transmitted, o.transmitted));
            assert!(error < 2e-4, "{id} order {}: {error:.1e}", o.m);
            assert!(own.further[0][0].norm() < 1e-12, "no cross polarisation without a tilt");
        }
    }
}

/// Neither κ = 0 (a Rayleigh anomaly: the order ±1 along the surface) nor kz = 0 in a cell divides by zero: amplitudes are
/// finite there and continuous across it to the square root of the step, some 1e-4 for 1e-9.
#[test]
fn rayleigh_anomalies_are_finite_and_continuous() {
    let mut case = reference("vsph01").case.clone();
    case.scene.period_um = [0.55, 0.55];
    let at = |period: f64| {
        let mut case = case.clone();
        case.incidence.wavelength_um = period;
        solve(&case, 9, 8, RESIDUAL).far
    };
    let before = at(0.55 - 1e-9);
    let on = at(0.55);
    let after = at(0.55 + 1e-9);
    for (m, n) in [(0, 0), (1, 0), (0, -1)] {
        let before = order(&before, m, n)[1].reflected;
        let on = order(&on, m, n)[1].reflected;
        let after = order(&after, m, n)[1].reflected;
        assert!(on.is_finite() && (before - on).norm() < 1e-3 && (after - on).norm() < 1e-3);
    }
}

/// ε̄ is a choice of the discretisation: real and complex means agree to its error, here 1e-3.
#[test]
fn the_mean_is_a_matter_of_steps_only() {
    let case = &reference("vsph02").case;
    let solved = |mean: Mean| solve_as(case, 15, 16, 1e-6, mean, Averaging::Normal).far;
    let complex = solved(Mean::default());
    let real = solved(Mean { absorbing: false, ..Mean::default() });
    assert!(largest_of_all(&complex, &real) < 1e-3);
}
