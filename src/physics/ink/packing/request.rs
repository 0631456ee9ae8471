//! The request for a packing: cell, pigments and method.

use crate::ink::{
    Agglomeration, Grain, Orientation, PackError, ReliefRequest, Shape, SizeDistribution, VoxelCut,
};
use crate::numerics::allowed::Allowed;
#[cfg(feature = "serde")]
use crate::numerics::files::name_or_table;
use crate::numerics::vector::V3;

/// Request for a packing; see [`pack`](crate::ink::pack()). Units are in the field names.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PackingRequest {
    /// Lateral periods (Lx, Ly), µm.
    pub period_um: [f64; 2],
    /// Thickness H, µm.
    pub thickness_um: f64,
    /// Grains of each pigment; the order numbers the pigments.
    pub pigments: Vec<PigmentGrains>,
    /// How to pack.
    pub method: MethodChoice,
    /// Hard walls at z = 0 and z = H; false makes the cell periodic in z too.
    pub walls: bool,
    /// Seed of all random draws: equal requests give equal packings.
    pub seed: u64,
    /// Number of the realisation: an independent stream of the same seed.
    pub stream: u64,
    /// Limits of random sequential addition.
    pub sequential: SequentialSettings,
    /// Settings of the relaxation of overlaps.
    pub relaxation: RelaxationSettings,
    /// Hard-body Monte Carlo after the packing, if requested.
    pub equilibration: Option<EquilibrationSettings>,
    /// A binder surface below the tops of the grains, if requested.
    pub relief: Option<ReliefRequest>,
    /// Grains in given places, one list per realisation ([`PackingRequest::stream`]); nothing is
    /// packed then.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub given: Vec<Vec<Grain>>,
    /// Labelled voxels instead, one cut per realisation.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub voxels: Vec<VoxelCut>,
    /// Heights between which the packing is the layer, µm: grains across them are cut.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub cut_um: Option<[f64; 2]>,
    /// Volume fraction of all grains by which [`MethodChoice::Auto`] chooses, if not this cell's
    /// own: cells of one layer that hold more or less than it are packed alike.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub usual_fraction: Option<f64>,
    /// The layers of a stack, in the order of the light, each with its own grains, places and
    /// random stream; empty for a single layer. The request itself then holds their cell, their
    /// whole thickness and the pigments of all, with volume fractions in their own layers.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Vec::is_empty"))]
    pub layers: Vec<StackedRequest>,
}

/// One layer of a stack to pack.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct StackedRequest {
    /// The layer as if it were alone, 0 ≤ z ≤ its thickness.
    pub request: PackingRequest,
    /// How it meets the next one.
    pub joint: Joint,
}

/// How a layer meets the one behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Joint {
    /// As at a wall: a dry layer has been coated, and no grain reaches across.
    #[default]
    Wall,
    /// Grains of both layers reach across, as wet on wet; both have one binder.
    Open,
}

impl Default for PackingRequest {
    fn default() -> Self {
        Self {
            period_um: [10.0, 10.0],
            thickness_um: 1.0,
            pigments: Vec::new(),
            method: MethodChoice::Auto,
            walls: true,
            seed: 1,
            stream: 0,
            sequential: SequentialSettings::default(),
            relaxation: RelaxationSettings::default(),
            equilibration: None,
            relief: None,
            given: Vec::new(),
            voxels: Vec::new(),
            cut_um: None,
            usual_fraction: None,
            layers: Vec::new(),
        }
    }
}

