//! The file of a design as written.
//!
//! ```toml
//! base = "ink.toml"                # or a table [base] with a whole study
//! [target]
//! lab = [85, -10, 80]              # at 45:0 under [colour] of the base; or file = "target.cxf"
//! [[vary]]
//! field = "pigment[0].diameter_nm" # a study field, or: ratio = ["yellow", "blue"]
//! from = 100
//! to = 300
//! [design]
//! delta_e = 0.5
//! ```

use crate::input::base::Base;
use crate::input::measured::{MeasuredCondition, MeasuredUnit, Patch};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole file of a design.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignFile {
    /// Heading of the page; the file's name when left out.
    pub title: Option<String>,
    /// The study of all recipes, a file or a table `[base]`: what varies is set in it, and may be
    /// left out.
    pub base: Base,
    /// The colour and the numbers wanted.
    pub target: TargetTable,
    /// What may vary: one to five fields or ratios, each with its range.
    #[serde(default)]
    pub vary: Vec<VaryTable>,
    /// How the recipes are sought.
    #[serde(default)]
    pub design: DesignTable,
}

/// `[target]`: the colour wanted, lit at 45° and seen along the normal, and numbers wanted; one of
/// both at least.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TargetTable {
    /// L*, a*, b* under the light and for the observer of the base's `[colour]`: L* from 0 to 150,
    /// a* and b* from -300 to 300.
    #[schemars(example = (85, -10, 80))]
    pub lab: Option<[f64; 3]>,
    /// A spectrum or a colour, relative to this file, in any format of a study's
    /// `compare.measured`.
    pub file: Option<String>,
    /// Sample in a file with several: its name or number, or its amounts of ink such as
    /// `[0, 0, 100, 0]`.
    pub patch: Option<Patch>,
    /// What a perfect white has in the file: 1 (`factor`) or 100 (`percent`); by default what the
    /// file declares.
    pub unit: Option<MeasuredUnit>,
    /// The instrument's light, where the sample was measured under several.
    pub condition: Option<MeasuredCondition>,
    /// Least Y over black divided by Y over white, 0 to 1.
    #[schemars(example = 0.9)]
    pub contrast_ratio: Option<f64>,
    /// Weighted numbers of the base that are wanted, beside a colour or without one.
    pub number: Vec<NumberTargetTable>,
}

/// `[[target.number]]`: a weighted number of the base, such as a solar reflectance or a density,
/// and the range it is to have: `at_least`, `at_most` or both.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberTargetTable {
    /// Name of a `[[number]]` of the base.
    #[schemars(example = &"solar reflectance")]
    pub name: String,
    /// Least value.
    #[schemars(example = 0.6)]
    pub at_least: Option<f64>,
    /// Largest value.
    pub at_most: Option<f64>,
}

/// `[[vary]]`: a number of the study and its range. What takes solves (shares, sizes, indices) is
/// interpolated between variants; what enters after them is composed exactly and takes no variants:
/// the paper, and thicknesses where the base is composed of slabs.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VaryTable {
    /// Dotted field, as in a sweep, of the layer, its pigments or the paper: a design aims at the
    /// solid. Of a base composed of slabs the smallest `layer.thickness_um` sets the slabs of all.
    pub field: Option<String>,
    /// Two pigments instead, by their names: the first one's part of the sum of both volume
    /// fractions.
    pub ratio: Option<[String; 2]>,
    /// Least value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
    /// Cost of one unit of the field, in any currency: recipes within the requested ΔE₀₀ are ranked
    /// by it.
    pub cost: f64,
}

/// `[design]`: how the recipes are sought.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DesignTable {
    /// Largest ΔE₀₀ to the target colour that is near enough.
    #[schemars(range(min = 0.05, max = 20.0))]
    pub delta_e: f64,
    /// Variants of the base that the surfaces rest on: as many as they need when left out, and one
    /// where nothing is interpolated. Of one interpolated field 6 to 1000 are allowed, of two to
    /// five at least 10, 15, 21 and 28.
    #[schemars(range(min = 1))]
    pub variants: Option<usize>,
    /// Largest number of verifying runs.
    #[schemars(range(min = 1, max = 50))]
    pub verifications: usize,
    /// Realisations of a verifying run; those of the base when left out.
    pub realisations: Option<usize>,
}

impl Default for DesignTable {
    fn default() -> Self {
        Self { delta_e: 0.5, variants: None, verifications: 4, realisations: None }
    }
}
