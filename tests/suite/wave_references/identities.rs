//! What holds at any resolution: energy, reciprocity, and the symmetries of space.

use super::support::*;
use inkwave::input::case::Case;
use inkwave::wave::{BodyShape, Incidence, Order, Resolution, Scheme, Side};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Residual of the solves below; identities of two solves hold to some ten of it (trapped waves amplify a little).
const RESIDUAL: f64 = 1e-11;
const TWO_SOLVES: f64 = 1e-9;

/// Coarse on purpose: identities do not wait for convergence.
fn coarse(reference: &Reference, scheme: Scheme) -> Resolution {
    let scene = &reference.case.scene;
    let points = ((scene.period_um[0] * 13.0).ceil() as usize).max(7);
    let cells = (scene.thickness_um() * 15.0).ceil() as usize;
    reference.resolution(points, cells.max(scene.strata.len()), scheme)
}

#[test]
fn energy_is_balanced_to_the_residual_at_any_resolution() {
    for reference in references() {
        for scheme in [Scheme::Cubic, Scheme::Tents, Scheme::SecondDifference] {
            let mut resolution = coarse(reference, scheme);
            if reference.id.starts_with("lam10") {
                (resolution.nx, resolution.cells) = (40, 60);
            }
            let solved = solve_at(&reference.case, resolution, 1e-7);
            // Identity: A is the imaginary part of the same quadratic form; 1e-13 is rounding where the residual is 0.
            // The residual is measured after the mean operator's inverse; a metal's mean is some hundred times stiffer.
            let factor = if reference.kind == "lamellar2d_metal" { 1000.0 } else { 10.0 };
            let bound = factor * solved.account.residual + 1e-13;
            let error = solved.far.energy_error();
            assert!(error.abs() <= bound, "{} {scheme:?}: {error:e} against {bound:e}", reference.id);
        }
    }
}

#[test]
fn lossless_layers_absorb_nothing() {
    for id in ["inka1", "sph05", "sph11", "cyl01", "lam01"] {
        let solved = solve_at(&reference(id).case, coarse(reference(id), Scheme::Cubic), RESIDUAL);
        // Identity: the quadratic form of a Hermitian matrix is real, whatever the field.
        assert!(solved.far.absorptance.abs() < 1e-12, "{id}: {:e}", solved.far.absorptance);
        assert!((solved.far.reflectance + solved.far.transmittance - 1.0).abs() < 100.0 * RESIDUAL, "{id}");
    }
}

/// Light along −(kx, ky), in units of k0, from one side.
fn against(direction: [f64; 2], from: Side, light: &Incidence) -> Incidence {
    let [x, y] = direction;
    let polar_deg = x.hypot(y).asin().to_degrees();
    Incidence { polar_deg, azimuth_deg: (-y).atan2(-x).to_degrees(), from, ..*light }
}

/// |κ_o R(o ← i) − κ_i R(−i ← −o)| and the same for T with the reversed light from below, over all orders.
fn irreciprocity(reference: &Reference, resolution: Resolution) -> f64 {
    let there = solve_at(&reference.case, resolution, RESIDUAL);
    let cos = |[x, y]: [f64; 2]| (1.0 - x * x - y * y).sqrt();
    let incident = cos(there.far.specular().direction);
    let error = |o: &Order| {
        let back = |from: Side| {
            let light = against(o.direction, from, &reference.case.incidence);
            let case = Case { incidence: light, ..reference.case.clone() };
            *order(&solve_at(&case, resolution, RESIDUAL).far, o.m, o.n)
        };
        let reflected = cos(o.direction) * o.reflected - incident * back(Side::Incident).reflected;
        let transmitted = cos(o.direction) * o.transmitted - incident * back(Side::Exit).transmitted;
        reflected.norm().max(transmitted.norm())
    };
    there.far.orders.iter().filter(|o| o.reflected_propagates).map(error).fold(0.0, f64::max)
}

#[test]
fn light_finds_its_way_back() {
    for id in ["sph06", "sph14", "inka4", "cyl03"] {
        let reference = reference(id);
        let error = irreciprocity(reference, coarse(reference, Scheme::Cubic));
        // Identity: both directions use the same harmonics, mirrored.
        assert!(error < TWO_SOLVES, "{id}: {error:e}");
    }
}

/// The layer upside down, lit from the other side.
fn upside_down(case: &Case) -> Case {
    let height = case.scene.thickness_um();
    let flip = |[a, b]: [f64; 2]| [height - b, height - a];
    let mut flipped = case.clone();
    flipped.scene.strata.reverse();
    for body in &mut flipped.scene.bodies {
        match &mut body.shape {
            BodyShape::Balls(balls) => {
                balls.iter_mut().for_each(|b| b.center_um[2] = height - b.center_um[2])
            }
            BodyShape::CylinderY { z_um, .. } => *z_um = height - *z_um,
            BodyShape::BarY { z_um, .. } | BodyShape::Sheet { z_um } => *z_um = flip(*z_um),
            BodyShape::Solid(_) | BodyShape::Open { .. } => unreachable!("in no reference"),
        }
    }
    std::mem::swap(&mut flipped.media.incident, &mut flipped.media.exit);
    flipped.incidence.from = match case.incidence.from {
        Side::Incident => Side::Exit,
        Side::Exit => Side::Incident,
    };
    flipped
}

