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

use super::contrast::ContrastPart;
use super::forms::{AlbedoWritten, Diameter, IndexWritten, Pair, Strategy, ThicknessWritten};
use super::limits;
use super::variation::CellRule;
use crate::appearance::paper::MirroredSky;
use crate::appearance::viewing::{Summation, illuminants, observers};
use crate::ink::{
    Agglomeration, EquilibrationSettings, MethodChoice, Orientation, RelaxationSettings, ReliefRequest,
    SequentialSettings, Shape, ShareRule, SizeDistribution,
};
use crate::material::mixing::MixingRule;
use crate::numerics::written::{Alias, older_place, usual, without_default};
use crate::solve::Goal;
use crate::solve::door::Wave;
use crate::wave::Scheme;
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
    /// Older place of `run.seed`.
    #[schemars(transform = older_place, example = 1)]
    pub seed: Option<u64>,
    /// Older place of `run.realisations`.
    #[schemars(transform = older_place, example = 24)]
    pub realisations: Option<usize>,
}

impl StudyFile {
    /// The same file with every key in today's place.
    pub(super) fn in_todays_places(&self) -> StudyFile {
        let mut file = self.clone();
        let (layer, packing) = (&mut file.layer, &mut file.packing);
        file.run.seed = file.seed.take().unwrap_or(file.run.seed);
        file.run.realisations = file.realisations.take().or(file.run.realisations);
        packing.method = layer.method.take().unwrap_or(packing.method);
        packing.sequential = layer.sequential.take().unwrap_or(packing.sequential);
        packing.relaxation = layer.relaxation.take().unwrap_or(packing.relaxation);
        packing.equilibration = layer.equilibration.take().or(packing.equilibration);
        for (k, pigment) in file.pigments.iter_mut().enumerate() {
            if pigment.name.is_none() {
                pigment.name = Some(format!("pigment {}", k + 1));
            }
        }
        file
    }
}

/// `[layer]`: the periodic cell and what lies above and below it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = Alias::new("index_above", "index_in"), transform = Alias::new("index_below", "index_out"))]
pub struct LayerTable {
    /// Whether every realisation has a cell of its own; see [`super::variation`].
    #[serde(default)]
    pub cell: CellRule,
    /// Nominal period in x and y, µm: one number or `[x, y]`. Follows from the grains when left out and cells vary.
    #[schemars(example = 1.6)]
    pub period_um: Option<Pair>,
    /// Thickness, µm; `{ mean, std }` where it is uneven.
    #[schemars(example = 1.0)]
    pub thickness_um: ThicknessWritten,
    /// The medium between the grains; index 1.558 (P1 section 5) when left out.
    #[serde(default)]
    #[schemars(transform = usual)]
    pub binder: BinderTable,
    /// Hard walls at both faces; without them grains wrap around in z as well, for packings alone.
    #[serde(default = "yes")]
    pub walls: bool,
    /// Refractive index of the half-space the light comes from.
    #[serde(default = "vacuum", alias = "index_in")]
    #[schemars(transform = limits::INDEX.mark())]
    pub index_above: f64,
    /// Refractive index of the half-space behind the layer; 1 for the thin air gap to the paper.
    #[serde(default = "vacuum", alias = "index_out")]
    #[schemars(transform = limits::INDEX.mark())]
    pub index_below: f64,
    /// How `"molecular"` pigments mix with the binder: `"volume-average"` for the scalar wave and `"maxwell-garnett"` for
    /// Maxwell's equations when left out, the limits of vanishing grains of either.
    #[schemars(example = &"volume-average")]
    pub mixing: Option<MixingRule>,
    /// Which part of the contrast in η² scatters: all of it, or its real or imaginary part alone.
    #[serde(default)]
    pub contrast: ContrastPart,
    /// A binder surface below the tops of the grains, with `index_above` between them.
    pub relief: Option<ReliefRequest>,
    /// Older place of `packing.method`.
    #[schemars(transform = older_place, example = &"auto")]
    pub method: Option<MethodChoice>,
    /// Older place of `packing.sequential`.
    #[schemars(transform = older_place, example = SequentialSettings::default())]
    pub sequential: Option<SequentialSettings>,
    /// Older place of `packing.relaxation`.
    #[schemars(transform = older_place, example = RelaxationSettings::default())]
    pub relaxation: Option<RelaxationSettings>,
    /// Older place of `packing.equilibration`.
    #[schemars(transform = older_place, example = EquilibrationSettings { sweeps: 250 })]
    pub equilibration: Option<EquilibrationSettings>,
}

