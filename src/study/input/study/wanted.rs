//! What is requested from a study: directions, accuracy, output, and comparison.

use crate::appearance::viewing::Viewing;
use crate::input::measured::MeasuredSpectrum;
use crate::wave::Scheme;
use crate::wave::contrast::coverage::{EXACT, error_for};
use serde::{Deserialize, Serialize};

/// Directions of the light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Angles {
    /// Polar angles common to all realisations, degrees from the normal, below 90, increasing.
    pub exact_deg: Vec<f64>,
    /// Number of directions over the hemisphere of the incident side, one in each equal stratum of
    /// cos²θ; 0 if only single angles are requested.
    pub strata: usize,
    /// Number of directions over the hemisphere of the exit side; 0 if the layer is statistically
    /// the same from both sides.
    pub exit_strata: usize,
    /// Azimuth of the plane of incidence, degrees; that of a varied cell is added.
    pub azimuth_deg: f64,
    /// Largest angle of the picture's axes.
    pub picture_max_deg: f64,
    /// Why the angles do not allow paper and colour; `None` if they do.
    pub no_paper: Option<String>,
}

impl Angles {
    /// Number of directions per wavelength.
    pub fn count(&self) -> usize {
        self.exact_deg.len() + self.strata + self.exit_strata
    }
}

/// The requested accuracy, or the grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WantedResolution {
    /// Largest error of any order's amplitude.
    Accuracy {
        /// Largest error of a complex amplitude.
        amplitude: f64,
        /// Discretisation along z.
        scheme: Scheme,
        /// Whether longer waves may use coarser grids.
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
    /// The discretisation along z.
    pub fn scheme(&self) -> Scheme {
        match *self {
            Self::Accuracy { scheme, .. } | Self::Grid { scheme, .. } => scheme,
        }
    }

    /// Relative error of the contrast's Fourier coefficients that is negligible compared with that
    /// of the grid; a given grid may be arbitrarily fine.
    pub fn coverage_error(&self) -> f64 {
        match *self {
            Self::Accuracy { amplitude, .. } => error_for(amplitude),
            Self::Grid { .. } => EXACT,
        }
    }
}

/// What an ink maker compares the prediction with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Illuminant, observer and summation.
    pub viewing: Viewing,
    /// Target L*, a*, b* at 45:0.
    pub target_lab: Option<[f64; 3]>,
    /// A measured spectrum at 45:0.
    pub measured: Option<MeasuredSpectrum>,
}
