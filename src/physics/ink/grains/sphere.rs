//! The sphere, building block of all grains: chains along an axis, and clusters turned to theirs.

use super::solid::{Form, Solid};
use crate::numerics::vector::{Rotation, V3, add, dot, norm, scale, sub, unit};

/// A sphere of pigment, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sphere {
    /// Centre (x, y, z), µm; z from 0 at the incident side to H.
    pub center_um: [f64; 3],
    /// Radius, µm.
    pub radius_um: f64,
}

impl Sphere {
    /// Volume 4πR³/3, µm³.
    pub fn volume_um3(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius_um.powi(3)
    }

    /// The sphere as a convex body.
    pub fn solid(&self) -> Solid {
        Solid::upright(Form::Ellipsoid { semi_axes_um: [self.radius_um; 3] }, self.center_um)
    }

    /// Distance between the surfaces without periodic wrapping; negative if they overlap.
    pub fn gap_to(&self, other: &Self) -> f64 {
        norm(sub(self.center_um, other.center_um)) - self.radius_um - other.radius_um
    }
}

/// Centre of mass of spheres, each weighted by its volume.
pub fn centre_of_mass(spheres: &[Sphere]) -> V3 {
    let total: f64 = spheres.iter().map(|s| s.radius_um.powi(3)).sum();
    spheres.iter().fold([0.0; 3], |c, s| add(c, scale(s.center_um, s.radius_um.powi(3) / total)))
}

/// Radius of the sphere about `centre` that encloses others, µm.
pub fn reach_um(spheres: &[Sphere], centre: V3) -> f64 {
    spheres.iter().map(|s| norm(sub(s.center_um, centre)) + s.radius_um).fold(0.0, f64::max)
}

pub(super) fn bead(z: f64, radius: f64) -> Sphere {
    Sphere { center_um: [0.0, 0.0, z], radius_um: radius }
}

/// A chain of `n` spheres between −reach and reach; `radius` is a function of the position from −1
/// to 1.
pub(super) fn chain(n: usize, reach: f64, radius: impl Fn(f64) -> f64) -> Vec<Sphere> {
    let position = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let beads: Vec<Sphere> = (0..n).map(|i| bead(reach * position(i), radius(position(i)))).collect();
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
    let weights: Vec<f64> = rows.iter().map(|s| (s[3] / thickest).powi(3)).collect();
    let places = rows.iter().map(|s| [s[0], s[1], s[2]]);
    let total = weights.iter().sum::<f64>();
    let centre = places.clone().zip(&weights).fold([0.0; 3], |c, (p, w)| add(c, scale(p, w / total)));
    let arms: Vec<V3> = places.map(|p| scale(sub(p, centre), 1.0 / thickest)).collect();
    let back = Rotation::from_z_to(long_axis(&arms, &weights)).inverse();
    let radii = rows.iter().map(|s| s[3] / thickest);
    arms.iter().zip(radii).map(|(arm, radius_um)| Sphere { center_um: back.turn(*arm), radius_um }).collect()
}

/// Second moment of the arms applied to v: Σ w a (a · v).
fn spread(arms: &[V3], weights: &[f64], v: V3) -> V3 {
    arms.iter().zip(weights).fold([0.0; 3], |sum, (a, w)| add(sum, scale(*a, w * dot(*a, v))))
}

/// Direction of largest second moment by power iteration on Σ w a aᵀ; z if the moment vanishes.
fn long_axis(arms: &[V3], weights: &[f64]) -> V3 {
    let start = arms.iter().copied().max_by(|a, b| norm(*a).total_cmp(&norm(*b))).unwrap_or([0.0; 3]);
    (0..200).fold(unit(start), |v, _| unit(spread(arms, weights, v)))
}
