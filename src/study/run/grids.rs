//! One packing on the grids that its waves need.

use super::point::{Systems, systems_of};
use super::watch::RunWatch;
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::accuracy::raised;
use crate::wave::{Geometry, Precision, Resolution, Scene, WaveError};
use std::sync::{Mutex, PoisonError};

/// The problems of a wave, one per polarisation, with the geometry that they share.
pub type Problems = (Systems, Geometry);

/// A packing on grids.
///
/// The grid of a wave was chosen on other packings and at the probed wavelengths. A cell of this
/// packing may contain more pigment, and a wavelength between the probes may meet a larger index,
/// for which the cells of the chosen grid are too high.
pub struct Grids {
    /// The packing.
    pub packing: Packing,
    /// By wave (vector or not), grid and error: inks that share a packing share them, and so do the
    /// polarisations.
    geometries: Mutex<Vec<((bool, Resolution, f64), Geometry)>>,
}

impl Grids {
    /// A packing on no grid yet.
    pub fn new(packing: Packing) -> Self {
        Self { packing, geometries: Mutex::default() }
    }

    /// The packing on a grid, computed once.
    ///
    /// # Errors
    /// The grid or the packing is refused, or a stop.
    pub fn geometry(
        &self,
        study: &Study,
        resolution: Resolution,
        watch: &dyn RunWatch,
    ) -> Result<Geometry, WaveError> {
        let (error, stop) = (study.resolution.coverage_error(), || watch.stop());
        let asked = (study.wave.is_vector(), resolution, error);
        let mut all = self.geometries.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, geometry)) = all.iter().find(|(kept, _)| *kept == asked) {
            return Ok(geometry.clone());
        }
        let scene = Scene::from_packing(&self.packing);
        let geometry = Geometry::new(study.wave, &scene, resolution, Precision { error, stop: &stop })?;
        all.push((asked, geometry.clone()));
        Ok(geometry)
    }

    /// The problems of a point on the coarsest grid that can represent its wave, from `resolution`
    /// on; the choice depends on the point alone.
    ///
    /// # Errors
    /// The scene cannot be discretised, or a stop.
    pub fn problems(
        &self,
        study: &Study,
        mut resolution: Resolution,
        point: &Point,
        watch: &dyn RunWatch,
    ) -> Result<Problems, WaveError> {
        loop {
            let geometry = self.geometry(study, resolution, watch)?;
            match systems_of(study, &geometry, point) {
                Err(refusal @ WaveError::CellTooHigh { .. }) => {
                    resolution = raised(resolution, &refusal).ok_or(refusal)?;
                }
                made => return Ok((made?, geometry)),
            }
        }
    }
}
