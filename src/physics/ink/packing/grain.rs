//! A placed grain; and microstructures of voxels: equal voxels are merged to boxes, which are
//! placed as grains.

use crate::ink::grains::solid::{Form, Solid};
use crate::ink::grains::sphere::{Sphere, centre_of_mass};
use crate::ink::grains::volume::union_volume;
use crate::numerics::vector::{V3, sub, unit};
use ndarray::{Array3, s};
#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer, Serializer};

/// A rigid union of spheres, or a convex body. The coordinates of a grain are contiguous (not
/// wrapped individually), and its first centre lies in the cell.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Grain {
    /// Spheres of the union, µm; of a convex body the sphere around it.
    pub spheres: Vec<Sphere>,
    /// The convex body, if the grain is one.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub solid: Option<Solid>,
    /// Index into the request's pigments.
    pub pigment: usize,
    /// Unit vector along the symmetry axis (z for a sphere).
    pub axis: V3,
    /// Number of the grain's agglomerate, if any.
    pub agglomerate: Option<usize>,
    /// Unit vector along the optic axis of a birefringent grain.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub optic_axis: Option<V3>,
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
        match &self.solid {
            Some(solid) => vec![solid.clone()],
            None => self.spheres.iter().map(Sphere::solid).collect(),
        }
    }
}

impl Grain {
    /// A grain outside any agglomerate; its axis runs from the first to the last centre.
    pub fn new(spheres: Vec<Sphere>, pigment: usize) -> Self {
        let ends = spheres.first().zip(spheres.last());
        let axis = ends.map_or([0.0, 0.0, 1.0], |(a, b)| unit(sub(b.center_um, a.center_um)));
        let volume_um3 = union_volume(&spheres).um3;
        Self { spheres, solid: None, pigment, axis, agglomerate: None, optic_axis: None, volume_um3 }
    }

    /// A convex body; its axis is the form's z axis.
    pub fn convex(solid: Solid, pigment: usize) -> Self {
        let around = Sphere { center_um: solid.center_um, radius_um: solid.form.reach_um() };
        Self {
            spheres: vec![around],
            pigment,
            axis: solid.rotation.turn([0.0, 0.0, 1.0]),
            agglomerate: None,
            optic_axis: None,
            volume_um3: solid.form.volume_um3(),
            solid: Some(solid),
        }
    }

    /// Lowest and highest coordinate along an axis, µm.
    pub fn extent_um(&self, axis: usize) -> [f64; 2] {
        if let Some(solid) = &self.solid {
            return solid.extent_um(axis);
        }
        let low = self.spheres.iter().map(|s| s.center_um[axis] - s.radius_um).fold(f64::MAX, f64::min);
        let high = self.spheres.iter().map(|s| s.center_um[axis] + s.radius_um).fold(f64::MIN, f64::max);
        [low, high]
    }

    /// Centre of mass of the spheres, each weighted by its volume; not wrapped.
    pub fn centre_um(&self) -> V3 {
        centre_of_mass(&self.spheres)
    }
}

/// The voxels of one cut that belong to pigments, merged to boxes that touch and do not overlap.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VoxelCut {
    /// Voxels along x, y and z, from the lit face down; they divide the cell evenly.
    pub count: [usize; 3],
    /// Whether the cut was mirrored along x and y, which made it periodic.
    pub mirrored: bool,
    /// First voxel along x, y, z, the first one beyond the box, and the pigment.
    #[cfg_attr(feature = "serde", serde(serialize_with = "as_text", deserialize_with = "from_text"))]
    pub boxes: Vec<[usize; 7]>,
}

impl VoxelCut {
    /// Merges the voxels of `labels`, with axes x, y, z: 0 is the binder, k + 1 pigment k.
    pub fn new(labels: &Array3<u8>, mirrored: bool) -> VoxelCut {
        Self::of_at_most(usize::MAX, labels, mirrored).expect("any number of boxes is allowed")
    }

    /// As [`VoxelCut::new`]; `None` if there are more than `most` boxes.
    pub fn of_at_most(most: usize, labels: &Array3<u8>, mirrored: bool) -> Option<VoxelCut> {
        let (nx, ny, nz) = labels.dim();
        let mut left = labels.clone();
        let mut boxes = Vec::new();
        for ((x, y, z), &label) in labels.indexed_iter() {
            if left[[x, y, z]] > 0 {
                if boxes.len() >= most {
                    return None;
                }
                let [x1, y1, z1] = grown(&left, [x, y, z]);
                left.slice_mut(s![x..x1, y..y1, z..z1]).fill(0);
                boxes.push([x, y, z, x1, y1, z1, usize::from(label) - 1]);
            }
        }
        Some(VoxelCut { count: [nx, ny, nz], mirrored, boxes })
    }

    /// Voxels of a pigment.
    pub fn volume(&self, pigment: usize) -> usize {
        let of_pigment = self.boxes.iter().filter(|b| b[6] == pigment);
        of_pigment.map(|b| (0..3).map(|axis| b[axis + 3] - b[axis]).product::<usize>()).sum()
    }

    /// The boxes in a cell of this size, µm.
    pub fn grains(&self, cell_um: [f64; 3]) -> Vec<Grain> {
        let um = |axis: usize, voxels: usize| cell_um[axis] * voxels as f64 / self.count[axis] as f64;
        let grain = |b: &[usize; 7]| {
            let edges = [0, 1, 2].map(|axis| um(axis, b[axis + 3] - b[axis]));
            let center = [0, 1, 2].map(|axis| 0.5 * um(axis, b[axis + 3] + b[axis]));
            Grain::convex(Solid::upright(Form::cuboid(edges), center), b[6])
        };
        self.boxes.iter().map(grain).collect()
    }
}

/// The end of the largest box of one label that begins at `low`, grown along x, then y, then z.
fn grown(left: &Array3<u8>, low: [usize; 3]) -> [usize; 3] {
    let mut high = low.map(|i| i + 1);
    for axis in 0..3 {
        while high[axis] < left.shape()[axis] {
            let mut from = low;
            let mut to = high;
            from[axis] = high[axis];
            to[axis] += 1;
            let next = left.slice(s![from[0]..to[0], from[1]..to[1], from[2]..to[2]]);
            if next.iter().any(|&label| label != left[low]) {
                break;
            }
            high = to;
        }
    }
    high
}

/// One text instead of a line per number.
#[cfg(feature = "serde")]
fn as_text<S: Serializer>(boxes: &[[usize; 7]], to: S) -> Result<S::Ok, S::Error> {
    let words: Vec<String> = boxes.iter().flatten().map(usize::to_string).collect();
    to.serialize_str(&words.join(" "))
}

#[cfg(feature = "serde")]
fn from_text<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<[usize; 7]>, D::Error> {
    let text = String::deserialize(from)?;
    let numbers: Result<Vec<usize>, _> = text.split_whitespace().map(str::parse).collect();
    let numbers = numbers.map_err(serde::de::Error::custom)?;
    Ok(numbers.chunks_exact(7).map(|b| std::array::from_fn(|i| b[i])).collect())
}
