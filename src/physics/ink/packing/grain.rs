//! A placed grain.

use crate::ink::grains::solid::Solid;
use crate::ink::grains::sphere::{Sphere, centre_of_mass};
use crate::ink::grains::volume::union_volume;
use crate::numerics::vector::{V3, sub, unit};
use serde::{Deserialize, Serialize};

/// A rigid union of spheres, or a convex body. The coordinates of a grain are contiguous (not
/// wrapped individually), and its first centre lies in the cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grain {
    /// Spheres of the union, µm; of a convex body the sphere around it.
    pub spheres: Vec<Sphere>,
    /// The convex body, if the grain is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solid: Option<Solid>,
    /// Index into the request's pigments.
    pub pigment: usize,
    /// Unit vector along the symmetry axis (z for a sphere).
    pub axis: V3,
    /// Number of the grain's agglomerate, if any.
    pub agglomerate: Option<usize>,
    /// Volume of the union of the spheres, µm³.
    pub volume_um3: f64,
}

/// A grain less some of its layers.
#[derive(Clone, Debug)]
pub struct Layered {
    /// Its outermost material, see [`crate::ink::Packing::materials`].
    pub material: usize,
    /// Its spheres; of a convex body the sphere around it.
    pub spheres: Vec<Sphere>,
    /// The convex body, if it is one.
    pub solid: Option<Solid>,
}

impl Layered {
    /// The convex body, or its spheres as such.
    pub fn solids(&self) -> Vec<Solid> {
        self.solid.clone().map_or_else(|| self.spheres.iter().map(Sphere::solid).collect(), |own| vec![own])
    }
}

impl Grain {
    /// A grain outside any agglomerate; its axis runs from the first to the last centre.
    pub fn new(spheres: Vec<Sphere>, pigment: usize) -> Self {
        let ends = spheres.first().zip(spheres.last());
        let axis = ends.map_or([0.0, 0.0, 1.0], |(a, b)| unit(sub(b.center_um, a.center_um)));
        let volume_um3 = union_volume(&spheres).um3;
        Self { spheres, solid: None, pigment, axis, agglomerate: None, volume_um3 }
    }

    /// A convex body; its axis is the form's z axis.
    pub fn convex(solid: Solid, pigment: usize) -> Self {
        let around = Sphere { center_um: solid.center_um, radius_um: solid.form.reach_um() };
        let (axis, volume_um3) = (solid.rotation.turn([0.0, 0.0, 1.0]), solid.form.volume_um3());
        let (spheres, solid) = (vec![around], Some(solid));
        Self { spheres, solid, pigment, axis, agglomerate: None, volume_um3 }
    }

    /// Lowest and highest coordinate along an axis, µm.
    pub fn extent_um(&self, axis: usize) -> [f64; 2] {
        if let Some(solid) = &self.solid {
            return solid.extent_um(axis);
        }
        let ends =
            self.spheres.iter().map(|s| [-1.0, 1.0].map(|side| s.center_um[axis] + side * s.radius_um));
        ends.fold([f64::MAX, f64::MIN], |e, [low, high]| [e[0].min(low), e[1].max(high)])
    }

    /// Whether the grain has an axis: it is not a single sphere.
    pub fn is_elongated(&self) -> bool {
        self.solid.is_some() || self.spheres.len() > 1
    }

    /// Centre of mass of the spheres, each weighted by its volume; not wrapped.
    pub fn centre_um(&self) -> V3 {
        centre_of_mass(&self.spheres)
    }
}