/// `[layer.binder]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinderTable {
    /// Its refractive index.
    #[schemars(example = 1.558)]
    pub index: IndexWritten,
}

impl Default for BinderTable {
    fn default() -> Self {
        Self { index: IndexWritten { n: Some(1.558), ..IndexWritten::default() } }
    }
}

/// `[[pigment]]`: one kind of grain.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PigmentTable {
    /// What reports call it; "pigment 1" and so on when left out.
    #[schemars(example = &"yellow")]
    pub name: Option<String>,
    /// Shape of its grains.
    #[serde(default)]
    pub shape: Shape,
    /// Effective diameter of all grains (sphere of equal volume), nm; or `size` instead. `"molecular"` is the
    /// limit of vanishing grains: nothing is packed, the pigment is dissolved in the binder.
    #[schemars(transform = usual, example = 250)]
    pub diameter_nm: Option<Diameter>,
    /// Size distribution.
    #[schemars(example = SizeDistribution::diameter_nm(250.0))]
    pub size: Option<SizeDistribution>,
    /// Share of the layer's volume, 0–1.
    #[schemars(transform = limits::VOLUME_FRACTION.mark(), example = 0.3)]
    pub volume_fraction: f64,
    /// Refractive index; packings alone do without.
    #[serde(default)]
    #[schemars(transform = without_default, transform = usual, example = std::collections::BTreeMap::from([("built_in", "yellow")]))]
    pub index: IndexWritten,
    /// Alignment of the grains' axes.
    #[serde(default)]
    pub orientation: Orientation,
    /// Which grains stick together, if any.
    pub agglomeration: Option<Agglomeration>,
    /// How whole grains meet the volume fraction.
    #[serde(default)]
    pub share: ShareRule,
}

/// `[paper]`: the Lambertian substrate.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PaperTable {
    /// 0–1: a number, a list `[[400, 0.82], [700, 0.91]]` (nm, linear in between), or `{ csv = "paper.csv" }` with the
    /// columns wavelength_nm and albedo.
    pub albedo: AlbedoWritten,
    /// What is between ink and paper.
    pub coupling: CouplingName,
}

impl Default for PaperTable {
    fn default() -> Self {
        Self { albedo: AlbedoWritten::Constant(0.9), coupling: CouplingName::Gap }
    }
}

/// How layer and paper touch; see [`crate::appearance::paper::Coupling`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CouplingName {
    /// The paper's model (P1 section 5): a thin air gap, light goes back and forth incoherently.
    #[default]
    Gap,
    /// The paper's scatterers sit in a medium of `layer.index_below` that touches the layer.
    OpticalContact,
}

/// `[light]`: vacuum wavelengths in nm, as a list or as a range.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LightTable {
    /// Which equation is solved, and for which light.
    #[serde(default)]
    pub wave: Wave,
    /// The list.
    #[schemars(transform = limits::WAVELENGTHS_NM.mark(), example = [450, 550, 650])]
    pub wavelengths_nm: Option<Vec<f64>>,
    /// First of the range, nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 400)]
    pub from_nm: Option<f64>,
    /// Last of the range, nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 700)]
    pub to_nm: Option<f64>,
    /// Step of the range, nm.
    #[schemars(transform = limits::STEP_NM.mark(), example = 20)]
    pub step_nm: Option<f64>,
    /// Wavelengths that each realisation is solved at, where a range is given: shifted between the realisations. One for each step when
    /// nothing is said.
    #[schemars(transform = limits::PER_REALISATION.mark(), example = 15)]
    pub per_realisation: Option<usize>,
    /// Solve a range's own wavelengths in every realisation instead of shifted ones.
    #[serde(default)]
    pub sampling: SamplingName,
}

/// Which wavelengths of a range are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SamplingName {
    /// Every realisation has its own shift of the uniform grid; spectra and colours are unbiased.
    #[default]
    Shifted,
    /// The wavelengths written, in every realisation.
    Listed,
}

