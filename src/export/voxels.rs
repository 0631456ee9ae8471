//! The layer as a volume: which share of every voxel each material fills, and the contrast that the
//! wave sees.

use super::near_field::{Image, PointArray};
use crate::ink::{Packing, Solid};
use crate::wave::{Material, Media};
use ndarray::Array3;
use num_complex::Complex64;

/// Samples along each edge of a voxel: shares come in steps of 1/27.
const SAMPLES: usize = 3;
/// Largest number of voxels; a wider cell gets larger ones.
const MOST_VOXELS: f64 = 2.0e6;
/// Smallest edge of a voxel, µm: a fraction of the finest grains.
const FINEST_UM: f64 = 0.02;

/// Marks of the fine raster: the binder, the space above a relief, and pigments from
/// `FIRST_PIGMENT` on.
const BINDER: u8 = 0;
const VACUUM: u8 = 1;
const FIRST_PIGMENT: usize = 2;

/// Raster of a packing.
#[derive(Clone, Debug)]
pub struct Voxels {
    /// Voxels along x, y, z.
    pub count: [usize; 3],
    /// Edges of a voxel, µm.
    pub edge_um: [f64; 3],
    /// Share of each voxel's volume, x fastest: first the space beyond a relief, then one list per
    /// material of the grains, see [`Packing::materials`].
    pub shares: Vec<Vec<f32>>,
    /// What fills that space.
    beyond: Material,
    /// Layer of every plane of voxels, from 0: that of its middle.
    layer_of_plane: Vec<usize>,
}

impl Voxels {
    /// Rasters the union of every grain's spheres.
    pub fn of(packing: &Packing) -> Self {
        let size = size_um(packing);
        let count = usual(size);
        let raster = VoxelRaster::new(count.map(|n| SAMPLES * n), size);
        let kinds = FIRST_PIGMENT - 1 + packing.materials();
        let mut shares = vec![vec![0.0_f32; count.iter().product()]; kinds];
        let part = 1.0 / SAMPLES.pow(3) as f32;
        for (i, &mark) in raster.marks(packing).iter().enumerate() {
            if mark != BINDER {
                let [x, y, z] = raster.place(i).map(|k| k / SAMPLES);
                shares[usize::from(mark) - 1][x + count[0] * (y + count[1] * z)] += part;
            }
        }
        let beyond = packing.relief().map(|relief| relief.face).unwrap_or_default().into();
        let edge_um = [0, 1, 2].map(|i| size[i] / count[i] as f64);
        let layer_at = |k: usize| layer_at(packing.layers_um(), (k as f64 + 0.5) * edge_um[2]);
        Self { count, edge_um, shares, beyond, layer_of_plane: (0..count[2]).map(layer_at).collect() }
    }

    /// η² of every voxel, as its shares mix it, less that of the binder; of a stack, whose binders
    /// may differ, less that of its first layer's.
    pub fn contrast(&self, media: &Media) -> Vec<Complex64> {
        let square = |eta: Complex64| eta * eta;
        let first = square(media.backgrounds[0]);
        let plane = self.count[0] * self.count[1];
        // voxels keep their own layer's binder where no share takes its place
        let own: Vec<Complex64> =
            self.layer_of_plane.iter().map(|layer| square(media.backgrounds[*layer])).collect();
        let mut contrast: Vec<Complex64> =
            (0..self.shares[0].len()).map(|i| own[i / plane] - first).collect();
        for (kind, shares) in self.shares.iter().enumerate() {
            let material = if kind == 0 { self.beyond } else { Material::Inclusion(kind - 1) };
            let filling = square(media.index_of(material));
            for (i, (v, &share)) in contrast.iter_mut().zip(shares).enumerate() {
                *v += (filling - own[i / plane]) * f64::from(share);
            }
        }
        contrast
    }

    /// Shares of the materials by name, and the contrast at one wavelength, on the voxels' centres.
    pub fn image(&self, materials: &[String], media: &Media, wavelength_nm: f64) -> Image {
        let name = format!("contrast_{wavelength_nm:.0}nm");
        let mut arrays = vec![PointArray::complex(name, self.contrast(media))];
        let beyond = "beyond_relief".to_owned();
        for (name, values) in std::iter::once(&beyond).chain(materials).zip(&self.shares) {
            if values.iter().any(|&v| v > 0.0) {
                let name = format!("share_{name}");
                let values = values.clone();
                arrays.push(PointArray { name, components: 1, values });
            }
        }
        let origin_um = self.edge_um.map(|e| e / 2.0);
        Image { points: self.count, spacing_um: self.edge_um, origin_um, arrays }
    }
}

