//! Conversion of a packing to a scene.

use super::scene::HeightField;
use super::{Body, BodyShape, Material, Scene};
use crate::ink::{Layered, Packing, Relief, RoughFace};

impl Scene {
    /// One stratum of binder (background 0) with the nested bodies of every grain; their materials
    /// are the inclusions (see [`Packing::materials`]), and the space beyond a relief is filled by
    /// the medium of its side.
    ///
    /// The packing has been checked for overlap, so the check of pairs is not repeated.
    pub fn from_packing(packing: &Packing) -> Scene {
        let mut bodies: Vec<Body> = Vec::with_capacity(packing.grains().len());
        for grain in packing.grains() {
            let mut within = None;
            for Layered { material, spheres, solid } in packing.nested(grain) {
                let shape = solid.map_or_else(|| BodyShape::Balls(spheres), BodyShape::Solid);
                bodies.push(Body { within, ..Body::new(shape, material) });
                within = Some(bodies.len() - 1);
            }
        }
        bodies.extend(packing.relief().map(|relief| open(packing, relief)));
        Scene { cut: packing.is_cut(), ..Scene::layer(packing.period_um(), packing.thickness_um(), bodies) }
    }
}

impl From<RoughFace> for Material {
    /// What fills the space beyond a relief.
    fn from(face: RoughFace) -> Material {
        match face {
            RoughFace::Incident => Material::Incident,
            RoughFace::Exit => Material::Exit,
        }
    }
}

/// The space beyond the surface, which is sampled at the relief's own points.
fn open(packing: &Packing, relief: &Relief) -> Body {
    let (period_um, count) = (packing.period_um(), relief.count);
    let at = |i: usize, axis: usize| period_um[axis] * i as f64 / count[axis] as f64;
    let thickness = packing.thickness_um();
    let (end, face_um) = match relief.face {
        RoughFace::Incident => (0, 0.0),
        RoughFace::Exit => (1, thickness),
    };
    let filled = |k: usize| packing.filled_um(at(k % count[0], 0), at(k / count[0], 1));
    let z_um = (0..count[0] * count[1]).map(|k| filled(k)[end].clamp(0.0, thickness)).collect();
    let surface = HeightField { z_um, count, period_um };
    let clusters = packing.grains().iter().filter(|g| g.solid.is_none());
    let balls = clusters.flat_map(|g| g.spheres.clone()).collect();
    let solids = packing.grains().iter().filter_map(|g| g.solid.clone()).collect();
    let shape = BodyShape::Open { surface, face_um, balls, solids };
    Body { shape, material: relief.face.into(), within: None }
}