/// The grains of one pigment.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct PigmentGrains {
    /// Shape of the grains.
    #[cfg_attr(feature = "serde", serde(default, deserialize_with = "name_or_table"))]
    pub shape: Shape,
    /// Distribution of their sizes.
    pub size: SizeDistribution,
    /// Thicknesses of the layers around the core of every grain, from the core outwards, nm; they
    /// belong to the grain: its size and volume include them.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub shell_nm: Vec<f64>,
    /// Union volume of the grains over the volume of the layer (with relief: over the dry volume,
    /// see [`crate::ink::Relief`]).
    pub volume_fraction: f64,
    /// Alignment of their axes.
    #[cfg_attr(feature = "serde", serde(default, deserialize_with = "name_or_table"))]
    pub orientation: Orientation,
    /// Agglomeration of the grains, if any.
    #[cfg_attr(feature = "serde", serde(default))]
    pub agglomeration: Option<Agglomeration>,
    /// Rule by which a number of whole grains meets the volume fraction.
    ///
    /// Grains of one size: the nearest number. With a spread of sizes, the number is the requested
    /// volume over the mean grain volume of the distribution, its fractional part rounded at
    /// random, with one size drawn from each of as many equal fractions of the distribution. Over
    /// many cells, number, sizes and volume are unbiased, though a small cell may hold more or less
    /// (reported).
    #[cfg_attr(feature = "serde", serde(default))]
    pub share: ShareRule,
    /// Where along the depth the grains are: rows of depth over thickness, 0 to 1, and density,
    /// linear in between; evenly without any. Only ratios of densities matter.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub profile: Vec<[f64; 2]>,
    /// Optic axis in the frame of a grain, of any length above 0, if the pigment is birefringent.
    /// That of a convex body turns with it, that of a union of spheres about the union's axis at
    /// random; a sphere has no frame, and its axis is drawn as `orientation` aligns them.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub optic_axis: Option<V3>,
}

impl PigmentGrains {
    /// Spheres of one diameter.
    pub fn spheres(diameter_nm: f64, volume_fraction: f64) -> Self {
        Self::of(Shape::Sphere, diameter_nm, volume_fraction)
    }

    /// Grains of one shape and one effective diameter.
    pub fn of(shape: Shape, effective_diameter_nm: f64, volume_fraction: f64) -> Self {
        Self {
            shape,
            size: SizeDistribution::diameter_nm(effective_diameter_nm),
            shell_nm: Vec::new(),
            volume_fraction,
            orientation: Orientation::Random,
            agglomeration: None,
            share: ShareRule::NearestGrain,
            profile: Vec::new(),
            optic_axis: None,
        }
    }
}

/// Rule by which a number of whole grains meets a volume fraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ShareRule {
    /// The number of grains whose expected volume is nearest; the remainder is reported.
    #[default]
    NearestGrain,
    /// The nearest number, with all sizes multiplied by the factor that makes the fraction exact
    /// (also reported).
    ScaleSizes,
}

/// Choice of the packing method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MethodChoice {
    /// Sequential addition up to 0.22 of the accessible volume, relaxation above.
    #[default]
    Auto,
    /// Random sequential addition only (P1 section 3, the dilute case).
    SequentialAddition,
    /// Relaxation of overlaps only (P1 section 3, the dense case).
    Relaxation,
}

/// P1 section 3 calls < 30 % dilute for spheres; elongated grains jam earlier, hence the margin.
pub const AUTO_LIMIT: f64 = 0.22;

/// Limits of random sequential addition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SequentialSettings {
    /// Attempts for one grain before the packing counts as blocked.
    pub attempts_per_grain: u64,
}

impl Default for SequentialSettings {
    fn default() -> Self {
        Self { attempts_per_grain: 200_000 }
    }
}

/// Fraction of an overlap that a sphere moves per step.
const STEP: Allowed = Allowed::between(0.01, 1.0, "");
/// Largest displacement per step.
const STEP_LIMIT_RADII: Allowed = Allowed::between(0.001, 1.0, "");
/// Distance before contact at which forces act.
const INFLATION: Allowed = Allowed::between(1e-6, 0.05, "");
/// Number of batches of grains.
const BATCHES: Allowed = Allowed::between(1.0, 1000.0, "");
/// Number of relaxation steps.
const MAX_STEPS: Allowed = Allowed::between(1.0, 1e9, "");
/// Relative viscosity.
const VISCOSITY: Allowed = Allowed::between(0.1, 100.0, "");
/// Rotation per step.
const ALIGNING_DEG: Allowed = Allowed::between(0.0, 20.0, "°");

