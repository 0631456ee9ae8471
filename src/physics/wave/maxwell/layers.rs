//! Bodies inside others that the normal-field tensor allows: single spheres and convex bodies.

use super::sources::NormalField;
use crate::ink::Solid;
use crate::wave::{Ball, Body, BodyShape, Scene};

/// Largest distance between centres that counts as none, in radii of the inner sphere.
const ROUNDING: f64 = 1e-9;

/// What lies directly inside a body.
pub(super) enum Core {
    /// One sphere about the centre of the sphere around it, with N between them.
    Concentric(Ball, NormalField),
    /// The convex bodies, beginning with the outer one.
    Bodies(Vec<Solid>),
}

/// Whether every body inside another one and every body around one is convex.
pub(super) fn are_convex(scene: &Scene) -> bool {
    let mut inner = scene.bodies.iter().filter_map(|body| Some((body, body.within?)));
    inner.all(|(body, host)| convex(body).is_some() && convex(&scene.bodies[host]).is_some())
}

/// What lies directly inside every body; `None` where nothing does.
pub(super) fn cores(scene: &Scene) -> Vec<Option<Core>> {
    let mut inner: Vec<Vec<&Body>> = vec![Vec::new(); scene.bodies.len()];
    scene.bodies.iter().for_each(|body| body.within.iter().for_each(|&host| inner[host].push(body)));
    scene.bodies.iter().zip(inner).map(|(host, inner)| core_of(host, &inner, scene.period_um)).collect()
}

fn core_of(host: &Body, inner: &[&Body], period_um: [f64; 2]) -> Option<Core> {
    let mut bodies: Vec<Solid> = [host].into_iter().chain(inner.iter().copied()).filter_map(convex).collect();
    let (outer, cores) = bodies.split_first_mut()?;
    // Distances are those within one cell: of every core the image inside its host.
    for core in cores {
        for (axis, period) in period_um.into_iter().enumerate() {
            let apart = core.center_um[axis] - outer.center_um[axis];
            core.center_um[axis] -= period * (apart / period).round();
        }
    }
    (!inner.is_empty()).then(|| concentric(host, inner, period_um).unwrap_or(Core::Bodies(bodies)))
}

fn concentric(host: &Body, inner: &[&Body], period_um: [f64; 2]) -> Option<Core> {
    let (outer, &[core]) = (sphere(host)?, inner) else { return None };
    let core = sphere(core)?;
    let apart = |axis: usize| {
        let d = core.center_um[axis] - outer.center_um[axis];
        period_um.get(axis).map_or(d, |period| d - period * (d / period).round())
    };
    let same = (0..3).all(|axis| apart(axis).abs() <= ROUNDING * core.radius_um);
    same.then(|| Core::Concentric(core, NormalField::of_layer(core.radius_um, outer.radius_um)))
}

fn sphere(body: &Body) -> Option<Ball> {
    match &body.shape {
        BodyShape::Balls(balls) if balls.len() == 1 => Some(balls[0]),
        _ => None,
    }
}

fn convex(body: &Body) -> Option<Solid> {
    match &body.shape {
        BodyShape::Solid(solid) => Some(solid.clone()),
        _ => sphere(body).map(|ball| ball.solid()),
    }
}
