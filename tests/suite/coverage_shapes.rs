//! Unions and reliefs in the contrast field, against the same scene described in another way.

use inkwave::ink::{Form, Solid};
use inkwave::numerics::Rotation;
use inkwave::solve::accuracy::largest_difference;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{
    Ball, Body, BodyShape, FarField, HeightField, Incidence, Material, Mean, Media, Problem, Resolution,
    Scene, Scheme, Side, Stratum,
};
use num_complex::Complex64;

const PERIOD: [f64; 2] = [0.7, 0.7];

fn media() -> Media {
    let one = Complex64::ONE;
    let inclusions = vec![Complex64::new(1.4, 0.05)];
    Media { incident: one, exit: one, backgrounds: vec![1.558.into(), one], inclusions }
}

fn solve(scene: &Scene, points: usize, cells: usize) -> FarField {
    let resolution = Resolution { nx: points, ny: points, cells, scheme: Scheme::Cubic };
    let incidence =
        Incidence { wavelength_um: 0.55, polar_deg: 20.0, azimuth_deg: 30.0, from: Side::Incident };
    let problem =
        Problem::from_scene(scene, &media(), &incidence, resolution, Mean::default()).expect("problem");
    let goal = Goal { tolerance: 1e-9, ..Goal::default() };
    let solution = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges");
    problem.far_field(&solution.field)
}

fn ball(x: f64, y: f64, z: f64, radius_um: f64) -> Ball {
    Ball { center_um: [x, y, z], radius_um }
}

fn grain(balls: Vec<Ball>) -> Body {
    Body::new(BodyShape::Balls(balls), 0)
}

fn flat(z: f64, balls: &[Ball], solids: &[Solid]) -> Body {
    let surface = HeightField { z_um: vec![z], count: [1, 1], period_um: PERIOD };
    Body {
        shape: BodyShape::Above { surface, balls: balls.to_vec(), solids: solids.to_vec() },
        material: Material::Incident,
        within: None,
    }
}

/// Identity of descriptions: a flat relief as columns of vacuum, or as a stratum of vacuum whose interface is a node.
/// Both discretise the same layer differently, so they agree to their common error, which the estimates of such
/// resolutions put at 1e-3 and 1e-4; the second is the accuracy promised for the raster of a relief.
#[test]
fn flat_relief_is_a_stratum_of_vacuum() {
    let balls = vec![ball(0.2, 0.3, 0.15, 0.12), ball(0.5, 0.5, 0.45, 0.12)];
    let bodies: Vec<Body> = balls.iter().map(|&b| grain(vec![b])).collect();
    let stratum = |thickness_um, background| Stratum { thickness_um, background };
    let strata = vec![stratum(0.15, 1), stratum(0.45, 0)];
    let layered = Scene { period_um: PERIOD, strata, bodies: bodies.clone(), cut: false };
    let columns = Scene::layer(PERIOD, 0.6, bodies.into_iter().chain([flat(0.15, &balls, &[])]).collect());
    let difference = |n, cells| largest_difference(&solve(&layered, n, cells), &solve(&columns, n, cells));
    let (coarse, fine) = (difference(16, 12), difference(24, 20));
    assert!(coarse < 1e-3 && fine < 1e-4, "{coarse:.1e} → {fine:.1e}");
}

/// The same with a lying ellipsoid and a tilted box, across the period's edge, that protrude from the surface. Edges
/// make the plane converge as the points to the power −2: a bound of its own. *Planted*: bodies that are open to the
/// vacuum, or cut at the edge.
#[test]
fn convex_bodies_protrude_from_a_relief() {
    let ellipsoid = Form::Ellipsoid { semi_axes_um: [0.12, 0.09, 0.15] };
    let solids = [
        Solid { form: ellipsoid, rotation: Rotation([0.8, 0.2, 0.4, 0.4]), center_um: [0.05, 0.3, 0.17] },
        Solid {
            form: Form::cuboid([0.2, 0.14, 0.18]),
            rotation: Rotation([0.4, 0.8, -0.2, 0.4]),
            center_um: [0.45, 0.6, 0.2],
        },
    ];
    let bodies: Vec<Body> = solids.iter().map(|s| Body::new(BodyShape::Solid(s.clone()), 0)).collect();
    let stratum = |thickness_um, background| Stratum { thickness_um, background };
    let strata = vec![stratum(0.15, 1), stratum(0.45, 0)];
    let layered = Scene { period_um: PERIOD, strata, bodies: bodies.clone(), cut: false };
    let columns = Scene::layer(PERIOD, 0.6, bodies.into_iter().chain([flat(0.15, &[], &solids)]).collect());
    let difference = |n, cells| largest_difference(&solve(&layered, n, cells), &solve(&columns, n, cells));
    let (coarse, fine) = (difference(16, 12), difference(24, 20));
    assert!(coarse < 1e-3 && fine < 1e-4, "{coarse:.1e} → {fine:.1e}");
}

/// Identity: a ball inside another adds nothing to their union, and two equal balls in one place are one.
#[test]
fn hidden_and_doubled_balls_count_once() {
    let scene = |balls| Scene::layer(PERIOD, 0.6, vec![grain(balls)]);
    let big = ball(0.3, 0.3, 0.3, 0.2);
    let alone = solve(&scene(vec![big]), 12, 8);
    let doubled = solve(&scene(vec![big, big]), 12, 8);
    let hidden = solve(&scene(vec![big, ball(0.33, 0.28, 0.31, 0.1)]), 12, 8);
    // The union's quadrature in z differs from the single ball's; both are made for 1e-9 in coefficients.
    assert!(largest_difference(&alone, &doubled) < 1e-7, "{:.1e}", largest_difference(&alone, &doubled));
    assert!(largest_difference(&alone, &hidden) < 1e-7, "{:.1e}", largest_difference(&alone, &hidden));
}

/// Identity under x ↔ y with the azimuth swapped: a tilted chain of five overlapping balls along either axis, where
/// cuts, arcs and harmonics change roles. The bound is the residual's, with room for its amplification.
#[test]
fn chains_are_treated_alike_along_x_and_y() {
    let along = |axis: usize| {
        let centre = |i: usize| {
            let mut c = [0.35, 0.35, 0.3];
            c[axis] += 0.07 * (i as f64 - 2.0);
            c[2] += 0.02 * (i as f64 - 2.0);
            c
        };
        let balls = (0..5).map(|i| Ball { center_um: centre(i), radius_um: 0.1 }).collect();
        Scene::layer(PERIOD, 0.6, vec![grain(balls)])
    };
    let orders = |scene: &Scene, azimuth_deg| {
        let resolution = Resolution { nx: 12, ny: 12, cells: 8, scheme: Scheme::Cubic };
        let incidence = Incidence { wavelength_um: 0.55, polar_deg: 20.0, azimuth_deg, from: Side::Incident };
        let problem =
            Problem::from_scene(scene, &media(), &incidence, resolution, Mean::default()).expect("problem");
        let goal = Goal { tolerance: 1e-10, ..Goal::default() };
        problem.far_field(&Gmres::default().solve(&problem, goal, &mut Silent).expect("converges").field)
    };
    let (x, y) = (orders(&along(0), 30.0), orders(&along(1), 60.0));
    for a in &x.orders {
        let b = y.orders.iter().find(|b| b.m == a.n && b.n == a.m).expect("the transposed order");
        let difference = (a.reflected - b.reflected).norm().max((a.transmitted - b.transmitted).norm());
        assert!(difference < 1e-8, "({}, {}): {difference:.1e}", a.m, a.n);
    }
}
