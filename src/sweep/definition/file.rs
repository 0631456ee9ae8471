//! The sweep file as written.
//!
//! ```toml
//! title = "Yellow: size and share"
//! base = "yellow.toml"                 # a study file beside this one, or a whole study in [base]
//! [[axis]]
//! name = "size"
//! field = "pigment[0].diameter_nm"     # or pigment.yellow.diameter_nm; pigment[*] means all
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
//!
//! The schema says what these types do not express: the axes may complete the base study, and they
//! set fields of a study.

use crate::input::base::Base;
use crate::input::field::fields_schema;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// A whole sweep file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepFile {
    /// Title of the report (default: name of the file).
    pub title: Option<String>,
    /// The study that all variants are based on.
    pub base: Base,
    /// What varies; the last axis varies fastest.
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
    /// The reference variant of colour differences (default: the first).
    #[schemars(with = "Option<Names>", example = Names::from([("share".to_owned(), "30 %".into())]))]
    pub reference: Option<Where>,
    /// Inequalities about the variants, to be tested.
    #[serde(default)]
    pub conclusion: Vec<ConclusionTable>,
}

/// `[[axis]]`: a field with its values, or named cases that set several fields at once.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AxisTable {
    /// Short name for captions and conditions (default: last part of the field).
    pub name: Option<String>,
    /// Dotted name of the field that varies.
    pub field: Option<String>,
    /// Its values.
    #[schemars(with = "Option<Vec<serde_json::Value>>", example = (0.15, 0.3, 0.5))]
    pub values: Option<Vec<Value>>,
    /// Captions of the values.
    pub labels: Option<Vec<String>>,
    /// First value of a range.
    pub from: Option<f64>,
    /// Last value of a range.
    pub to: Option<f64>,
    /// Step of a range, which reaches `to`.
    pub step: Option<f64>,
    /// Number of values from `from` to `to`, both included; replaces `step`.
    pub count: Option<usize>,
    /// Axes with the same word here advance together instead of forming a product.
    pub zip: Option<String>,
    /// Named settings of several fields.
    pub case: Vec<CaseTable>,
}

/// `[[axis.case]]`
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseTable {
    /// Label of the setting.
    pub label: String,
    /// Dotted name of a field (in quotes) → value.
    #[serde(default)]
    #[schemars(schema_with = "fields_schema")]
    pub set: Table,
}

/// Axis name → label, value, or list of them. Axes that are not named are unrestricted.
pub type Where = BTreeMap<String, Value>;
/// [`Where`] with JSON values.
type Names = BTreeMap<String, serde_json::Value>;

/// `[[exclude]]`: variants that are left out.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExcludeTable {
    /// Variants to leave out.
    #[serde(rename = "where")]
    #[schemars(with = "Names", example = Names::from([("share".to_owned(), "30 %".into())]))]
    pub condition: Where,
}

/// `[[override]]`: fields of some variants, set after the axes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OverrideTable {
    /// Variants to change.
    #[serde(rename = "where")]
    #[schemars(with = "Names", example = Names::from([("share".to_owned(), "30 %".into())]))]
    pub condition: Where,
    /// Dotted name of a field → value.
    #[schemars(schema_with = "fields_schema")]
    pub set: Table,
}

/// `[sheet]`: axes of the contact sheets; each setting of the other axes has a sheet of its own.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SheetTable {
    /// Axis of the rows.
    pub rows: Option<String>,
    /// Axis of the columns.
    pub columns: Option<String>,
}

/// `[[conclusion]]`: an inequality about the variants.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConclusionTable {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// Source of the statement, such as `P1` (default: a question of the sweep's own). The report
    /// separates the two.
    pub source: Option<String>,
    /// The wording of the source.
    pub quote: Option<String>,
    /// The quote in English.
    pub translation: Option<String>,
    /// Why this inequality and these bounds were chosen.
    pub because: Option<String>,
    /// Name of an axis: the conclusion is repeated for each of its labels, with `label: ` before
    /// its `id`.
    pub each: Option<String>,
    /// Quantity measured on each variant.
    pub quantity: MeasuredQuantity,
    /// Name of the `[[number]]` of the variants that `quantity = "number"` means.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// Wavelength of `transmittance` or `reflectance`, nm.
    pub wavelength_nm: Option<f64>,
    /// First and last wavelength of `transmittance` or `reflectance`, nm, combined according to
    /// `over`.
    pub range_nm: Option<[f64; 2]>,
    /// How the wavelengths of the range are combined.
    #[serde(default)]
    pub over: Over,
    /// Restricts the range to wavelengths that this variant absorbs well: those at which its
    /// transmittance is below the mean of its smallest and largest value in the range.
    #[schemars(with = "Option<Names>")]
    pub absorbed_by: Option<Where>,
    /// Compare the absolute value of the sum.
    #[serde(default)]
    pub absolute: bool,
    /// Variants whose quantity is added.
    #[schemars(with = "Vec<Names>")]
    pub plus: Vec<Where>,
    /// Variants whose quantity is subtracted; for `delta_e` the other colour.
    #[serde(default)]
    #[schemars(with = "Vec<Names>")]
    pub minus: Vec<Where>,
    /// Smallest value that confirms the conclusion.
    pub at_least: Option<f64>,
    /// Largest value that confirms the conclusion.
    pub at_most: Option<f64>,
    /// Variants of a curve. Instead of the sum itself, the place on the curve that has the same
    /// value is compared, such as the diameter of the spheres that act like an agglomerate.
    #[serde(default)]
    #[schemars(with = "Vec<Names>")]
    pub among: Vec<Where>,
    /// Abscissas of `among`, increasing, such as diameters in nm.
    #[serde(default)]
    pub along: Vec<f64>,
}

/// How the wavelengths of a range are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// The inequality holds at every wavelength.
    #[default]
    Every,
    /// The inequality holds at one wavelength or more.
    Some,
    /// The inequality holds for the mean.
    Mean,
}

/// The quantity that a conclusion compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Quantity")]
pub enum MeasuredQuantity {
    /// C* under natural light.
    Chroma,
    /// L* under natural light.
    Lightness,
    /// Hue angle under natural light, degrees.
    Hue,
    /// T of the layer without paper at the smallest angle.
    Transmittance,
    /// R of the layer without paper at the smallest angle.
    Reflectance,
    /// CIEDE2000 between one `plus` and one `minus`.
    DeltaE,
    /// Contrast ratio: Y over black divided by Y over white, lit at 45° and viewed along the
    /// normal, 0–1.
    ContrastRatio,
    /// CIEDE2000 between each variant and its own `colour.target_lab`.
    DeltaEToTarget,
    /// The weighted number that `number` names.
    Number,
}
