//! The sphere, building block of all grains.

use super::solid::{Form, Solid};
use crate::numerics::vector::{V3, add, norm, scale, sub};
use serde::{Deserialize, Serialize};

/// A sphere of pigment, µm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
