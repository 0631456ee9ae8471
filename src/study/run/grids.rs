//! The grids of one realisation: one per wavelength, and finer ones for the few waves that these
//! cannot represent.

use super::error::RunError;
use super::point::systems_of;
use crate::ink::Packing;
use crate::input::study::{Point, Study};
use crate::solve::accuracy::raised;
use crate::wave::{Geometry, Precision, Resolution, Scene, System, WaveError};
use std::sync::{Mutex, PoisonError};

/// The grid of one wavelength, and the packing on it.
pub struct Wavelength {
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// The grid.
    pub resolution: Resolution,
    /// The packing on that grid.
    pub geometry: Geometry,
}

impl Wavelength {
    /// The grids of all wavelengths; `cover` computes the packing's coverage once per grid.
    pub fn all(
        wavelengths_um: impl Iterator<Item = f64>,
        grid: impl Fn(f64) -> Resolution,
        mut cover: impl FnMut(Resolution) -> Result<Geometry, RunError>,
    ) -> Result<Vec<Self>, RunError> {
        let mut made: Vec<Self> = Vec::new();
        for wavelength_um in wavelengths_um {
            if made.iter().any(|known| known.wavelength_um == wavelength_um) {
                continue;
            }
            let resolution = grid(wavelength_um);
            let known = made.iter().find(|known| known.resolution == resolution);
            let geometry = known.map_or_else(|| cover(resolution), |known| Ok(known.geometry.clone()))?;
            made.push(Self { wavelength_um, resolution, geometry });
        }
        Ok(made)
    }

    /// The grid of a point's wavelength.
    pub fn of<'a>(all: &'a [Self], point: &Point) -> &'a Self {
        let own = |known: &&Self| known.wavelength_um == point.incidence.wavelength_um;
        all.iter().find(own).expect("the grids of all solves to be made")
    }
}

/// The grid was chosen on other packings and at the probed wavelengths. A cell of this packing may
/// contain more pigment, and a wavelength between the probes may meet a larger index, for which the
/// cells of the chosen grid are too high.
pub(super) struct Grids<'a> {
    study: &'a Study,
    packing: &'a Packing,
    own: Vec<Wavelength>,
    finer: Mutex<Vec<(Resolution, Geometry)>>,
}

impl<'a> Grids<'a> {
    pub fn new(study: &'a Study, packing: &'a Packing, own: Vec<Wavelength>) -> Self {
        Self { study, packing, own, finer: Mutex::default() }
    }

    /// The problems of a point, one per polarisation, on the coarsest grid that can represent its
    /// wave; the choice depends on the point alone.
    pub fn systems(&self, point: &Point) -> Result<Vec<Box<dyn System>>, WaveError> {
        let own = Wavelength::of(&self.own, point);
        let (mut resolution, mut made) = (own.resolution, systems_of(self.study, &own.geometry, point));
        loop {
            let Err(refusal @ WaveError::CellTooHigh { .. }) = &made else { return made };
            let Some(finer) = raised(resolution, refusal) else { return made };
            resolution = finer;
            made = systems_of(self.study, &self.finer(resolution)?, point);
        }
    }

    fn finer(&self, resolution: Resolution) -> Result<Geometry, WaveError> {
        let mut all = self.finer.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, geometry)) = all.iter().find(|(kept, _)| *kept == resolution) {
            return Ok(geometry.clone());
        }
        let precision = Precision::of(self.study.resolution.coverage_error());
        let scene = Scene::from_packing(self.packing);
        let geometry = Geometry::new(self.study.wave, &scene, resolution, precision)?;
        all.push((resolution, geometry.clone()));
        Ok(geometry)
    }
}
