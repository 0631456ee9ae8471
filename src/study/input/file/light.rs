//! The light: the wave equation, wavelengths and directions.

use crate::input::limits;
use crate::wave::Wave;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[light]`: vacuum wavelengths in nm, as a list or as a range.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightTable {
    /// The equation to solve, and the polarisation of the light.
    pub wave: Wave,
    /// List of wavelengths, nm.
    #[schemars(transform = limits::WAVELENGTHS_NM.mark(), example = (450, 550, 650))]
    pub wavelengths_nm: Option<Vec<f64>>,
    /// First wavelength of the range, nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 400)]
    pub from_nm: Option<f64>,
    /// Last wavelength of the range, nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 700)]
    pub to_nm: Option<f64>,
    /// Step of the range, nm.
    #[schemars(transform = limits::STEP_NM.mark(), example = 20)]
    pub step_nm: Option<f64>,
    /// Number of wavelengths per realisation, for a range: they are shifted between realisations
    /// (default: one per step).
    #[schemars(transform = limits::PER_REALISATION.mark(), example = 15)]
    pub per_realisation: Option<usize>,
    /// Use a range's own wavelengths in every realisation instead of shifted ones.
    pub sampling: SamplingName,
}

/// Which wavelengths of a range are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SamplingName {
    /// Every realisation shifts the uniform grid; spectra and colours are unbiased.
    #[default]
    Shifted,
    /// The given wavelengths, in every realisation.
    Listed,
}

/// `[angles]`: 0°, 45° and directions over the hemisphere (`count` in all), as paper and picture
/// need them, or a list.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AnglesTable {
    /// Number of directions per wavelength (default: 5): 0°, 45°, and the rest stratified over the
    /// hemisphere, shifted between realisations.
    #[schemars(transform = limits::DIRECTIONS.mark(), example = 5)]
    pub count: Option<usize>,
    /// A list of angles from the normal instead. If it includes 0° and 45°, the hemisphere is
    /// added, and there are paper, colour and picture; otherwise only spectra and distributions.
    #[schemars(transform = limits::POLARS_DEG.mark(), example = (0, 30, 45, 60))]
    pub polar_deg: Option<Vec<f64>>,
    /// Largest angle of the picture's axes (P1: 60°).
    #[schemars(transform = limits::PICTURE_MAX_DEG.mark())]
    pub picture_max_deg: f64,
    /// Azimuth of the plane of incidence from x, degrees.
    #[schemars(transform = limits::AZIMUTH_DEG.mark())]
    pub azimuth_deg: f64,
}

impl Default for AnglesTable {
    fn default() -> Self {
        Self { count: None, polar_deg: None, picture_max_deg: 60.0, azimuth_deg: 0.0 }
    }
}
