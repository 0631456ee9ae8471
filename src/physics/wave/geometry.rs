//! The scene of a packing, and a scene on a grid: everything independent of wavelength and
//! direction, for either wave.

use super::maxwell::{Averaging, NormalMoments, VectorProblem};
use super::{
    Body, BodyShape, Coverage, Grid, HeightField, Incidence, Material, Mean, Media, Polarisation, Precision,
    Problem, Resolution, Scene, Stratum, System, Uniaxial, Wave, WaveError,
};
use crate::ink::{Layered, Packing, Relief, RoughFace};
use std::sync::Arc;

/// A scene on a grid for one kind of wave, computed once for all wavelengths and directions.
#[derive(Clone)]
pub enum Geometry {
    /// Geometry for the scalar wave.
    Scalar(Arc<Coverage>),
    /// Geometry for Maxwell's equations.
    Vector(Arc<NormalMoments>),
}

impl Geometry {
    /// Computes the geometry of a scene on a grid.
    ///
    /// # Errors
    /// Invalid grids and bodies; [`WaveError::Stopped`].
    pub fn new(wave: Wave, scene: &Scene, grid: Resolution, precision: Precision) -> Result<Self, WaveError> {
        Ok(match wave {
            Wave::Scalar => Geometry::Scalar(Coverage::with(scene, grid, precision)?.into()),
            _ => Geometry::Vector(NormalMoments::with(scene, grid, precision)?.into()),
        })
    }

    /// The grid of the geometry.
    pub fn grid(&self) -> &Grid {
        match self {
            Geometry::Scalar(coverage) => &coverage.grid,
            Geometry::Vector(moments) => &moments.grid,
        }
    }

    /// The discrete problems of one wavelength and direction: one for the scalar wave, or those of
    /// s and p light, which share the contrast tensor and the mean operator's tables.
    ///
    /// # Errors
    /// Invalid media and lights.
    pub fn systems(
        &self,
        media: &Media,
        light: &Incidence,
        mean: Mean,
    ) -> Result<Vec<Box<dyn System>>, WaveError> {
        Ok(match self {
            Geometry::Scalar(coverage) => vec![Box::new(Problem::new(coverage, media, light, mean)?)],
            Geometry::Vector(moments) => {
                let problem = VectorProblem::new(moments, media, light, mean, Averaging::Normal)?;
                Polarisation::BOTH.map(|p| Box::new(problem.polarised(p)) as Box<dyn System>).into()
            }
        })
    }
}

impl Scene {
    /// One stratum of binder (the background with its number) for every layer, with the nested
    /// bodies of every grain; their materials are the inclusions (see [`Packing::materials`] and
    /// [`Packing::extraordinary`]), and the space beyond a relief is filled by the medium of its
    /// side.
    ///
    /// The packing has been checked for overlap, so the check of pairs is not repeated.
    pub fn from_packing(packing: &Packing) -> Scene {
        let mut bodies: Vec<Body> = Vec::with_capacity(packing.grains().len());
        for grain in packing.grains() {
            let mut within = None;
            for Layered { material, spheres, solid } in packing.nested(grain) {
                let shape = solid.map_or_else(|| BodyShape::Balls(spheres), BodyShape::Solid);
                let body = match grain.optic_axis.zip(packing.extraordinary(material)) {
                    Some((axis, extraordinary)) => {
                        Body::crystal(shape, Uniaxial { ordinary: material, extraordinary }, axis)
                    }
                    None => Body::new(shape, material),
                };
                bodies.push(Body { within, ..body });
                within = Some(bodies.len() - 1);
            }
        }
        bodies.extend(packing.relief().map(|relief| open(packing, relief)));
        let layers = packing.layers_um().iter().enumerate();
        let strata = layers.map(|(background, &thickness_um)| Stratum { thickness_um, background }).collect();
        Scene { period_um: packing.period_um(), strata, bodies, cut: packing.is_cut() }
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
    let period_um = packing.period_um();
    let count = relief.count;
    let position_um = |i: usize, axis: usize| period_um[axis] * i as f64 / count[axis] as f64;
    let thickness = packing.thickness_um();
    let (end, face_um) = match relief.face {
        RoughFace::Incident => (0, 0.0),
        RoughFace::Exit => (1, thickness),
    };
    let filled = |k: usize| packing.filled_um(position_um(k % count[0], 0), position_um(k / count[0], 1));
    let z_um = (0..count[0] * count[1]).map(|k| filled(k)[end].clamp(0.0, thickness)).collect();
    let surface = HeightField { z_um, count, period_um };
    let clusters = packing.grains().iter().filter(|g| g.solid.is_none());
    let balls = clusters.flat_map(|g| g.spheres.clone()).collect();
    let solids = packing.grains().iter().filter_map(|g| g.solid.clone()).collect();
    let shape = BodyShape::Open { surface, face_um, balls, solids };
    Body::of(shape, relief.face.into())
}
