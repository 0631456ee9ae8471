//! The incident plane wave.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A side of the layer 0 ≤ z ≤ H. Where nothing else is said light comes from the incident side, z < 0.
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
/// azimuth φ, both in the half-space it comes from (P2 section 2: kx = k sin σ cos φ).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Incidence {
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// σ, from the layer's normal, degrees.
    pub polar_deg: f64,
    /// φ, from the x axis, degrees.
    pub azimuth_deg: f64,
    /// The side that the light comes from.
    pub from: Side,
}

impl Incidence {
    /// Refuses wavelengths that are not positive and angles outside 0° ≤ σ < 90°.
    pub fn check(&self) -> Result<(), super::WaveError> {
        let range = |field, value, allowed, remedy| super::WaveError::Range { field, value, allowed, remedy };
        if !(self.wavelength_um.is_finite() && self.wavelength_um > 0.0) {
            return Err(range("wavelength (µm)", self.wavelength_um, "finite and above 0", "give it in µm"));
        }
        if !(0.0..90.0).contains(&self.polar_deg) {
            let remedy = "grazing light carries no flux into the layer: use 89 or less";
            return Err(range("polar angle (degrees)", self.polar_deg, "0 ≤ σ < 90", remedy));
        }
        if !self.azimuth_deg.is_finite() {
            return Err(range(
                "azimuth (degrees)",
                self.azimuth_deg,
                "any finite angle",
                "give it in degrees",
            ));
        }
        Ok(())
    }
}
