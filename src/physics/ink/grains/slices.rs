//! Volumes of grains between horizontal planes.

use super::solid::Solid;
use super::sphere::Sphere;
use std::f64::consts::PI;

/// Lines per side on which a convex body is sampled.
const LINES: usize = 24;

/// Volume of a grain, µm³, in `slices` of equal height from z = 0: of the convex body where there
/// is one, else of the spheres, each counted by itself.
pub fn volumes(spheres: &[Sphere], solid: Option<&Solid>, height: f64, slices: usize) -> Vec<f64> {
    match solid {
        Some(solid) => of_solid(solid, height, slices),
        None => of_spheres(spheres, height, slices),
    }
}

/// Volume of a convex body in every slice, µm³, from its chords along z.
fn of_solid(solid: &Solid, height: f64, slices: usize) -> Vec<f64> {
    let extents = [0, 1].map(|axis| solid.extent_um(axis));
    let step = extents.map(|[low, high]| (high - low) / LINES as f64);
    let mut volumes = vec![0.0; slices];
    for line in 0..LINES * LINES {
        let at = |axis: usize, i: usize| extents[axis][0] + (i as f64 + 0.5) * step[axis];
        let from = [at(0, line % LINES), at(1, line / LINES), 0.0];
        let Some([low, high]) = solid.chord(from, [0.0, 0.0, 1.0]) else { continue };
        for (k, volume) in volumes.iter_mut().enumerate() {
            let [bottom, top] = [k, k + 1].map(|k| k as f64 * height);
            *volume += step[0] * step[1] * (high.min(top) - low.max(bottom)).max(0.0);
        }
    }
    volumes
}

/// Volume of spheres in every slice, µm³.
fn of_spheres(spheres: &[Sphere], height: f64, slices: usize) -> Vec<f64> {
    let within = |k: usize| {
        let [from, to] = [k, k + 1].map(|k| k as f64 * height);
        spheres.iter().map(|s| between(s, from, to)).sum()
    };
    (0..slices).map(within).collect()
}

/// Volume of a sphere between two heights, µm³.
fn between(sphere: &Sphere, from: f64, to: f64) -> f64 {
    let (z, r) = (sphere.center_um[2], sphere.radius_um);
    let [low, high] = [from, to].map(|height| (height - z).clamp(-r, r));
    PI * (r * r * (high - low) - (high.powi(3) - low.powi(3)) / 3.0)
}
