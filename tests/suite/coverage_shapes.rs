//! Unions and reliefs in the contrast field, against the same scene described in another way.

use inkwave::ink::Sphere;
use inkwave::ink::{Form, PackingRequest, PigmentGrains, ReliefRequest, RoughFace, Solid, pack};
use inkwave::numerics::vector::Rotation;
use inkwave::solve::accuracy::largest_difference;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{
    Body, BodyShape, FarField, HeightField, Incidence, Material, Mean, Media, Problem, Resolution, Scene,
    Scheme, Side, Stratum,
};
use num_complex::Complex64;

const PERIOD: [f64; 2] = [0.7, 0.7];

/// Binder, and as other strata the media of either side.
fn media() -> Media {
    let one = Complex64::ONE;
    let exit = Complex64::from(1.2);
    let inclusions = vec![Complex64::new(1.4, 0.05)];
    Media { incident: one, exit, backgrounds: vec![1.558.into(), one, exit], inclusions }
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

fn ball(x: f64, y: f64, z: f64, radius_um: f64) -> Sphere {
    Sphere { center_um: [x, y, z], radius_um }
}

fn grain(balls: Vec<Sphere>) -> Body {
    Body::new(BodyShape::Balls(balls), 0)
}

/// What is not a grain between a level and a face of the layer.
fn flat([z, face_um]: [f64; 2], balls: &[Sphere], solids: &[Solid]) -> Body {
    let surface = HeightField { z_um: vec![z], count: [1, 1], period_um: PERIOD };
    let material = if face_um == 0.0 { Material::Incident } else { Material::Exit };
    let shape = BodyShape::Open { surface, face_um, balls: balls.to_vec(), solids: solids.to_vec() };
    Body::of(shape, material)
}

/// Identity of descriptions: a flat relief as columns of vacuum, or as a stratum of vacuum whose interface is a node.
/// Both discretise the same layer differently, so they agree to their common error, which the estimates of such
/// resolutions put at 1e-3 and 1e-4; the second is the accuracy promised for the raster of a relief. Then upside down, with
/// the medium of the exit side. *Planted*: vacuum there, or the wrong side of the surface.
#[test]
fn flat_relief_is_a_stratum_of_vacuum() {
    let balls = vec![ball(0.2, 0.3, 0.15, 0.12), ball(0.5, 0.5, 0.45, 0.12)];
    let bodies: Vec<Body> = balls.iter().map(|&b| grain(vec![b])).collect();
    let stratum = |thickness_um, background| Stratum { thickness_um, background };
    let above = (vec![stratum(0.15, 1), stratum(0.45, 0)], [0.15, 0.0]);
    let below = (vec![stratum(0.45, 0), stratum(0.15, 2)], [0.45, 0.6]);
    for (strata, level) in [above, below] {
        let layered = Scene { period_um: PERIOD, strata, bodies: bodies.clone(), cut: false };
        let open = flat(level, &balls, &[]);
        let columns = Scene::layer(PERIOD, 0.6, bodies.iter().cloned().chain([open]).collect());
        let difference =
            |n, cells| largest_difference(&solve(&layered, n, cells), &solve(&columns, n, cells));
        let coarse = difference(16, 12);
        let fine = difference(24, 20);
        assert!(coarse < 1e-3 && fine < 1e-4, "{level:?}: {coarse:.1e} → {fine:.1e}");
    }
}

/// A packing whose binder is level on either face, against the strata that it consists of. *Planted*: the medium of the
/// other side, or the wrong face.
#[test]
fn a_packing_with_a_level_relief_is_its_strata() {
    for (face, exit) in [(RoughFace::Incident, false), (RoughFace::Exit, true)] {
        let request = PackingRequest {
            period_um: PERIOD,
            thickness_um: 0.6,
            pigments: vec![PigmentGrains::spheres(240.0, 0.2)],
            relief: Some(ReliefRequest { depth_um: 0.15, face, ..Default::default() }),
            ..Default::default()
        };
        let packing = pack(&request, &mut ()).expect("a packing");
        let scene = Scene::from_packing(&packing);
        let level = packing.relief().expect("a relief").mean_height_um();
        let stratum = |thickness_um, background| Stratum { thickness_um, background };
        let mut strata = vec![stratum(0.6 - level, if exit { 2 } else { 1 }), stratum(level, 0)];
        if exit {
            strata.reverse();
        }
        let grains = scene.bodies.iter().filter(|body| matches!(body.material, Material::Inclusion(_)));
        let layered = Scene { period_um: PERIOD, strata, bodies: grains.cloned().collect(), cut: false };
        let difference = largest_difference(&solve(&layered, 16, 12), &solve(&scene, 16, 12));
        assert!(difference < 1e-3, "{face:?}: {difference:.1e}");
    }
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
    let columns =
        Scene::layer(PERIOD, 0.6, bodies.into_iter().chain([flat([0.15, 0.0], &[], &solids)]).collect());
    let difference = |n, cells| largest_difference(&solve(&layered, n, cells), &solve(&columns, n, cells));
    let coarse = difference(16, 12);
    let fine = difference(24, 20);
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
        let balls = (0..5).map(|i| Sphere { center_um: centre(i), radius_um: 0.1 }).collect();
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
    let x = orders(&along(0), 30.0);
    let y = orders(&along(1), 60.0);
    for a in &x.orders {
        let b = y.orders.iter().find(|b| b.m == a.n && b.n == a.m).expect("the transposed order");
        let difference = (a.reflected - b.reflected).norm().max((a.transmitted - b.transmitted).norm());
        assert!(difference < 1e-8, "({}, {}): {difference:.1e}", a.m, a.n);
    }
}