/// Relaxation of overlaps (P1 section 3), first-order dynamics μ v = F, J ω = M with Euler steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RelaxationSettings {
    /// Fraction of an overlap by which each of two free spheres moves in one step: time step ×
    /// stiffness / μ.
    #[cfg_attr(feature = "schema", schemars(transform = STEP.mark()))]
    pub step: f64,
    /// Largest displacement of a sphere in one step, in radii (P1: 0.2).
    #[cfg_attr(feature = "schema", schemars(transform = STEP_LIMIT_RADII.mark()))]
    pub step_limit_radii: f64,
    /// Relative distance before contact at which forces start to act.
    #[cfg_attr(feature = "schema", schemars(transform = INFLATION.mark()))]
    pub inflation: f64,
    /// Number of equal batches in which grains are added, each relaxed before the next.
    #[cfg_attr(feature = "schema", schemars(transform = BATCHES.mark()))]
    pub batches: usize,
    /// Largest number of steps before the relaxation is abandoned.
    #[cfg_attr(feature = "schema", schemars(transform = MAX_STEPS.mark()))]
    pub max_steps: u64,
    /// Viscosity of translation, μ, relative to the time scale of `step`.
    #[cfg_attr(feature = "schema", schemars(transform = VISCOSITY.mark()))]
    pub translational_viscosity: f64,
    /// Viscosity of rotation, J, relative to μ times the square of the grain's longest arm.
    #[cfg_attr(feature = "schema", schemars(transform = VISCOSITY.mark()))]
    pub rotational_viscosity: f64,
    /// Aligning torque at the start of a batch: degrees per step of a freely rotating grain at 45°
    /// to the field.
    #[cfg_attr(feature = "schema", schemars(transform = ALIGNING_DEG.mark()))]
    pub aligning_deg_per_step: f64,
    /// Steps over which the aligning torque ramps down to zero.
    pub aligning_steps: u64,
}

impl Default for RelaxationSettings {
    fn default() -> Self {
        Self {
            step: 0.5,
            step_limit_radii: 0.2,
            inflation: 0.005,
            batches: 1,
            max_steps: 20_000,
            translational_viscosity: 1.0,
            rotational_viscosity: 2.0,
            aligning_deg_per_step: 3.0,
            aligning_steps: 100,
        }
    }
}

/// Hard-body Monte Carlo after the packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EquilibrationSettings {
    /// One sweep tries one move per grain. Spheres at 30 % need about 200, at 50 % about 2500.
    #[cfg_attr(feature = "schema", schemars(example = 250))]
    pub sweeps: u64,
}

impl PackingRequest {
    /// Per pigment, thicknesses of the layers of its grains from the core outwards, µm.
    pub fn shells_um(&self) -> Vec<Vec<f64>> {
        self.pigments.iter().map(|p| p.shell_nm.iter().map(|t| 1e-3 * t).collect()).collect()
    }

    /// Whether grains are drawn, not given.
    pub fn is_drawn(&self) -> bool {
        self.given.is_empty() && self.voxels.is_empty()
    }

    /// Checks every number that can be checked before grains are drawn.
    pub fn check(&self) -> Result<(), PackError> {
        let lengths = [self.period_um[0], self.period_um[1], self.thickness_um];
        let sound = are_lengths(lengths);
        let found = format!("{lengths:?} µm");
        PackError::unless(sound, "period_um and thickness_um", found, "finite, above 0", "set the cell")?;
        self.pigments.iter().enumerate().try_for_each(|(k, pigment)| check_pigment(k, pigment))?;
        let total: f64 = self.pigments.iter().map(|p| p.volume_fraction).sum();
        let sound = total <= FCC || !self.voxels.is_empty();
        let allowed = "a sum of at most 0.74 (the densest packing of equal spheres)";
        PackError::unless(sound, "sum of volume_fraction", total, allowed, "lower the shares")?;
        if let Some(usual) = self.usual_fraction {
            let remedy = "give the volume fraction of the whole layer, or leave it out";
            PackError::unless((0.0..=FCC).contains(&usual), "usual_fraction", usual, "0 to 0.74", remedy)?;
        }
        self.relaxation.check()?;
        self.check_cut()?;
        self.relief.iter().try_for_each(|r| r.check(self.thickness_um, self.period_um, self.walls))
    }

