//! The ink at 45:0 as light between it and any paper meets it, from which its factors on all papers
//! follow.

use super::{BLACK, WHITE, in_light_of};
use crate::appearance::paper::PRINT_DEG;
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::evaluate::ink::{InkError, InkOnPaper};
use crate::evaluate::prints::LitAreas;
use crate::input::study::Study;

/// The ink lit at 45° and seen along the normal, without its paper.
#[derive(Clone, Debug)]
pub struct BareInk {
    wavelengths_nm: Vec<f64>,
    /// \[wavelength\]
    at_45: Vec<AreaOptics>,
}

impl BareInk {
    /// The mean of an ink.
    ///
    /// # Errors
    /// None: 45° and 0° are within the hemisphere.
    pub fn new(ink: &InkOnPaper) -> Result<Self, InkError> {
        let light = ink.at(PRINT_DEG)?;
        let view = ink.at(0.0)?;
        Ok(Self {
            wavelengths_nm: ink.wavelengths_nm().to_vec(),
            at_45: ink.layers().iter().map(|layer| layer.optics(&light, &view)).collect(),
        })
    }

    /// Factors on the paper of a study under the study's own light, over black and over white, one
    /// after another.
    ///
    /// # Errors
    /// Paper without an albedo at one of the wavelengths, an illuminant that is not known.
    pub fn factors(&self, study: &Study) -> Result<Vec<f64>, InkError> {
        let nm = &self.wavelengths_nm;
        let mix = AreaMix::whole();
        let light = in_light_of(study)?;
        let emitted = light.as_ref().map(|light| light.below(&mix, &[&self.at_45], nm));
        let albedos = nm.iter().map(|&nm| study.paper.albedo.at(nm)).collect::<Result<Vec<_>, _>>()?;
        let kinds: [&[AreaOptics]; 1] = [&self.at_45];
        let emitted = emitted.as_ref();
        let lit = LitAreas { mix: &mix, kinds: &kinds, albedos: &albedos, emitted, wavelengths_nm: nm };
        let mut factors = lit.factors();
        for albedo in [BLACK, WHITE] {
            factors.extend(self.at_45.iter().map(|area| mix.factor(&[*area], albedo, &[])));
        }
        Ok(factors)
    }
}
