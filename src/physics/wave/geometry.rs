//! A scene on a grid: everything independent of wavelength and direction, for either wave.

use super::contrast::coverage::Precision;
use super::maxwell::{Averaging, NormalMoments, VectorProblem};
use super::system::System;
use super::{
    Coverage, Grid, Incidence, Mean, Media, Polarisation, Problem, Resolution, Scene, Wave, WaveError,
};
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
    pub fn new(
        wave: Wave,
        scene: &Scene,
        resolution: Resolution,
        precision: Precision,
    ) -> Result<Geometry, WaveError> {
        Ok(match wave {
            Wave::Scalar => Geometry::Scalar(Coverage::with(scene, resolution, precision)?.into()),
            _ => Geometry::Vector(NormalMoments::with(scene, resolution, precision)?.into()),
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
