//! The calculation: the light with its wavelengths and directions, realisations, grid, solver.

use crate::input::forms::strategies;
use crate::input::limits;
use crate::solve::{Goal, SolverChoice};
use crate::wave::{Scheme, Wave};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[light]`: vacuum wavelengths in nm, as a list or as a range.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightTable {
    /// The equation to solve, and the polarisation of the light.
    pub wave: Wave,
    /// List of wavelengths, nm; of a wide range with steps that grow, such as 20 nm where eyes see
    /// and 100 nm in the near infrared. Colours take those from 380 to 780 nm, spectra all.
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

/// `[run]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunTable {
    /// Number of independent packings to average over (default: 24 small varied cells, or 4 fixed
    /// ones).
    #[schemars(transform = limits::REALISATIONS.mark(), example = 24)]
    pub realisations: Option<usize>,
    /// Ends the run as soon as the 95 % interval of the colours is below this (ΔE₀₀);
    /// `realisations` (default then: 400) is the maximum. In a sweep every variant has its own
    /// interval; processes that share a folder support this, shards do not.
    #[schemars(transform = limits::TARGET_DELTA_E.mark(), example = 0.5)]
    pub target_delta_e: Option<f64>,
    /// Colours to which `target_delta_e` applies. Few directions contribute to the colour at 45:0,
    /// so it needs the most cells.
    pub target_colour: TargetColour,
    /// Largest share of packings that may have no room for their grains; with more there is no
    /// result. The error bars include the largest effect that the missing cells could have.
    #[schemars(transform = limits::FAILED_PACKINGS.mark())]
    pub failed_packings: f64,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for RunTable {
    fn default() -> Self {
        Self {
            realisations: None,
            target_delta_e: None,
            target_colour: TargetColour::Every,
            failed_packings: 0.1,
            seed: 1,
        }
    }
}

/// `[resolution]`: the requested accuracy, or the grid.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ResolutionTable {
    /// Maximum error of any order's complex amplitude.
    #[schemars(transform = limits::ACCURACY.mark(), example = 1e-2)]
    pub accuracy: Option<f64>,
    /// Grid points per µm in x and y.
    #[schemars(transform = limits::PER_UM.mark(), example = 14)]
    pub points_per_um: Option<f64>,
    /// Planes with unknowns per µm in z.
    #[schemars(transform = limits::PER_UM.mark(), example = 30)]
    pub planes_per_um: Option<f64>,
    /// Whether longer waves use coarser grids, as far as the accuracy allows (default: if
    /// `accuracy` is 1e-3 or smaller, where it saves a quarter of the time or more). With coarser
    /// grids it saves little and increases the grid's error.
    #[schemars(example = true)]
    pub per_wavelength: Option<bool>,
    /// Discretisation of the scalar wave along z; Maxwell's equations always use two moments per
    /// cell.
    pub scheme: Scheme,
}

/// `[solver]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverTable {
    /// Strategy: `"krylov"`, or with settings `{ krylov = { restart = 60 } }`.
    #[schemars(schema_with = "strategies", extend("default" = "krylov"))]
    pub strategy: SolverChoice,
    /// Relative residual at which a solve has converged (default: a tenth of
    /// `resolution.accuracy`, at most 1e-3, or 1e-6 if the grid is given).
    #[schemars(transform = limits::TOLERANCE.mark(), example = 1e-4)]
    pub tolerance: Option<f64>,
    /// Maximum number of operator applications per solve.
    #[schemars(transform = limits::APPLICATIONS.mark())]
    pub max_applications: usize,
}

impl Default for SolverTable {
    fn default() -> Self {
        let max_applications = Goal::default().max_applications;
        Self { strategy: SolverChoice::default(), tolerance: None, max_applications }
    }
}

/// Colours to which `target_delta_e` applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TargetColour {
    /// All of them.
    #[default]
    Every,
    /// Under a uniform sky, viewed along the normal.
    NaturalLight,
    /// Lit at 45°, viewed along the normal.
    #[serde(rename = "lit_at_45")]
    LitAt45,
}
