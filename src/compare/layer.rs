//! The packed layer that strategies are compared on.

use super::error::CompareError;
use crate::ink::{PackingRequest, PigmentGrains, pack};
use crate::input::case::Case;
use crate::wave::{Incidence, Media, Scene, Side};
use num_complex::Complex64;
use serde::Deserialize;

/// Equal spheres in a binder, between vacuum half-spaces.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackedLayer {
    /// Lateral period, µm.
    pub period_um: f64,
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Diameter of the spheres, nm.
    pub diameter_nm: f64,
    /// Their volume over the layer's.
    pub volume_fraction: f64,
    /// Index of the spheres as [re, im].
    pub pigment: [f64; 2],
    /// Index of the binder as [re, im].
    pub binder: [f64; 2],
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Polar angle from the normal, degrees.
    #[serde(default)]
    pub polar_deg: f64,
    /// Azimuth from the x axis, degrees.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Seed of the packing.
    #[serde(default)]
    pub seed: u64,
}

impl PackedLayer {
    pub(crate) fn case(&self) -> Result<Case, CompareError> {
        let request = PackingRequest {
            period_um: [self.period_um; 2],
            thickness_um: self.thickness_um,
            pigments: vec![PigmentGrains::spheres(self.diameter_nm, self.volume_fraction)],
            seed: self.seed,
            ..PackingRequest::default()
        };
        let scene = Scene::from_packing(&pack(&request, &mut ())?);
        let index = |[re, im]: [f64; 2]| Complex64::new(re, im);
        let media = Media {
            incident: Complex64::ONE,
            exit: Complex64::ONE,
            backgrounds: vec![index(self.binder)],
            inclusions: vec![index(self.pigment)],
        };
        let incidence = Incidence {
            wavelength_um: self.wavelength_um,
            polar_deg: self.polar_deg,
            azimuth_deg: self.azimuth_deg,
            from: Side::Incident,
        };
        scene.check(&media)?;
        incidence.check()?;
        Ok(Case { scene, media, incidence })
    }
}