/// Labels at the centres of voxels, axes x, y, z: 0 is the binder, k + 1 material k of the grains,
/// see [`Packing::materials`]. `count` voxels, or as many as [`Voxels::of`] takes.
pub fn labels(packing: &Packing, count: Option<[usize; 3]>) -> Array3<u8> {
    let size = size_um(packing);
    let count = count.unwrap_or_else(|| usual(size));
    let raster = VoxelRaster::new(count, size);
    let marks = raster.marks(packing);
    let [nx, ny, nz] = count;
    Array3::from_shape_fn((nx, ny, nz), |(x, y, z)| marks[x + nx * (y + ny * z)].saturating_sub(VACUUM))
}

/// Layer at a depth, of layers of these thicknesses, µm.
fn layer_at(layers_um: &[f64], depth_um: f64) -> usize {
    let mut face_um = 0.0;
    let is_behind = |um: &&f64| {
        face_um += **um;
        depth_um > face_um
    };
    layers_um.iter().take_while(is_behind).count().min(layers_um.len().saturating_sub(1))
}

/// Sides of a layer, µm.
pub(super) fn size_um(packing: &Packing) -> [f64; 3] {
    let [lx, ly] = packing.period_um();
    [lx, ly, packing.thickness_um()]
}

/// Voxels along each side of a layer, µm.
fn usual(size: [f64; 3]) -> [usize; 3] {
    let edge = (size.iter().product::<f64>() / MOST_VOXELS).cbrt().max(FINEST_UM);
    size.map(|s| (s / edge).ceil() as usize)
}

/// The fine raster, points at the centres of its steps.
struct VoxelRaster {
    count: [usize; 3],
    step_um: [f64; 3],
}

impl VoxelRaster {
    fn new(count: [usize; 3], size_um: [f64; 3]) -> Self {
        Self { count, step_um: [0, 1, 2].map(|i| size_um[i] / count[i] as f64) }
    }

    fn place(&self, i: usize) -> [usize; 3] {
        let [nx, ny, _] = self.count;
        [i % nx, i / nx % ny, i / (nx * ny)]
    }

    /// Centre of the `i`-th voxel, µm.
    fn centre_um(&self, i: usize) -> [f64; 3] {
        let place = self.place(i);
        std::array::from_fn(|axis| (place[axis] as f64 + 0.5) * self.step_um[axis])
    }

    fn marks(&self, packing: &Packing) -> Vec<u8> {
        let mut marks = vec![BINDER; self.count.iter().product()];
        for (i, mark) in marks.iter_mut().enumerate().filter(|_| packing.relief().is_some()) {
            let [x, y, z] = self.centre_um(i);
            let [from, to] = packing.filled_um(x, y);
            if z < from || z > to {
                *mark = VACUUM;
            }
        }
        for grain in packing.grains() {
            for body in packing.nested(grain) {
                for solid in body.solids() {
                    self.mark(&solid, (FIRST_PIGMENT + body.material) as u8, &mut marks);
                }
            }
        }
        marks
    }

