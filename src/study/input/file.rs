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

mod calculation;
mod layer;
mod microstructure;
mod number;

pub use calculation::{AnglesTable, LightTable, SamplingName};
pub use calculation::{ResolutionTable, RunTable, SolverTable, TargetColour};
pub use layer::{
    BinderTable, ComposedTable, ContrastPart, LayerTable, PackingTable, PigmentTable, ShellTable,
};
pub use layer::{StackLayerTable, StackTable};
pub use microstructure::{
    Continuation, FileNames, LabelPigments, LengthUnit, MicrostructureTable, SizeColumn, VoxelEdges,
};

pub use number::{NumberTable, SeenLight, WeightsWritten};

use super::forms::{AlbedoWritten, CoverageWritten, FluorescenceWritten};
use super::limits;
use super::measured::{MeasuredCondition, MeasuredUnit, Patch};
use crate::appearance::bare_paper::PaperGeometry;
use crate::appearance::paper::MirroredSky;
use crate::appearance::viewing::{Summation, illuminants, observers};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The file of a folder of results that [`AreaTable::results`] is read from.
pub const RESULTS: &str = "results.json";

/// A whole study file. Missing tables take the defaults given for their fields.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Title of the report (default: name of the file).
    #[schemars(example = &"Yellow ink, 30 %")]
    pub title: Option<String>,
    /// The periodic cell and the media on both sides of it; or the layers of a stack, one
    /// `[[layer]]` each in the order of the light, with their own `[[layer.pigment]]`.
    #[serde(deserialize_with = "layer::one_or_stacked")]
    #[schemars(schema_with = "layer::one_or_stacked_schema")]
    pub layer: LayerTable,
    /// What the layers of `[[layer]]` share: the cell, and the media on both sides.
    pub stack: Option<StackTable>,
    /// The pigments, one `[[pigment]]` each; without any the layer consists of binder only.
    #[serde(default, rename = "pigment")]
    pub pigments: Vec<PigmentTable>,
    /// How the grains are placed.
    #[serde(default)]
    pub packing: PackingTable,
    /// The Lambertian substrate.
    #[serde(default)]
    pub paper: PaperTable,
    /// The screen of a halftone print; needs `[[area]]`.
    #[serde(default)]
    pub dots: DotsTable,
    /// Kinds of area of a halftone print, one `[[area]]` each; without any, only a solid is
    /// printed. What they leave is bare paper.
    #[serde(default, rename = "area")]
    pub areas: Vec<AreaTable>,
    /// Inks of a print in dots, one `[[ink]]` each; `[[area]]` says what bears each overprint.
    #[serde(default, rename = "ink", skip_serializing_if = "Vec::is_empty")]
    pub inks: Vec<InkTable>,
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
    /// Weighted numbers of the spectra, one `[[number]]` each; no solve depends on them.
    #[serde(default, rename = "number", skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<NumberTable>,
}

/// `[paper]`: the Lambertian substrate.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PaperTable {
    /// Albedo, 0–1: a number, a list `[[400, 0.82], [700, 0.91]]` (nm, linear in between), or `{
    /// csv = "paper.csv" }` with the columns wavelength_nm and albedo, or a measured spectrum. With
    /// a gap it is the reflectance of the bare paper; in optical contact it is that of the paper's
    /// inside, behind its surface, and not the factor measured on bare paper, which is lower: an
    /// inside of 0.9 and index 1.5 reflects about 0.80 of diffuse light. Default: 0.9.
    pub albedo: Option<AlbedoWritten>,
    /// The factor measured on the bare paper, instead of an albedo: the albedo follows from it
    /// through the paper's surface, by the geometry that the file states.
    pub measured: Option<MeasuredPaperTable>,
    /// A brightener in the paper: light must reach down to the wavelengths that excite it.
    pub fluorescence: Option<FluorescenceWritten>,
    /// Contact between ink and paper.
    pub coupling: CouplingName,
}

/// `[paper.measured]`: the bare paper as an instrument reads it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredPaperTable {
    /// A measured spectrum in any format of `compare.measured`, relative to the study file.
    #[schemars(example = &"paper.csv")]
    pub csv: String,
    /// Sample in a file with several: its name, or its amounts of ink.
    pub patch: Option<Patch>,
    /// Value of a perfect white, where the file does not state it.
    pub unit: Option<MeasuredUnit>,
    /// The instrument's light, where the sample was measured under several.
    pub condition: Option<MeasuredCondition>,
    /// Directions of light and view, where the file does not state them (then 45:0): `"45:0"`,
    /// `"d:8"` with and `"d:8 excluded"` without mirrored light, `"d:0"` or `"natural"`.
    pub geometry: Option<PaperGeometry>,
}

/// `[dots]`: the screen of a halftone print.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DotsTable {
    /// Ruling of the screen, dots per cm; 60 is usual (150 lpi).
    #[schemars(transform = limits::RULING_PER_CM.mark())]
    pub ruling_per_cm: Option<f64>,
    /// Length ℓ over which the paper spreads light, µm: the light that enters at one place leaves
    /// around it as exp(−r/ℓ)/(2πℓ²). 0 spreads none (Neugebauer); coated papers have 20 to 60.
    #[schemars(transform = limits::SPREAD_UM.mark())]
    pub spread_um: Option<f64>,
    /// Physical gain of a nominal coverage of a half: 4 g c (1 − c) is added to every coverage.
    /// Default: 0.
    #[schemars(transform = limits::DOT_GAIN.mark())]
    pub physical_gain: f64,
    /// Which prints the coverages of `[[ink]]` make: one for each entry of their lists (default),
    /// or every combination of their entries, such as 27 of three inks with three coverages each.
    pub patches: PatchRule,
}

