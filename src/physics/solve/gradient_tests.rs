use super::*;
use crate::ink::Sphere;
use crate::solve::{Gmres, Silent};
use crate::wave::{
    Body, BodyShape, Geometry, Incidence, Mean, Media, Precision, Resolution, Scene, Scheme, Wave,
};

const GOAL: Goal = Goal { tolerance: 1e-12, max_applications: 5000 };
const PIGMENT: Medium = Medium::Inclusion(0);

fn scene() -> Scene {
    let grains = [[0.10, 0.12, 0.15, 0.10], [0.42, 0.20, 0.30, 0.12], [0.25, 0.48, 0.18, 0.11]];
    let body = |[x, y, z, radius_um]: [f64; 4]| {
        Body::new(BodyShape::Balls(vec![Sphere { center_um: [x, y, z], radius_um }]), 0)
    };
    Scene::layer([0.6, 0.62], 0.5, grains.map(body).to_vec())
}

fn media(pigment: Complex64) -> Media {
    let backgrounds = vec![1.558.into()];
    Media { incident: 1.0.into(), exit: 1.3.into(), backgrounds, inclusions: vec![pigment] }
}

fn light(from: Side) -> Incidence {
    Incidence { wavelength_um: 0.5, polar_deg: 30.0, azimuth_deg: 25.0, from }
}

fn geometry(wave: Wave) -> Geometry {
    let resolution = Resolution { nx: 10, ny: 10, cells: 6, scheme: wave.scheme(Scheme::Cubic) };
    Geometry::new(wave, &scene(), resolution, Precision::EXACT).expect("a sound cell")
}

/// The systems of a pigment, s before p for the vector wave.
fn systems(geometry: &Geometry, pigment: Complex64, from: Side) -> Vec<Box<dyn System>> {
    geometry.systems(&media(pigment), &light(from), Mean::default()).expect("a sound problem")
}

fn solved(system: &dyn System) -> Field {
    Gmres::default().solve(system, GOAL, &mut Silent).expect("a small cell converges").field
}

fn totals(far: &FarField) -> [f64; 3] {
    [far.reflectance, far.transmittance, far.absorptance]
}

/// The tangent of polarisation `p`, from `count` neighbours.
fn tangent_of(geometry: &Geometry, pigment: Complex64, from: Side, p: usize, count: usize) -> FarSlopes {
    let system = systems(geometry, pigment, from).remove(p);
    let neighbour = |k: usize| {
        let step = 1e-4 * Complex64::I.powu((4 / count * k) as u32);
        Neighbour { step, system: systems(geometry, pigment + step, from).remove(p) }
    };
    let neighbours: Vec<Neighbour> = (0..count).map(neighbour).collect();
    let u = solved(&*system);
    tangent(&*system, &u, &neighbours, &Gmres::default(), GOAL, &mut Silent).expect("converges")
}

fn slopes_of(tangent: &FarSlopes) -> [Slopes; 3] {
    [tangent.reflectance, tangent.transmittance, tangent.absorptance]
}

/// Differences of fourth order of R, T and A along n (0) or κ (1).
fn differences(geometry: &Geometry, pigment: Complex64, p: usize, along: usize, h: f64) -> [f64; 3] {
    let direction = [Complex64::ONE, Complex64::I][along];
    let moved_by = |k: f64| {
        let system = systems(geometry, pigment + k * h * direction, Side::Incident).remove(p);
        totals(&system.far_field(&solved(&*system)))
    };
    let a = moved_by(-2.0);
    let b = moved_by(-1.0);
    let c = moved_by(1.0);
    let d = moved_by(2.0);
    std::array::from_fn(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h))
}

fn largest_error(geometry: &Geometry, pigment: Complex64, p: usize, h: f64) -> f64 {
    let slopes = slopes_of(&tangent_of(geometry, pigment, Side::Incident, p, 4));
    let error = |(along, i): (usize, usize)| {
        (differences(geometry, pigment, p, along, h)[i] - slopes[i][along]).abs()
    };
    (0..2).flat_map(|along| (0..3).map(move |i| (along, i))).map(error).fold(0.0, f64::max)
}

/// The differences take A from the field within the layer, the tangent from R and T.
#[test]
fn differences_fall_onto_the_tangent_with_the_fourth_power() {
    let pigment = Complex64::new(1.65, 0.08);
    for (wave, p) in [(Wave::Scalar, 0), (Wave::Unpolarised, 0), (Wave::Unpolarised, 1)] {
        let geometry = geometry(wave);
        // a guided resonance near η = 1.65 bounds the steps: the series' radius is 0.08
        let coarse = largest_error(&geometry, pigment, p, 1e-2);
        let fine = largest_error(&geometry, pigment, p, 5e-3);
        // order 4: 2⁴ but for terms of sixth order, (2h/0.08)² of it
        let ratio = coarse / fine;
        assert!((15.0..18.0).contains(&ratio), "{wave:?} {p}: {coarse:e} {fine:e}");
        // the rest at a small step, 2.5⁴ below that, of slopes of the order of 1
        let error = largest_error(&geometry, pigment, p, 2e-3);
        assert!(error < fine / 30.0 && error < 1e-9, "{wave:?} {p}: {error:e}");
    }
}