    /// Marks the points inside a convex body; x and y wrap.
    fn mark(&self, solid: &Solid, mark: u8, marks: &mut [u8]) {
        let points = |[low, high]: [f64; 2], a: usize| {
            (low / self.step_um[a] - 0.5).ceil() as i64..=(high / self.step_um[a] - 0.5).floor() as i64
        };
        let wrap = |a: usize, k: i64| k.rem_euclid(self.count[a] as i64) as usize;
        let [nx, ny, nz] = self.count;
        for y in points(solid.extent_um(1), 1) {
            for x in points(solid.extent_um(0), 0) {
                let centre = |a: usize, k: i64| (k as f64 + 0.5) * self.step_um[a];
                let Some(inside) = solid.chord([centre(0, x), centre(1, y), 0.0], [0.0, 0.0, 1.0]) else {
                    continue;
                };
                for z in points(inside, 2).filter(|&z| (0..nz as i64).contains(&z)) {
                    marks[wrap(0, x) + nx * (wrap(1, y) + ny * z as usize)] = mark;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{
        Grain, Joint, PackingRequest, PigmentGrains, ReliefRequest, RoughFace, Sphere, StackedRequest, pack,
    };

    /// Balls of two pigments: the voxel at the centre of each holds nothing else.
    #[test]
    fn voxels_stand_for_their_centres_and_hold_their_own_pigment() {
        let ball =
            |at: f64, pigment| Grain::new(vec![Sphere { center_um: [at; 3], radius_um: 0.08 }], pigment);
        let packing = Packing::from_grains([0.4; 2], 0.4, true, vec![ball(0.1, 0), ball(0.3, 1)]).unwrap();
        let media = Media {
            incident: Complex64::ONE,
            exit: Complex64::ONE,
            backgrounds: vec![1.5.into()],
            inclusions: vec![2.0.into(), Complex64::new(1.0, 1.0)],
        };
        let voxels = Voxels::of(&packing);
        let [nx, ny, _] = voxels.count;
        let contrast = voxels.contrast(&media);
        // 2² − 1.5² and (1 + i)² − 1.5², in 27 shares of single precision
        for (at, expected) in [(0.1, Complex64::new(1.75, 0.0)), (0.3, Complex64::new(-2.25, 2.0))] {
            let [x, y, z] = voxels.edge_um.map(|edge| (at / edge) as usize);
            let found = contrast[x + nx * (y + ny * z)];
            assert!((found - expected).norm() < 1e-5, "at {at} µm: {found}");
        }
        let image = voxels.image(&["one".to_owned(), "two".to_owned()], &media, 550.0);
        for (origin_um, count) in image.origin_um.iter().zip(image.points) {
            assert!((origin_um - 0.5 * 0.4 / count as f64).abs() < 1e-12, "{origin_um} µm");
        }
    }

    /// In a stack of binders 1.5 and 1.6, of 0.3 µm each, a ball differs from its own layer's binder.
    /// *Planted*: the first layer's binder everywhere.
    #[test]
    fn every_layer_of_a_stack_has_its_own_binder() {
        let pigments = || vec![PigmentGrains::spheres(200.0, 0.1)];
        let layer = || StackedRequest {
            request: PackingRequest {
                period_um: [0.5; 2],
                thickness_um: 0.3,
                pigments: pigments(),
                ..Default::default()
            },
            joint: Joint::Wall,
        };
        let request = PackingRequest {
            period_um: [0.5; 2],
            thickness_um: 0.6,
            pigments: [pigments(), pigments()].concat(),
            layers: vec![layer(), layer()],
            ..Default::default()
        };
        let media = Media {
            incident: Complex64::ONE,
            exit: Complex64::ONE,
            backgrounds: vec![1.5.into(), 1.6.into()],
            inclusions: vec![2.0.into(), 2.0.into()],
        };
        let voxels = Voxels::of(&pack(&request, &mut ()).unwrap());
        let plane = voxels.count[0] * voxels.count[1];
        let mut has_seen = [false; 2];
        for (i, v) in voxels.contrast(&media).iter().enumerate() {
            let depth_um = ((i / plane) as f64 + 0.5) * voxels.edge_um[2];
            let filled = f64::from(voxels.shares[1][i] + voxels.shares[2][i]);
            let own = if depth_um > 0.3 { 2.56 } else { 2.25 };
            let expected = own - 2.25 + filled * (4.0 - own);
            assert!((v - expected).norm() < 1e-5, "at {depth_um} µm: {v}, {expected}");
            has_seen[usize::from(filled > 0.9)] |= depth_um > 0.3;
        }
        assert_eq!(has_seen, [true; 2]);
    }

    /// Beyond a rough face there is the medium of its side. *Planted*: always that of the incident
    /// side.
    #[test]
    fn the_space_beyond_a_relief_has_the_medium_of_its_side() {
        let inclusions = vec![2.0.into()];
        let media =
            Media { incident: 1.1.into(), exit: 1.3.into(), backgrounds: vec![1.5.into()], inclusions };
        for (face, outermost) in [(RoughFace::Incident, 1.1_f64), (RoughFace::Exit, 1.3)] {
            let request = PackingRequest {
                period_um: [0.6; 2],
                thickness_um: 0.6,
                pigments: vec![PigmentGrains::spheres(200.0, 0.02)],
                relief: Some(ReliefRequest { depth_um: 0.2, face, ..Default::default() }),
                ..Default::default()
            };
            let voxels = Voxels::of(&pack(&request, &mut ()).unwrap());
            let plane = voxels.count[0] * voxels.count[1];
            let contrast = voxels.contrast(&media);
            // a plane at the very face, which hardly any grain touches
            let first = if face == RoughFace::Incident { 0 } else { contrast.len() - plane };
            let expected = Complex64::from(outermost.powi(2) - 2.25);
            let alike =
                contrast[first..first + plane].iter().filter(|&&v| (v - expected).norm() < 1e-5).count();
            assert!(10 * alike > 9 * plane, "{face:?}: {alike} of {plane}");
        }
    }
}
