//! How the numbers are come by: realisations, grid, solver.

use crate::input::forms::strategies;
use crate::input::limits;
use crate::input::study::TargetColour;
use crate::solve::{Goal, SolverChoice};
use crate::wave::Scheme;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[run]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunTable {
    /// Number of independent packings to average over: 24 small varied cells, or 4 fixed ones, when nothing is said.
    #[schemars(transform = limits::REALISATIONS.mark(), example = 24)]
    pub realisations: Option<usize>,
    /// Ends the run as soon as the 95 % interval of the colours is as narrow as this (ΔE₀₀); `realisations`, 400 then when nothing is said,
    /// are the most. In a sweep every variant ends with its own bar; processes that share a folder can do so, shards cannot.
    #[schemars(transform = limits::TARGET_DELTA_E.mark(), example = 0.5)]
    pub target_delta_e: Option<f64>,
    /// Which colours `target_delta_e` speaks of. At 45° to the normal few directions are seen, so that colour takes the most cells.
    pub target_colour: TargetColour,
    /// Largest share of the packings that may have no room; with more of them there is no result. The error bars hold what the missing
    /// cells could change at most.
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

/// `[resolution]`: a wanted accuracy, or the grid itself.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResolutionTable {
    /// Largest wanted error of any order's complex amplitude.
    #[schemars(transform = limits::ACCURACY.mark(), example = 1e-2)]
    pub accuracy: Option<f64>,
    /// Grid points per µm in x and y.
    #[schemars(transform = limits::PER_UM.mark(), example = 14)]
    pub points_per_um: Option<f64>,
    /// Planes with unknowns per µm in z.
    #[schemars(transform = limits::PER_UM.mark(), example = 30)]
    pub planes_per_um: Option<f64>,
    /// Whether longer waves have coarser grids, as far as the accuracy allows; from `accuracy = 1e-3` on when nothing is said, where it
    /// saves a quarter of the time and more. On coarser grids it saves little and leaves a larger error of the grid.
    #[serde(default)]
    #[schemars(example = true)]
    pub per_wavelength: Option<bool>,
    /// The discretisation in z of the scalar wave; Maxwell's equations have two moments a cell whatever it says.
    #[serde(default)]
    pub scheme: Scheme,
}

/// `[solver]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverTable {
    /// `"krylov"`, or with settings `{ krylov = { restart = 60 } }`.
    #[schemars(schema_with = "strategies", extend("default" = "krylov"))]
    pub strategy: SolverChoice,
    /// Relative residual at which a solve counts as converged; a tenth of `resolution.accuracy`, at most 1e-3, when left out, 1e-6
    /// where the grid is given instead.
    #[schemars(transform = limits::TOLERANCE.mark(), example = 1e-4)]
    pub tolerance: Option<f64>,
    /// Most operator applications of one solve.
    #[schemars(transform = limits::APPLICATIONS.mark())]
    pub max_applications: usize,
}

impl Default for SolverTable {
    fn default() -> Self {
        let max_applications = Goal::default().max_applications;
        Self { strategy: SolverChoice::default(), tolerance: None, max_applications }
    }
}
