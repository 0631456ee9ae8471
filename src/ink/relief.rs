//! Micro-relief: the binder's surface below the tops of the grains.

use super::error::PackError;
use serde::{Deserialize, Serialize};

/// What is asked of the binder's surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReliefRequest {
    /// Mean depth of the dry ink's level below the top of the layer: pigment and binder together would fill
    /// the layer up to H − depth if they were levelled.
    pub depth_um: f64,
    #[serde(default)]
    pub rule: ReliefRule,
}

/// The shape of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ReliefRule {
    /// One level everywhere.
    #[default]
    Flat,
    /// The level plus `follow` times the deviation of the grains' tops from their mean, smoothed by a Gaussian
    /// of standard deviation `smoothing_um` (capillary forces level what is shorter).
    Following { follow: f64, smoothing_um: f64 },
}

impl ReliefRequest {
    pub(crate) fn check(&self, thickness_um: f64, walls: bool) -> Result<(), PackError> {
        if !walls {
            let advice = "set walls = true, or leave the relief out";
            return Err(PackError::input(
                "relief",
                "with walls = false",
                "relief between walls only",
                advice,
            ));
        }
        if !(self.depth_um >= 0.0 && self.depth_um < thickness_um) {
            let allowed = format!("0 up to the thickness, {thickness_um} µm");
            return Err(PackError::input("relief.depth_um", self.depth_um, allowed, "lower the depth"));
        }
        Ok(())
    }
}

/// Height of pigment and binder levelled out.
pub(crate) fn dry_height_um(request: &ReliefRequest, thickness_um: f64) -> f64 {
    thickness_um - request.depth_um
}

/// The binder's surface as heights above the paper on a periodic grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    heights_um: Vec<f64>,
    count: [usize; 2],
    period_um: [f64; 2],
}

impl Relief {
    pub fn height_um(&self, _x_um: f64, _y_um: f64) -> f64 {
        self.heights_um[0]
    }
}
