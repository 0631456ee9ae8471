//! The light: its wave, wavelengths and directions.

use crate::input::limits;
use crate::wave::Wave;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[light]`: vacuum wavelengths in nm, as a list or as a range.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LightTable {
    /// Which equation is solved, and for which light.
    #[serde(default)]
    pub wave: Wave,
    /// The list.
    #[schemars(transform = limits::WAVELENGTHS_NM.mark(), example = (450, 550, 650))]
    pub wavelengths_nm: Option<Vec<f64>>,
    /// First of the range, nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 400)]
    pub from_nm: Option<f64>,
    /// Last of the range, nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 700)]
    pub to_nm: Option<f64>,
    /// Step of the range, nm.
    #[schemars(transform = limits::STEP_NM.mark(), example = 20)]
    pub step_nm: Option<f64>,
    /// Wavelengths that each realisation is solved at, where a range is given: shifted between the realisations. One for each step when
    /// nothing is said.
    #[schemars(transform = limits::PER_REALISATION.mark(), example = 15)]
    pub per_realisation: Option<usize>,
    /// Solve a range's own wavelengths in every realisation instead of shifted ones.
    #[serde(default)]
    pub sampling: SamplingName,
}

/// Which wavelengths of a range are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SamplingName {
    /// Every realisation has its own shift of the uniform grid; spectra and colours are unbiased.
    #[default]
    Shifted,
    /// The wavelengths written, in every realisation.
    Listed,
}

/// `[angles]`: 0°, 45° and directions over the hemisphere (`count` in all), which paper and picture need, or a list.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnglesTable {
    /// Directions of light for each wavelength (5 when nothing is said): 0°, 45°, and the rest stratified over the hemisphere, shifted
    /// from realisation to realisation.
    #[schemars(transform = limits::DIRECTIONS.mark(), example = 5)]
    pub count: Option<usize>,
    /// Any angles from the normal instead. Where 0° and 45° are among them the hemisphere is solved as well, and paper, colour and
    /// picture are there; otherwise spectra and distributions alone.
    #[schemars(transform = limits::POLARS_DEG.mark(), example = (0, 30, 45, 60))]
    pub polar_deg: Option<Vec<f64>>,
    /// Largest angle of the picture's axes (P1: 60°).
    #[serde(default = "sixty")]
    #[schemars(transform = limits::PICTURE_MAX_DEG.mark())]
    pub picture_max_deg: f64,
    /// Azimuth of the plane of incidence, degrees from x.
    #[serde(default)]
    #[schemars(transform = limits::AZIMUTH_DEG.mark())]
    pub azimuth_deg: f64,
}

impl Default for AnglesTable {
    fn default() -> Self {
        Self { count: None, polar_deg: None, picture_max_deg: sixty(), azimuth_deg: 0.0 }
    }
}

fn sixty() -> f64 {
    60.0
}
