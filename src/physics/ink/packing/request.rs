//! The request for a packing: cell, pigments and method.

mod methods;
mod pigment;

pub use methods::{AUTO_LIMIT, EquilibrationSettings, MethodChoice, RelaxationSettings, SequentialSettings};
pub use pigment::{PigmentGrains, ShareRule};

use crate::ink::{Grain, PackError, ReliefRequest, VoxelCut};
use pigment::check_pigment;

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
    /// Volume fraction of all grains, at the depth where they are densest, by which
    /// [`MethodChoice::Auto`] chooses, if not this cell's own: cells of one layer that hold more or
    /// less than it are packed alike.
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
        let attempts = self.sequential.attempts_per_grain;
        let field = "sequential.attempts_per_grain";
        PackError::unless(attempts > 0, field, attempts, "1 or more", "leave it out: 200000 is usual")?;
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
pub(super) const FCC: f64 = 0.740_480_489_693_061;
