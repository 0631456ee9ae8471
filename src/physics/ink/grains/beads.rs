//! Spheres of grains that are made of them: chains along an axis, and clusters turned to theirs.

use crate::ink::Sphere;
use crate::numerics::vector::{V3, add, norm, scale, sub, unit};

pub(super) fn bead(z: f64, radius: f64) -> Sphere {
    Sphere { center_um: [0.0, 0.0, z], radius_um: radius }
}

/// A chain of `n` spheres between −reach and reach; `radius` is a function of the position from −1
/// to 1.
pub(super) fn chain(n: usize, reach: f64, radius: impl Fn(f64) -> f64) -> Vec<Sphere> {
    let at = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let beads: Vec<Sphere> = (0..n).map(|i| bead(reach * at(i), radius(at(i)))).collect();
    let thickest = beads.iter().map(|s| s.radius_um).fold(0.0, f64::max);
    beads.iter().map(|s| bead(s.center_um[2] / thickest, s.radius_um / thickest)).collect()
}

/// The largest sphere centred at z on the axis inside the ellipsoid (1, 1, a) has r² = 1 − z²/(a² −
/// 1), up to the sphere that osculates the tip at z = (a² − 1)/a.
pub(super) fn inscribed(a: f64, n: usize) -> Vec<Sphere> {
    let squared = a * a - 1.0;
    chain(n, squared / a, |t| (1.0 - t * t * squared / (a * a)).sqrt())
}

/// Moves the cluster's centre of mass to the origin, rotates its longest principal axis to z,
/// scales it to thickest radius 1.
pub(super) fn centred(rows: &[[f64; 4]]) -> Vec<Sphere> {
    let thickest = rows.iter().map(|s| s[3]).fold(0.0, f64::max);
    let weight = |s: &[f64; 4]| (s[3] / thickest).powi(3);
    let total: f64 = rows.iter().map(weight).sum();
    let centre = rows.iter().fold([0.0; 3], |c, s| add(c, scale([s[0], s[1], s[2]], weight(s) / total)));
    let arms: Vec<V3> = rows.iter().map(|s| scale(sub([s[0], s[1], s[2]], centre), 1.0 / thickest)).collect();
    let weights: Vec<f64> = rows.iter().map(weight).collect();
    let back = crate::numerics::Rotation::from_z_to(long_axis(&arms, &weights)).inverse();
    let sphere =
        |(arm, s): (&V3, &[f64; 4])| Sphere { center_um: back.turn(*arm), radius_um: s[3] / thickest };
    arms.iter().zip(rows).map(sphere).collect()
}

/// Second moment of the arms applied to v: Σ w a (a · v).
fn spread(arms: &[V3], weights: &[f64], v: V3) -> V3 {
    arms.iter().zip(weights).fold([0.0; 3], |sum, (a, w)| {
        let along = w * crate::numerics::vector::dot(*a, v);
        add(sum, scale(*a, along))
    })
}

/// Direction of largest second moment by power iteration on Σ w a aᵀ; z if the moment vanishes.
fn long_axis(arms: &[V3], weights: &[f64]) -> V3 {
    let start = arms.iter().copied().max_by(|a, b| norm(*a).total_cmp(&norm(*b))).unwrap_or([0.0; 3]);
    (0..200).fold(unit(start), |v, _| unit(spread(arms, weights, v)))
}