    fn check_cut(&self) -> Result<(), PackError> {
        let Some([from, to]) = self.cut_um else { return Ok(()) };
        // heights of slabs are sums: rounding
        let sound = from >= 0.0 && from < to && to <= self.thickness_um * (1.0 + 1e-9);
        let found = format!("{from} to {to} µm");
        let allowed = format!("0 ≤ from < to ≤ {} µm", self.thickness_um);
        let remedy = "give two heights of the packing, the lower one first";
        PackError::unless(sound, "cut_um", found, allowed, remedy)?;
        let remedy = "leave one of them out";
        PackError::unless(self.relief.is_none(), "cut_um", "with a relief", "plane surfaces", remedy)
    }
}

/// Whether the sides of a cell are lengths.
pub(super) fn are_lengths(sides: [f64; 3]) -> bool {
    sides.iter().all(|l| l.is_finite() && *l > 0.0)
}

/// Volume fraction of the densest sphere packing, π/√18.
const FCC: f64 = 0.740_480_489_693_061;

fn check_pigment(k: usize, pigment: &PigmentGrains) -> Result<(), PackError> {
    let share = pigment.volume_fraction;
    let field = format!("pigment[{k}].volume_fraction");
    let remedy = "give a fraction of the layer's volume, not a percentage";
    PackError::unless((0.0..=1.0).contains(&share), field, share, "0 to 1", remedy)?;
    let fractal = pigment.agglomeration.as_ref().is_some_and(|rule| rule.fractal.is_some());
    let field = format!("pigment[{k}].agglomeration.fractal");
    let found = format!("`fractal` with the shape {}", pigment.shape.name());
    let allowed = "fractal agglomerates of grains made of spheres";
    let remedy = "leave `fractal` out, or take `sphere`, `cylinder` or `beaded_ellipsoid`";
    PackError::unless(!fractal || pigment.shape.form().is_none(), field, found, allowed, remedy)?;
    let agglomeration = pigment.agglomeration.as_ref().and_then(Agglomeration::defect);
    let defects = [
        pigment.shape.defect(),
        pigment.size.defect(),
        pigment.orientation.defect(),
        agglomeration,
        profile_defect(pigment),
    ];
    match defects.into_iter().flatten().next() {
        None => pigment.check_layers(k),
        Some((field, found, allowed)) => {
            Err(PackError::input(format!("pigment[{k}].{field}"), found, allowed, "correct this entry"))
        }
    }
}

/// What is wrong with the rows of a profile: field, value and what is allowed.
fn profile_defect(pigment: &PigmentGrains) -> Option<(&'static str, String, &'static str)> {
    let rows = &pigment.profile;
    let (first, last) = rows.first().zip(rows.last())?;
    let allowed = "rows [depth, share] from depth 0 to depth 1, in order, with shares from 0 to 0.64 that are not all 0";
    let is_sound =
        |[depth, share]: &[f64; 2]| (0.0..=1.0).contains(depth) && share.is_finite() && *share >= 0.0;
    let is_whole = rows.len() >= 2 && first[0] == 0.0 && last[0] == 1.0;
    let rises = rows.windows(2).all(|pair| pair[1][0] >= pair[0][0]);
    let good = is_whole && rises && rows.iter().all(is_sound) && rows.iter().any(|row| row[1] > 0.0);
    (!good).then(|| ("profile", format!("{rows:?}"), allowed))
}

impl RelaxationSettings {
    fn check(&self) -> Result<(), PackError> {
        let ranges = [
            ("relaxation.step", self.step, STEP),
            ("relaxation.step_limit_radii", self.step_limit_radii, STEP_LIMIT_RADII),
            ("relaxation.inflation", self.inflation, INFLATION),
            ("relaxation.batches", self.batches as f64, BATCHES),
            ("relaxation.max_steps", self.max_steps as f64, MAX_STEPS),
            ("relaxation.translational_viscosity", self.translational_viscosity, VISCOSITY),
            ("relaxation.rotational_viscosity", self.rotational_viscosity, VISCOSITY),
            ("relaxation.aligning_deg_per_step", self.aligning_deg_per_step, ALIGNING_DEG),
        ];
        ranges.into_iter().try_for_each(|(field, value, allowed)| {
            PackError::unless(allowed.holds(value), field, value, allowed, "leave it out for the default")
        })
    }
}
