//! Bodies inside others, as far as the normal-field tensor reaches: concentric layers of spheres.

use crate::wave::{Ball, Body, BodyShape, Scene};

/// Largest distance between centres that counts as none, in radii of the inner sphere.
const ROUNDING: f64 = 1e-9;

/// Whether every body inside another one is its only one, and a sphere about the same centre.
pub(super) fn are_concentric(scene: &Scene) -> bool {
    let mut taken = vec![false; scene.bodies.len()];
    let mut inner = scene.bodies.iter().filter_map(|body| Some((body, body.within?)));
    inner.all(|(body, host)| {
        let first = !std::mem::replace(&mut taken[host], true);
        first && about_one_centre(body, &scene.bodies[host], scene.period_um)
    })
}

fn about_one_centre(inner: &Body, outer: &Body, period_um: [f64; 2]) -> bool {
    let (Some(a), Some(b)) = (sphere(inner), sphere(outer)) else { return false };
    let apart = |axis: usize| {
        let d = a.center_um[axis] - b.center_um[axis];
        period_um.get(axis).map_or(d, |period| d - period * (d / period).round())
    };
    (0..3).all(|axis| apart(axis).abs() <= ROUNDING * a.radius_um)
}

/// The ball directly inside every body.
pub(super) fn cores(scene: &Scene) -> Vec<Option<Ball>> {
    let mut cores = vec![None; scene.bodies.len()];
    let inner = scene.bodies.iter().filter_map(|body| Some((body.within?, sphere(body)?)));
    inner.for_each(|(host, ball)| cores[host] = Some(ball));
    cores
}

fn sphere(body: &Body) -> Option<Ball> {
    match &body.shape {
        BodyShape::Balls(balls) if balls.len() == 1 => Some(balls[0]),
        _ => None,
    }
}
