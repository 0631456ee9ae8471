//! The grids of one realisation: its own, and finer ones for the few waves that are too short for it.

use super::point::problem_of;
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::accuracy::raised;
use crate::solve::door::{Geometry, WaveProblem};
use crate::wave::{Resolution, Scene, WaveError};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// The grid was chosen on other packings and at the probes' wavelengths. A cell of this packing may hold more pigment, and a
/// wavelength between the probes may meet a larger index: then cells that the wave just fits in are too high for it.
pub(super) struct Grids<'a> {
    study: &'a Study,
    packing: &'a Packing,
    resolution: Resolution,
    own: Geometry,
    /// By number of cells.
    finer: Mutex<BTreeMap<usize, Geometry>>,
}

impl<'a> Grids<'a> {
    pub fn new(study: &'a Study, packing: &'a Packing, resolution: Resolution, own: Geometry) -> Self {
        Self { study, packing, resolution, own, finer: Mutex::default() }
    }

    /// The problem of a point on the coarsest of these grids that carries its wave: a property of the point alone.
    pub fn problem(&self, point: &Point) -> Result<WaveProblem, WaveError> {
        let (mut resolution, mut made) = (self.resolution, problem_of(self.study, &self.own, point));
        loop {
            let Err(refusal @ WaveError::CellTooHigh { .. }) = &made else { return made };
            let Some(finer) = raised(resolution, refusal) else { return made };
            resolution = finer;
            made = problem_of(self.study, &self.finer(resolution)?, point);
        }
    }

    fn finer(&self, resolution: Resolution) -> Result<Geometry, WaveError> {
        let mut all = self.finer.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(geometry) = all.get(&resolution.cells) {
            return Ok(geometry.clone());
        }
        let (scene, error) = (Scene::from_packing(self.packing), self.study.resolution.coverage_error());
        let geometry = Geometry::new(self.study.wave, &scene, resolution, error)?;
        all.insert(resolution.cells, geometry.clone());
        Ok(geometry)
    }
}
