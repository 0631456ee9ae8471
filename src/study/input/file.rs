//! The study file as written: TOML with the units in the key names, nothing checked yet.
//!
//! ```toml
//! title = "Yellow ink, 30 %"
//! [layer]
//! # period_um = 1.6                    # nominal; follows from the grains when left out
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

pub use appearance::{ColourTable, CompareTable, CouplingName, OutputTable, PaperTable};
pub use calculation::{ResolutionTable, RunTable, SolverTable};
pub use layer::{BinderTable, ComposedTable, LayerTable, PackingTable, PigmentTable};
pub use light::{AnglesTable, LightTable, SamplingName};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole study file. Tables left out take the defaults documented on their fields.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Shown as the report's heading; the file's name when left out.
    #[schemars(example = &"Yellow ink, 30 %")]
    pub title: Option<String>,
    /// The periodic cell and what lies above and below it.
    pub layer: LayerTable,
    /// The kinds of grains, one `[[pigment]]` each; without any the layer is its binder alone.
    #[serde(default, rename = "pigment")]
    pub pigments: Vec<PigmentTable>,
    /// How the grains come to their places.
    #[serde(default)]
    pub packing: PackingTable,
    /// The Lambertian substrate.
    #[serde(default)]
    pub paper: PaperTable,
    /// Vacuum wavelengths; 400 to 700 nm by 20 nm when left out.
    #[serde(default)]
    pub light: LightTable,
    /// Directions of the light.
    #[serde(default)]
    pub angles: AnglesTable,
    /// How many packings, and their seed.
    #[serde(default)]
    pub run: RunTable,
    /// A wanted accuracy, 1e-2 when nothing is said, or the grid itself.
    #[serde(default)]
    pub resolution: ResolutionTable,
    /// How the wave equation is solved.
    #[serde(default)]
    pub solver: SolverTable,
    /// What the results look like; no solve depends on it.
    #[serde(default)]
    pub output: OutputTable,
    /// The conditions of an ink maker's numbers, beside D65 and the 2° observer of everything else.
    #[serde(default)]
    pub colour: ColourTable,
    /// What the prediction is held against.
    #[serde(default)]
    pub compare: CompareTable,
}
