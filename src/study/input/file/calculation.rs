//! The calculation: realisations, grid, solver.

use crate::input::forms::strategies;
use crate::input::limits;
use crate::solve::{Goal, SolverChoice};
use crate::wave::Scheme;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