#[test]
fn light_from_below_sees_the_mirrored_scene() {
    for id in ["sph06", "sph11", "inkb3", "cyl07", "lam03", "multi05"] {
        let reference = reference(id);
        let mut case = reference.case.clone();
        case.media.exit = 1.33.into();
        let resolution = coarse(reference, Scheme::Cubic);
        let above = solve_at(&case, resolution, RESIDUAL);
        let below = solve_at(&upside_down(&case), resolution, RESIDUAL);
        let error = largest_difference(&above.far, &below.far, |m, n| (m, n));
        assert!(error < TWO_SOLVES, "{id}: {error:e}");
    }
}

#[test]
fn turning_scene_and_light_by_a_right_angle_changes_nothing() {
    for id in ["sph06", "sph14", "inka4"] {
        let reference = reference(id);
        let mut turned = reference.case.clone();
        turned.incidence.azimuth_deg += 90.0;
        for body in &mut turned.scene.bodies {
            let BodyShape::Balls(balls) = &mut body.shape else { unreachable!("cases of balls only") };
            balls.iter_mut().for_each(|b| {
                let [x, y, z] = b.center_um;
                b.center_um = [-y, x, z];
            });
        }
        let mut resolution = coarse(reference, Scheme::Cubic);
        resolution.ny += 1;
        let straight = solve_at(&reference.case, resolution, RESIDUAL);
        (resolution.nx, resolution.ny) = (resolution.ny, resolution.nx);
        let turned = solve_at(&turned, resolution, RESIDUAL);
        let error = largest_difference(&straight.far, &turned.far, |m, n| (-n, m));
        // Coverage is accurate to 1e-10 of the contrast, and the two are computed from other positions.
        assert!(error < TWO_SOLVES, "{id}: {error:e}");
    }
}

#[test]
fn a_doubled_cell_with_four_copies_is_the_same_layer() {
    for id in ["sph06", "sph02"] {
        let reference = reference(id);
        let resolution = coarse(reference, Scheme::Cubic);
        let mut case = reference.case.clone();
        // Inside both cells' Brillouin zones, so that both use the same harmonics.
        case.incidence.polar_deg *= 0.25;
        let single = solve_at(&case, resolution, RESIDUAL);
        let [lx, ly] = case.scene.period_um;
        case.scene.period_um = [2.0 * lx, 2.0 * ly];
        case.scene.bodies = [[0.0, 0.0], [lx, 0.0], [0.0, ly], [lx, ly]]
            .iter()
            .flat_map(|shift| {
                reference.case.scene.bodies.iter().map(move |body| {
                    let mut copy = body.clone();
                    let BodyShape::Balls(balls) = &mut copy.shape else {
                        unreachable!("cases of balls only")
                    };
                    balls.iter_mut().for_each(|b| (0..2).for_each(|i| b.center_um[i] += shift[i]));
                    copy
                })
            })
            .collect();
        let doubled_grid = Resolution { nx: 2 * resolution.nx, ny: 2 * resolution.ny, ..resolution };
        let doubled = solve_at(&case, doubled_grid, RESIDUAL);
        // Identity: the grids have the same points and the same harmonics; orders between them stay dark.
        for o in &single.far.orders {
            let Some(p) = doubled.far.orders.iter().find(|p| (p.m, p.n) == (2 * o.m, 2 * o.n)) else {
                assert!(!o.reflected_propagates, "{id}: order ({}, {}) is missing", o.m, o.n);
                continue;
            };
            let error = (o.reflected - p.reflected).norm().max((o.transmitted - p.transmitted).norm());
            assert!(error < TWO_SOLVES, "{id} ({}, {}): {error:e}", o.m, o.n);
        }
        let between = doubled.far.orders.iter().filter(|o| o.m % 2 != 0 || o.n % 2 != 0);
        assert!(between.clone().count() > 0);
        between.for_each(|o| assert!(o.reflected.norm().max(o.transmitted.norm()) < TWO_SOLVES));
    }
}

#[test]
fn moving_the_grains_turns_the_phases_of_the_orders() {
    let reference = reference("inkb2");
    let resolution = coarse(reference, Scheme::Cubic);
    let still = solve_at(&reference.case, resolution, RESIDUAL);
    let mut case = reference.case.clone();
    // Whole points of the grid: the discrete problem is the same but for phases.
    let period = case.scene.period_um;
    let shift = [3.0 * period[0] / resolution.nx as f64, -2.0 * period[1] / resolution.ny as f64];
    for body in &mut case.scene.bodies {
        let BodyShape::Balls(balls) = &mut body.shape else { unreachable!("cases of balls only") };
        balls.iter_mut().for_each(|b| (0..2).for_each(|i| b.center_um[i] += shift[i]));
    }
    let moved = solve_at(&case, resolution, RESIDUAL);
    for o in &still.far.orders {
        let p = order(&moved.far, o.m, o.n);
        let turn = -TAU * (f64::from(o.m) * shift[0] / period[0] + f64::from(o.n) * shift[1] / period[1]);
        let phase = Complex64::cis(turn);
        let error =
            (o.reflected * phase - p.reflected).norm().max((o.transmitted * phase - p.transmitted).norm());
        assert!(error < TWO_SOLVES, "({}, {}): {error:e}", o.m, o.n);
    }
}