#[test]
fn the_tangent_conserves_energy_beside_a_resonance() {
    for (wave, p) in [(Wave::Scalar, 0), (Wave::Unpolarised, 0), (Wave::Unpolarised, 1)] {
        let own = tangent_of(&geometry(wave), 1.65.into(), Side::Incident, p, 4);
        // lossless: the residual 1e-12 times the height of the resonance, 10³ to 10⁴
        assert!(own.absorptance[0].abs() < 1e-7, "{wave:?} {p}: {own:?}");
        assert!(own.absorptance[1] > 0.1, "{wave:?} {p}: {own:?}");
        // the tangent's own step, 1e-4, is a tenth of the resonance's width: its fourth power
        let error = largest_error(&geometry(wave), 1.65.into(), p, 1e-5);
        assert!(error < 1e-5 * own.absorptance[1], "{wave:?} {p}: {error:e}");
    }
}

#[test]
fn two_neighbours_serve_as_well_as_four() {
    let pigment = Complex64::new(1.65, 0.08);
    let two = tangent_of(&geometry(Wave::Scalar), pigment, Side::Exit, 0, 2);
    let four = tangent_of(&geometry(Wave::Scalar), pigment, Side::Exit, 0, 4);
    for (a, b) in slopes_of(&two).iter().flatten().zip(slopes_of(&four).iter().flatten()) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn the_adjoint_of_one_functional_gives_the_tangent_of_every_medium() {
    let pigment = Complex64::new(1.65, 0.08);
    for (from, weights) in [(Side::Incident, [1.0, 0.0]), (Side::Exit, [0.3, 0.7])] {
        let system = systems(&geometry(Wave::Scalar), pigment, from).remove(0);
        let problem = system.split().expect("the scalar wave");
        let u = solved(problem);
        let w = adjoint(problem, &u, weights, &Gmres::default(), GOAL, &mut Silent).expect("converges");
        for medium in [PIGMENT, Medium::Background(0)] {
            let neighbour = |direction: Complex64| {
                let step = 1e-4 * direction;
                let system = Box::new(problem.moved(medium, step).expect("sound")) as Box<dyn System>;
                Neighbour { step, system }
            };
            let neighbours = crate::wave::DIRECTIONS.map(neighbour);
            let tangent = tangent(problem, &u, &neighbours, &Gmres::default(), GOAL, &mut Silent);
            let [r, t, _] = slopes_of(&tangent.expect("converges"));
            let adjoint = sensitivity(problem, &u, &w, medium).expect("sound");
            for i in 0..2 {
                let sum = weights[0] * r[i] + weights[1] * t[i];
                assert!((adjoint[i] - sum).abs() < 1e-8, "{medium:?} {i}: {} {sum}", adjoint[i]);
            }
        }
    }
}

/// da/dη of a reflected order = −wᵀ M′ u with w = J u₋/(2iκ), u₋ the ordinary solution of the
/// reversed order.
#[test]
fn the_reversed_direction_gives_every_order() {
    let pigment = Complex64::new(1.65, 0.08);
    let geometry = geometry(Wave::Scalar);
    let system = systems(&geometry, pigment, Side::Incident).remove(0);
    let problem = system.split().expect("the scalar wave");
    let u = solved(problem);
    let moved = problem.derivative(&u, PIGMENT).expect("sound");
    let tangent = tangent_of(&geometry, pigment, Side::Incident, 0, 4);
    let far = problem.far_field(&u);
    let mut compared = 0;
    for (order, slopes) in far.orders.iter().zip(&tangent.orders).filter(|(o, _)| o.reflected_propagates) {
        let [x, y] = order.direction;
        let polar_deg = x.hypot(y).asin().to_degrees();
        let azimuth_deg = (-y).atan2(-x).to_degrees();
        let back = Incidence { polar_deg, azimuth_deg, ..light(Side::Incident) };
        let Geometry::Scalar(coverage) = &geometry else { unreachable!("the scalar wave") };
        let back = Problem::new(coverage, &media(pigment), &back, Mean::default()).expect("sound");
        let w = problem.opposite(&solved(&back));
        let kappa = Complex64::I * 2.0 * back.incident_kappa();
        let slope = -w.iter().zip(&moved).map(|(w, m)| w * m).sum::<Complex64>() / kappa;
        let error = (slope - slopes.amplitudes[0][0]).norm();
        assert!(error < 1e-7, "({}, {}): {error:e}", order.m, order.n);
        compared += 1;
    }
    assert!(compared >= 3, "{compared} orders");
}

#[test]
fn the_transposed_operator_is_that_of_the_reversed_direction() {
    for pigment in [Complex64::new(1.65, 0.08), 1.65.into()] {
        let system = systems(&geometry(Wave::Scalar), pigment, Side::Incident).remove(0);
        let problem = system.split().expect("the scalar wave");
        let random = |seed: f64| {
            let mut k = seed;
            let mut next = || {
                k = (k * 7.13 + 0.37).fract();
                k - 0.5
            };
            Field::from_shape_simple_fn(problem.shape(), || Complex64::new(next(), next()))
        };
        let u = random(0.1);
        let v = random(0.7);
        let reversed = problem.reversed().expect("sound");
        let transposed = problem.opposite(&reversed.applied(&problem.opposite(&v)));
        let dot = |a: &Field, b: &Field| a.iter().zip(b).map(|(a, b)| a * b).sum::<Complex64>();
        let one = dot(&v, &problem.applied(&u));
        let other = dot(&transposed, &u);
        let scale: f64 = v.iter().zip(&problem.applied(&u)).map(|(a, b)| (a * b).norm()).sum();
        assert!((one - other).norm() < 1e-13 * scale, "{one} {other}");
    }
}