/// Which prints the coverages of several inks make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PatchRule {
    /// One print for each entry of the lists.
    #[default]
    Each,
    /// Every combination of their entries; the first ink varies fastest.
    Grid,
}

/// `[[ink]]`: an ink of a print in dots, whose overprints with the others share the area as
/// independent dots do (Demichel).
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InkTable {
    /// Name, by which areas say what they bear.
    #[schemars(example = &"cyan")]
    pub name: String,
    /// Nominal coverage, 0 to 1, or a list with one for each print.
    pub coverage: CoverageWritten,
}

/// `[[area]]`: a kind of area of a halftone print.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaTable {
    /// Share of the area, 0 to 1; or a list for a ramp of tints. Needed without `inks`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<CoverageWritten>,
    /// Names of the `[[ink]]`s that overlap in this area, instead of `coverage`. Every overprint
    /// needs its area; what bears no ink is bare paper.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(example = ("cyan", "yellow"))]
    pub inks: Vec<String>,
    /// What it bears. Default: `"layer"`.
    #[serde(default)]
    pub bears: AreaBears,
    /// Folder of results of another study, relative to this file: the area bears the layer of that
    /// study, on this study's paper; of a composed one its first thickness. Its `index_out` and
    /// range of wavelengths must be those here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = &"out/cyan")]
    pub results: Option<String>,
}

/// What a kind of area bears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AreaBears {
    /// This study's layer.
    #[default]
    Layer,
    /// Bare paper.
    Paper,
}

/// Contact between layer and paper; see [`crate::appearance::paper::Coupling`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CouplingName {
    /// The model of the source paper (P1 section 5): a thin air gap, across which light is
    /// exchanged incoherently.
    #[default]
    Gap,
    /// The paper's scatterers are embedded in a medium of `layer.index_out` that touches the layer.
    OpticalContact,
}

/// `[colour]`: conditions of the numbers for ink makers; everything else uses D65 and the 2°
/// observer.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ColourTable {
    /// Illuminant (default: `"D65"`), such as `"D50"`, `"A"`, `"F11"`, `"LED_B3"`.
    #[schemars(schema_with = "illuminants", example = &"D65")]
    pub illuminant: Option<String>,
    /// Observer (default: `"2"`): `"10"`, `"2015_2"` or `"2015_10"`.
    #[schemars(schema_with = "observers", example = &"2")]
    pub observer: Option<String>,
    /// Summation: `"plain"` (default), or `"e308"` for the weights of ASTM E308.
    pub summation: Summation,
    /// Target L*, a*, b* of the print under these conditions, at 45:0: L* from 0 to 150, a* and b*
    /// from -300 to 300.
    #[schemars(transform = limits::Entries(limits::CHROMA), example = (85, -10, 80))]
    pub target_lab: Option<[f64; 3]>,
}

/// `[compare]`: what the prediction is compared with.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompareTable {
    /// A spectrum measured at 45:0, relative to the study file: CGATS.17 and its relatives, CxF3,
    /// or a table of an instrument or a spreadsheet, recognised by their structure. Tables have
    /// wavelengths in nm down the first column and a column a sample, or a row a sample and
    /// wavelengths as columns; commas, semicolons, tabs or blanks between cells; a header or
    /// none. A sample with Lab but no spectrum is a target, if the file states the illuminant and
    /// the observer of `[colour]`. Unit, geometry and light are those that the file declares;
    /// transmittances and other geometries (d:8 of a sphere) are refused.
    #[schemars(example = &"measured.csv")]
    pub measured: Option<String>,
    /// Sample in a file with several (default: the first): its name or number, or its amounts of
    /// ink in percent, such as `[0, 0, 100, 0]` for C, M, Y, K.
    #[schemars(example = &"yellow 100 %")]
    pub patch: Option<Patch>,
    /// Value of a perfect white in the file: 1 (`"factor"`) or 100 (`"percent"`). By default what
    /// the file declares (`SPECTRAL_NORM`, `%R`); where it declares nothing, the file holds
    /// percentages if any value of any sample is above 3, factors if none is above 1, and in
    /// between the unit is required.
    #[schemars(example = &"percent")]
    pub unit: Option<MeasuredUnit>,
    /// The instrument's light by ISO 13655, where the sample was measured under several.
    #[schemars(example = &"M1")]
    pub condition: Option<MeasuredCondition>,
}

/// `[output]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputTable {
    /// Folder of the results, relative to the working directory (default: `out/<study name>`).
    #[schemars(example = &"out/yellow")]
    pub folder: Option<String>,
    /// Side of the picture's square, pixels.
    #[schemars(transform = limits::PICTURE_PIXELS.mark())]
    pub picture_pixels: usize,
    /// Whether the picture's strip includes the sky reflected by the layer.
    pub mirrored_sky: MirroredSky,
}

impl Default for OutputTable {
    fn default() -> Self {
        Self { folder: None, picture_pixels: 360, mirrored_sky: MirroredSky::default() }
    }
}