/// `[angles]`: 0°, 45° and directions over the hemisphere (`count` in all), which paper and picture need, or a list.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnglesTable {
    /// Directions of light for each wavelength (5 when nothing is said): 0°, 45°, and the rest stratified over the hemisphere, shifted
    /// from realisation to realisation.
    #[schemars(transform = limits::DIRECTIONS.mark(), example = 5)]
    pub count: Option<usize>,
    /// Any angles from the normal instead. Where 0° and 45° are among them the hemisphere is solved as well, and paper, colour and
    /// picture are there; otherwise spectra and distributions alone.
    #[schemars(transform = limits::POLARS_DEG.mark(), example = [0, 30, 45, 60])]
    pub polar_deg: Option<Vec<f64>>,
    /// Largest angle of the picture's axes (P1: 60°).
    #[serde(default = "sixty")]
    #[schemars(transform = limits::PICTURE_MAX_DEG.mark())]
    pub picture_max_deg: f64,
    /// Azimuth of the plane of incidence, degrees from x.
    #[serde(default)]
    #[schemars(transform = limits::AZIMUTH_DEG.mark())]
    pub azimuth_deg: f64,
}

impl Default for AnglesTable {
    fn default() -> Self {
        Self { count: None, polar_deg: None, picture_max_deg: sixty(), azimuth_deg: 0.0 }
    }
}

fn sixty() -> f64 {
    60.0
}

/// `[run]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RunTable {
    /// Number of independent packings to average over: 24 small varied cells, or 4 fixed ones, when nothing is said.
    #[schemars(transform = limits::REALISATIONS.mark(), example = 24)]
    pub realisations: Option<usize>,
    /// Ends the run as soon as the 95 % interval of every colour is as narrow as this (ΔE₀₀); `realisations`, 400 then when nothing is said,
    /// are the most. In a sweep every variant ends with its own bar; processes that share a folder can do so, shards cannot.
    #[schemars(transform = limits::TARGET_DELTA_E.mark(), example = 0.5)]
    pub target_delta_e: Option<f64>,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for RunTable {
    fn default() -> Self {
        Self { realisations: None, target_delta_e: None, seed: 1 }
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
    /// The discretisation in z of the scalar wave; Maxwell's equations have two moments a cell whatever it says.
    #[serde(default)]
    pub scheme: Scheme,
}

/// `[solver]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverTable {
    /// `"krylov"`, or with settings `{ krylov = { restart = 60 } }`.
    #[schemars(extend("default" = "krylov"))]
    pub strategy: Strategy,
    /// Relative residual at which a solve counts as converged; a hundredth of `resolution.accuracy` when left out, 1e-6
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
        Self { strategy: Strategy::default(), tolerance: None, max_applications }
    }
}

/// `[packing]`: how the grains come to their places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PackingTable {
    /// How to pack.
    pub method: MethodChoice,
    /// Limits of random sequential addition.
    pub sequential: SequentialSettings,
    /// Settings of the relaxation of overlaps.
    pub relaxation: RelaxationSettings,
    /// Monte Carlo after the packing, if asked.
    #[schemars(example = EquilibrationSettings { sweeps: 250 })]
    pub equilibration: Option<EquilibrationSettings>,
}

/// `[colour]`: the conditions of an ink maker's numbers, beside D65 and the 2° observer of everything else.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ColourTable {
    /// `"D65"` when left out; `"D50"`, `"A"`, `"F11"`, `"LED_B3"` …
    #[schemars(schema_with = "illuminants", example = &"D65")]
    pub illuminant: Option<String>,
    /// `"2"` when left out; `"10"`, `"2015_2"`, `"2015_10"`.
    #[schemars(schema_with = "observers", example = &"2")]
    pub observer: Option<String>,
    /// `"plain"` when left out, or `"e308"` for the weights of ASTM E308.
    pub summation: Summation,
    /// L*, a*, b* that the print should have under these conditions, at 45:0.
    #[schemars(inner(range(min = -300, max = 300)), example = [85, -10, 80])]
    pub target_lab: Option<[f64; 3]>,
}

/// `[compare]`: what the prediction is held against.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompareTable {
    /// A spectrum measured at 45:0, relative to the study file: CSV, CxF3 or CGATS.17.
    #[schemars(example = &"measured.csv")]
    pub measured: Option<String>,
}

/// `[output]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputTable {
    /// Folder for the results, relative to where the program runs; `out/<study name>` when left out.
    #[schemars(example = &"out/yellow")]
    pub folder: Option<String>,
    /// Side of the picture's square, pixels.
    #[schemars(transform = limits::PICTURE_PIXELS.mark())]
    pub picture_pixels: usize,
    /// Whether the picture's strip shows the sky that the layer mirrors.
    pub mirrored_sky: MirroredSky,
}

impl Default for OutputTable {
    fn default() -> Self {
        Self { folder: None, picture_pixels: 360, mirrored_sky: MirroredSky::default() }
    }
}

fn vacuum() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}
