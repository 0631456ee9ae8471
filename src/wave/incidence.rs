//! The incident plane wave.

use serde::{Deserialize, Serialize};

/// The side the light comes from. The layer is 0 ≤ z ≤ H; `Above` is z < 0, `Below` is z > H.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    #[default]
    Above,
    Below,
}

/// A plane wave: vacuum wavelength in µm, polar angle from the layer's normal (0° ≤ σ < 90°) and
/// azimuth φ, both in the half-space it comes from (P2 section 2: kx = k sin σ cos φ).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Incidence {
    pub wavelength_um: f64,
    pub polar_deg: f64,
    pub azimuth_deg: f64,
    pub from: Side,
}
