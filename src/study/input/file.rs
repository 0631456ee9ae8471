//! The study file as written: TOML with units in the names of its keys, not yet checked.
//!
//! ```toml
//! title = "Yellow ink, 30 %"
//! [layer]
//! # period_um = 1.6                    # nominal; by default it follows from the grains
//! thickness_um = 1.0
//! binder.index = 1.558
//! [[pigment]]
//! name = "yellow"
//! diameter_nm = 250
//! volume_fraction = 0.30
//! index = { built_in = "yellow" }      # or { n = 1.4, k = 0.1 }, { csv = "measured.csv" }
//! [light]
//! from_nm = 400
//! to_nm = 700
//! step_nm = 30
//! ```

mod appearance;
mod calculation;
mod layer;
mod light;
mod microstructure;

pub use appearance::{ColourTable, CompareTable, CouplingName, OutputTable, PaperTable};
pub use calculation::{ResolutionTable, RunTable, SolverTable, TargetColour};
pub use layer::{BinderTable, ComposedTable, LayerTable, PackingTable, PigmentTable, ShellTable};
pub use light::{AnglesTable, LightTable, SamplingName};
pub use microstructure::{Continuation, FileNames, LengthUnit, MicrostructureTable, SizeColumn, VoxelEdges};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole study file. Missing tables take the defaults given for their fields.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Title of the report (default: name of the file).
    #[schemars(example = &"Yellow ink, 30 %")]
    pub title: Option<String>,
    /// The periodic cell and the media on both sides of it.
    pub layer: LayerTable,
    /// The pigments, one `[[pigment]]` each; without any the layer consists of binder only.
    #[serde(default, rename = "pigment")]
    pub pigments: Vec<PigmentTable>,
    /// How the grains are placed.
    #[serde(default)]
    pub packing: PackingTable,
    /// The Lambertian substrate.
    #[serde(default)]
    pub paper: PaperTable,
    /// Vacuum wavelengths (default: 400 to 700 nm in steps of 20 nm).
    #[serde(default)]
    pub light: LightTable,
    /// Directions of the light.
    #[serde(default)]
    pub angles: AnglesTable,
    /// Number of packings, and their seed.
    #[serde(default)]
    pub run: RunTable,
    /// The requested accuracy (default: 1e-2, or 3e-2 with a target), or the grid.
    #[serde(default)]
    pub resolution: ResolutionTable,
    /// How the wave equation is solved.
    #[serde(default)]
    pub solver: SolverTable,
    /// Form of the results; no solve depends on it.
    #[serde(default)]
    pub output: OutputTable,
    /// Conditions of the numbers for ink makers; everything else uses D65 and the 2° observer.
    #[serde(default)]
    pub colour: ColourTable,
    /// What the prediction is compared with.
    #[serde(default)]
    pub compare: CompareTable,
}
