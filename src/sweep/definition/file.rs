//! The sweep file as written.
//!
//! ```toml
//! title = "Yellow: size and share"
//! base = "yellow.toml"                 # a study file beside this one, or a table [base] with a whole study
//! [[axis]]
//! name = "size"
//! field = "pigment[0].diameter_nm"     # or pigment.yellow.diameter_nm; pigment[*] means all pigments
//! values = ["molecular", 100, 300]
//! [[axis]]
//! name = "share"
//! field = "pigment[0].volume_fraction"
//! from = 0.15
//! to = 0.45
//! step = 0.15
//! [[exclude]]
//! where = { size = 300, share = [0.30, 0.45] }
//! ```

use super::file_schema::{base, fields};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// A whole sweep file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// Heading of the report; the file's name when left out.
    pub title: Option<String>,
    /// The study that all variants start from.
    pub base: Base,
    /// What varies; the last axis is the fastest.
    #[serde(default)]
    pub axis: Vec<AxisTable>,
    /// Variants that are left out.
    #[serde(default)]
    pub exclude: Vec<ExcludeTable>,
    /// Fields of some variants, set after the axes.
    #[serde(default, rename = "override")]
    pub overrides: Vec<OverrideTable>,
    /// The axes of the contact sheets.
    #[serde(default)]
    pub sheet: SheetTable,
    /// The variant that colour differences refer to; the first one when left out.
    #[schemars(with = "Option<Names>", example = Names::from([("share".to_owned(), "30 %".into())]))]
    pub reference: Option<Where>,
    /// Inequalities about the variants, to be judged.
    #[serde(default)]
    pub conclusion: Vec<ConclusionTable>,
}

/// The study that all variants start from.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "a study file's path, or a table with a whole study")]
pub enum Base {
    /// File of the study.
    Path(String),
    /// The study itself.
    Table(Table),
}

impl JsonSchema for Base {
    fn schema_name() -> Cow<'static, str> {
        "Base".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        base()
    }
}

/// `[[axis]]`: a field with its values, or named cases that set several fields at once.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisTable {
    /// Short name for captions and conditions; the field's last part when left out.
    pub name: Option<String>,
    /// Dotted field that varies.
    pub field: Option<String>,
    /// Its values.
    #[schemars(with = "Option<Vec<serde_json::Value>>", example = [0.15, 0.3, 0.5])]
    pub values: Option<Vec<Value>>,
    /// Captions of the values.
    pub labels: Option<Vec<String>>,
    /// First value of a range.
    pub from: Option<f64>,
    /// Last value of a range.
    pub to: Option<f64>,
    /// Step of a range.
    pub step: Option<f64>,
    /// Number of values from `from` to `to`, both included; instead of `step`.
    pub count: Option<usize>,
    /// Axes with the same word here advance together instead of forming a product.
    pub zip: Option<String>,
    /// Settings of several fields each.
    #[serde(default)]
    pub case: Vec<CaseTable>,
}

/// `[[axis.case]]`
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseTable {
    /// Label of the setting.
    pub label: String,
    /// Dotted field (in quotes) → value.
    #[serde(default)]
    #[schemars(schema_with = "fields")]
    pub set: Table,
}

/// Axis name → label, value, or list of them. Axes that are not named match anything.
pub type Where = BTreeMap<String, Value>;
/// [`Where`] with JSON values.
type Names = BTreeMap<String, serde_json::Value>;

/// `[[exclude]]`: variants that are left out.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExcludeTable {
    /// Which variants are left out.
    #[serde(rename = "where")]
    #[schemars(with = "Names", example = Names::from([("share".to_owned(), "30 %".into())]))]
    pub condition: Where,
}

/// `[[override]]`: fields of some variants, set after the axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OverrideTable {
    /// Which variants are changed.
    #[serde(rename = "where")]
    #[schemars(with = "Names", example = Names::from([("share".to_owned(), "30 %".into())]))]
    pub condition: Where,
    /// Dotted field → value.
    #[schemars(schema_with = "fields")]
    pub set: Table,
}

/// `[sheet]`: the axes of the contact sheets; the others give one sheet for each of their values.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SheetTable {
    /// Axis along the sheet's rows.
    pub rows: Option<String>,
    /// Axis along the sheet's columns.
    pub columns: Option<String>,
}

/// `[[conclusion]]`: an inequality about the variants.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConclusionTable {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// Whose sentence it is, such as `P1`; a question of the sweep's own when left out. Pages keep the two apart.
    pub source: Option<String>,
    /// The source's own words.
    pub quote: Option<String>,
    /// The quote in English.
    pub translation: Option<String>,
    /// Why this inequality and these bounds.
    pub because: Option<String>,
    /// Name of an axis: the conclusion is asked for each of its labels, with `label: ` before its `id`.
    pub each: Option<String>,
    /// What is measured of each variant.
    pub quantity: Quantity,
    /// For `transmittance` and `reflectance`: one wavelength.
    pub wavelength_nm: Option<f64>,
    /// For `transmittance` and `reflectance`: the wavelengths from the first to the second, all of which count as `over` says.
    pub range_nm: Option<[f64; 2]>,
    /// At which wavelengths of the range the inequality is to hold.
    #[serde(default)]
    pub over: Over,
    /// Of the range only the wavelengths that this variant absorbs well: where its transmittance is in the lower half
    /// between its least and its greatest in the range.
    #[schemars(with = "Option<Names>")]
    pub absorbed_by: Option<Where>,
    /// The size of the sum counts, whatever its sign.
    #[serde(default)]
    pub absolute: bool,
    /// Variants whose quantity is added.
    #[schemars(with = "Vec<Names>")]
    pub plus: Vec<Where>,
    /// Variants whose quantity is subtracted; for `delta_e` the other colour.
    #[serde(default)]
    #[schemars(with = "Vec<Names>")]
    pub minus: Vec<Where>,
    /// Least value that confirms it.
    pub at_least: Option<f64>,
    /// Most value that confirms it.
    pub at_most: Option<f64>,
    /// Variants along a curve: instead of the sum itself, the place on this curve that has the same value is measured,
    /// such as the diameter of the spheres that an agglomerate acts like.
    #[serde(default)]
    #[schemars(with = "Vec<Names>")]
    pub among: Vec<Where>,
    /// The places of `among`, rising, such as their diameters in nm.
    #[serde(default)]
    pub along: Vec<f64>,
}

/// At which wavelengths of its range a conclusion is to hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// At every one.
    #[default]
    Every,
    /// At one or more.
    Some,
    /// On their mean.
    Mean,
}

/// What a conclusion compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// C* under natural light.
    Chroma,
    /// L* under natural light.
    Lightness,
    /// Hue angle under natural light, degrees.
    Hue,
    /// T of the layer alone at the smallest angle.
    Transmittance,
    /// R of the layer alone at the smallest angle.
    Reflectance,
    /// CIEDE2000 between one `plus` and one `minus`.
    DeltaE,
    /// Y over black divided by Y over white, lit at 45° and seen along the normal, 0–1.
    ContrastRatio,
    /// CIEDE2000 of each variant to its own `colour.target_lab`.
    DeltaEToTarget,
}
