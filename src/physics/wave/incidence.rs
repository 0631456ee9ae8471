//! The incident plane wave.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A side of the layer 0 ≤ z ≤ H. By default light comes from the incident side, z < 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// z < 0.
    #[default]
    Incident,
    /// z > H.
    Exit,
}

/// A plane wave: vacuum wavelength in µm, polar angle from the layer's normal (0° ≤ σ < 90°) and
/// azimuth φ, both in the half-space of incidence (P2 section 2: kx = k sin σ cos φ).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Incidence {
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Polar angle σ from the layer's normal, degrees.
    pub polar_deg: f64,
    /// Azimuth φ from the x axis, degrees.
    pub azimuth_deg: f64,
    /// Side of incidence.
    pub from: Side,
}

impl Incidence {
    /// Rejects wavelengths that are not positive and angles outside 0° ≤ σ < 90°.
    pub fn check(&self) -> Result<(), super::WaveError> {
        let [wavelength, polar, azimuth] = [self.wavelength_um, self.polar_deg, self.azimuth_deg];
        let grazing = "grazing light carries no flux into the layer: use 89 or less";
        let rules = [
            ("wavelength (µm)", wavelength, wavelength > 0.0, "finite and above 0", "give it in µm"),
            ("polar angle (degrees)", polar, (0.0..90.0).contains(&polar), "0 ≤ σ < 90", grazing),
            ("azimuth (degrees)", azimuth, true, "any finite angle", "give it in degrees"),
        ];
        for (field, value, is_allowed, allowed, remedy) in rules {
            if !(value.is_finite() && is_allowed) {
                return Err(super::WaveError::range(field, value, allowed, remedy));
            }
        }
        Ok(())
    }
}
