//! What is wanted of a study: directions, accuracy, the form of the output, and what it is judged by.

use crate::appearance::paper::MirroredSky;
use crate::appearance::viewing::Viewing;
use crate::input::measured::MeasuredSpectrum;
use crate::wave::Scheme;
use crate::wave::contrast::coverage::{EXACT, error_for};
use serde::{Deserialize, Serialize};

/// Directions of the light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Angles {
    /// Polar angles that every realisation is solved at, degrees from the normal, below 90, rising.
    pub exact_deg: Vec<f64>,
    /// Further directions over the hemisphere of the incident side, one in each equal stratum of cos²θ; 0 where only single
    /// angles were asked for.
    pub strata: usize,
    /// The same from the exit side; 0 where the layer is statistically the same from both sides.
    pub exit_strata: usize,
    /// Azimuth of the plane of incidence, degrees; that of a varied cell adds to it.
    pub azimuth_deg: f64,
    /// Largest angle of the picture's axes.
    pub picture_max_deg: f64,
    /// Why there are neither paper nor colour, where the angles are the reason.
    pub no_paper: Option<String>,
}

impl Angles {
    /// Directions that each wavelength is solved at.
    pub fn count(&self) -> usize {
        self.exact_deg.len() + self.strata + self.exit_strata
    }
}

/// A wanted accuracy, or the grid itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WantedResolution {
    /// Largest error of any order's amplitude.
    Accuracy {
        /// Largest error of a complex amplitude.
        amplitude: f64,
        /// Discretisation along z.
        scheme: Scheme,
        /// Whether longer waves may have coarser grids.
        per_wavelength: bool,
    },
    /// Points and planes per µm.
    Grid {
        /// Points along x and y, per µm.
        points_per_um: f64,
        /// Planes along z, per µm.
        planes_per_um: f64,
        /// Discretisation along z.
        scheme: Scheme,
    },
}

impl WantedResolution {
    /// The discretisation in z.
    pub fn scheme(&self) -> Scheme {
        match *self {
            Self::Accuracy { scheme, .. } | Self::Grid { scheme, .. } => scheme,
        }
    }

    /// Relative error of the contrast's coefficients that is nothing beside the grid's: a grid of one's own choice may
    /// be as fine as it likes.
    pub fn coverage_error(&self) -> f64 {
        match *self {
            Self::Accuracy { amplitude, .. } => error_for(amplitude),
            Self::Grid { .. } => EXACT,
        }
    }
}

/// What the results look like; no solve depends on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Folder of the results, if named in the file.
    pub folder: Option<String>,
    /// Side of the picture's square, pixels.
    pub picture_pixels: usize,
    /// What the specular direction reflects.
    pub mirrored_sky: MirroredSky,
}

/// What an ink maker holds the prediction against.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Light and observer.
    pub viewing: Viewing,
    /// L*, a*, b* wanted at 45:0.
    pub target_lab: Option<[f64; 3]>,
    /// A measured spectrum at 45:0.
    pub measured: Option<MeasuredSpectrum>,
}
