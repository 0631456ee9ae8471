//! The reduced vector, its ties, and the labels of orders.

use super::*;
use crate::ink::Sphere;
use crate::wave::Coverage;
use crate::wave::{Body, BodyShape, Mean, Problem, Resolution, Scene, Scheme};
use std::sync::Arc;

fn coverage(resolution: [usize; 2], bodies: Vec<Body>) -> Arc<Coverage> {
    let scene = Scene::layer([0.8, 0.5], 0.3, bodies);
    let [nx, ny] = resolution;
    let resolution = Resolution { nx, ny, cells: 4, scheme: Scheme::Cubic };
    Arc::new(Coverage::new(&scene, resolution).expect("a valid scene"))
}

fn grain() -> Vec<Body> {
    let ball = Sphere { center_um: [0.2, 0.2, 0.15], radius_um: 0.1 };
    vec![Body::new(BodyShape::Balls(vec![ball]), 0)]
}

fn media() -> Media {
    Media {
        incident: 1.0.into(),
        exit: 1.5.into(),
        backgrounds: vec![1.5.into()],
        inclusions: vec![1.4.into()],
    }
}

fn light(sine: f64, azimuth_deg: f64, wavelength_um: f64) -> Incidence {
    Incidence { wavelength_um, polar_deg: sine.asin().to_degrees(), azimuth_deg, from: Side::Incident }
}

#[test]
fn vectors_are_reduced_to_the_zone_and_rebuilt_by_the_incident_order() {
    let coverage = coverage([9, 9], grain());
    for azimuth in [0.0, 37.0, 180.0, 250.0] {
        let light = light(0.9, azimuth, 0.45);
        let whole = light.lateral_wavevector(&media()).expect("a transparent half-space");
        let bloch = BlochVector::new(&coverage.layout, &media(), &light).expect("a vector");
        let rebuilt = bloch.lateral(bloch.incident);
        for i in 0..2 {
            assert!(bloch.reduced[i].abs() <= 0.5 * bloch.step[i] * (1.0 + 1e-8));
            // Identity: one product and one sum.
            assert!((rebuilt[i] - whole[i]).abs() < 1e-14 * whole[0].hypot(whole[1]), "{azimuth}°");
        }
        assert!(bloch.incident != [0, 0]);
    }
}

#[test]
fn opposite_waves_have_opposite_vectors_on_the_edge_of_the_zone_too() {
    let coverage = coverage([9, 9], grain());
    // sin σ = λ/(2L) exactly, and a rounding error to both sides.
    for sine in [0.5, 0.5 * (1.0 - 1e-15), 0.5 * (1.0 + 1e-15), 0.3] {
        let [one, other] = [0.0, 180.0].map(|azimuth| {
            BlochVector::new(&coverage.layout, &media(), &light(sine, azimuth, 0.8)).expect("a vector")
        });
        assert_eq!((one.incident, other.incident), ([0, 0], [0, 0]));
        assert!((one.reduced[0] + other.reduced[0]).abs() < 1e-14 * one.step[0]);
    }
    assert_eq!([0.5, 0.6, 1.5, 1.6, -0.5, -0.6, -1.5, 0.0].map(nearest_order), [0, 1, 1, 2, 0, -1, -1, 0]);
}

#[test]
fn without_a_lattice_nothing_is_reduced() {
    let coverage = coverage([4, 1], Vec::new());
    let light = light(0.9, 30.0, 0.2);
    let bloch = BlochVector::new(&coverage.layout, &media(), &light).expect("a vector");
    assert_eq!(bloch.incident, [0, 0]);
    assert_eq!(bloch.reduced, light.lateral_wavevector(&media()).expect("a transparent half-space"));
}

#[test]
fn grids_without_a_harmonic_for_a_propagating_order_are_refused_by_its_label() {
    // kx = 0.9 · 2π/0.45 = 1.6 steps: harmonic 2 − 0.4. Below, orders reach ±(1.5/0.45) · 0.8 =
    // 2.67 steps, that is harmonics −2 … 3 and labels −4 … 1.
    let light = light(0.9, 0.0, 0.45);
    let refused = |n: usize| {
        Problem::new(&coverage([n, 9], grain()), &media(), &light, Mean::default())
            .err()
            .map(|e| e.to_string())
    };
    let message = refused(6).expect("harmonics −2 … 2");
    assert!(message.contains("order (1, 0)") && message.contains("at least 7"), "{message}");
    assert_eq!(refused(7), None);
    let problem = Problem::new(&coverage([7, 9], grain()), &media(), &light, Mean::default()).expect("valid");
    assert_eq!(problem.harmonics.orders[problem.incident_harmonic], [2, 0]);
    let far = problem.far_field(&problem.background_wave());
    let along_x: Vec<i32> =
        far.orders.iter().filter(|o| o.n == 0 && o.transmitted_propagates).map(|o| o.m).collect();
    assert_eq!(along_x, [-4, -3, -2, -1, 0, 1]);
    // Identity: the specular order has the incident direction.
    assert!((far.specular().direction[0] - 0.9).abs() < 1e-14);
}
