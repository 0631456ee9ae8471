//! The layer: the cell, its pigments, and their packing; which part of the contrast scatters, for
//! studies in which the real or imaginary part of η² is replaced by its mean.

mod stack;

pub use stack::{StackLayerTable, StackTable};
pub(super) use stack::{one_or_stacked, one_or_stacked_schema};

use super::microstructure::MicrostructureTable;
use crate::ink::{
    Agglomeration, EquilibrationSettings, MethodChoice, Orientation, RelaxationSettings, ReliefRequest,
    SequentialSettings, Shape, ShareRule, SizeDistribution,
};
use crate::input::forms::{
    Diameter, IndexForms, IndexWritten, Pair, PigmentIndexForms, ThicknessWritten, index,
};
use crate::input::{limits, variation};
use crate::material::mixing::{MixingRule, molecular_mixture};
use crate::numerics::files::name_or_table;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[layer]`: the periodic cell and the media on both sides of it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerTable {
    /// Whether every realisation has a cell of its own size, shape and azimuth.
    #[serde(default)]
    pub cell: variation::CellRule,
    /// Nominal period along x and y, µm: one number or `[x, y]`. For varied cells it follows from
    /// the grains by default.
    #[schemars(example = 1.6)]
    pub period_um: Option<Pair>,
    /// Thickness, µm; `{ mean, std }` if it varies; a list for a composed layer.
    #[schemars(example = 1.0)]
    pub thickness_um: ThicknessWritten,
    /// The medium between the grains (default: index 1.558, P1 section 5).
    #[serde(default)]
    pub binder: BinderTable,
    /// Hard walls at both faces; without them grains are periodic along z as well, for packings
    /// only.
    #[serde(default = "yes")]
    pub walls: bool,
    /// Refractive index of the half-space on the incident side.
    #[serde(default = "vacuum")]
    #[schemars(transform = limits::INDEX.mark())]
    pub index_in: f64,
    /// Refractive index of the half-space on the exit side; 1 for the thin air gap to the paper.
    #[serde(default = "vacuum")]
    #[schemars(transform = limits::INDEX.mark())]
    pub index_out: f64,
    /// How `"molecular"` pigments mix with the binder (default: the limit of vanishing grains,
    /// which is `"volume-average"` for the scalar wave and `"maxwell-garnett"` for Maxwell's
    /// equations).
    #[schemars(example = &"volume-average")]
    pub mixing: Option<MixingRule>,
    /// Which part of the contrast in η² scatters: all of it, or only its real or imaginary part.
    #[serde(default)]
    pub contrast: ContrastPart,
    /// Composes the layer of slabs that are solved: for layers of many µm.
    #[schemars(example = ComposedTable::default())]
    pub composed: Option<ComposedTable>,
    /// Grains in given places instead of packed ones; pigments then have no shares and sizes.
    #[schemars(example = MicrostructureTable::example())]
    pub microstructure: Option<MicrostructureTable>,
    /// A rough face of the ink, with the medium of that side (`index_in`, `index_out`) between the
    /// grains.
    pub relief: Option<ReliefRequest>,
    /// The layers of `[[layer]]`, in the order of the light; `None` for a single `[layer]`.
    #[serde(skip)]
    pub stacked: Option<Vec<StackLayerTable>>,
}

impl LayerTable {
    /// One layer of a stack as if it were alone, with what `[stack]` says of all.
    pub(in crate::input) fn of_stack(layer: &StackLayerTable, stack: &StackTable) -> Self {
        Self {
            cell: stack.cell,
            period_um: stack.period_um,
            thickness_um: layer.thickness_um.clone(),
            binder: layer.binder.clone(),
            walls: true,
            index_in: stack.index_in,
            index_out: stack.index_out,
            mixing: stack.mixing,
            contrast: stack.contrast,
            composed: None,
            microstructure: layer.microstructure.clone(),
            relief: layer.relief,
            stacked: None,
        }
    }
}

/// `[layer.composed]`: the layer as a stack of slabs. The outer ones are solved with the surfaces,
/// the inner ones in a medium of the layer's index, and all again at half the thickness.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ComposedTable {
    /// About the thickness of a slab, µm; the first thickness is a whole number of slabs.
    #[schemars(transform = limits::THICKNESS_UM.mark())]
    pub slab_um: f64,
    /// Directions in which light is followed: in the cone from which it reaches air, and beyond
    /// (default: `[3, 3]` in a layer; `[3, 6]` in a stack whose cells are 1.5 times as wide as the
    /// longest wave or wider).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = limits::Entries(limits::ZONE_DIRECTIONS), example = [3, 3])]
    pub directions: Option<[usize; 2]>,
    /// Of a stack: every layer is solved between half-spaces of this index, that of most binders,
    /// so that its plates join those of any other layer in any order (`inkwave library`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = limits::JOINT_INDEX.mark(), example = 1.5)]
    pub joint_index: Option<f64>,
}

impl ComposedTable {
    /// Directions in a layer of slabs in the medium of their mean index.
    pub const OF_A_LAYER: [usize; 2] = [3, 3];
    /// Directions in a stack. Between its faces light that cannot leave has fringes in each thin
    /// layer, which few directions miss.
    // *Measured* on an ink over 1 µm of a white of n = 2.4: with 3, 4, 5, 6 and 9 directions beyond
    // the cone plates absorb .391, .410, .400, .405 and .403, both solved at once .407 ± .006.
    pub const OF_A_STACK: [usize; 2] = [3, 6];
    /// Least width of cells, over the longest wave, whose orders six directions can tell apart: in
    /// narrower ones half as many have less noise.
    // *Measured* on an ink over a white in cells of 1.5 and 1.8 waves, six studies of four packings
    // and six of sixteen each: either number of directions scatters as much, R at 0° by .065 and
    // .062 with four, by .0233 and .0238 with sixteen, in cells of 1.5 waves.
    const WIDE: f64 = 1.5;

    /// The directions of a stack: those asked for, or what suits cells of this width.
    pub fn in_a_stack(&self, width_um: f64, longest_um: f64) -> [usize; 2] {
        let is_wide = width_um >= Self::WIDE * longest_um;
        self.directions.unwrap_or(if is_wide { Self::OF_A_STACK } else { Self::OF_A_LAYER })
    }
}

impl Default for ComposedTable {
    fn default() -> Self {
        Self { slab_um: 2.0, directions: None, joint_index: None }
    }
}

pub(super) fn vacuum() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

/// `[layer.binder]`
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinderTable {
    /// Refractive index of the binder.
    #[serde(deserialize_with = "index")]
    #[schemars(with = "IndexForms", example = 1.558)]
    pub index: IndexWritten,
}

impl Default for BinderTable {
    fn default() -> Self {
        Self { index: IndexWritten { n: Some(1.558), ..IndexWritten::default() } }
    }
}

/// `[[pigment]]`: one kind of grain.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PigmentTable {
    /// Name in reports (default: "pigment 1" and so on).
    #[schemars(example = &"yellow")]
    pub name: Option<String>,
    /// Shape of the grains.
    #[serde(deserialize_with = "name_or_table")]
    pub shape: Shape,
    /// Layers around the core, from the core outwards; `index` is that of the core (1 for hollow
    /// grains). Sizes and the volume fraction are those of the whole grain with its layers. A layer
    /// moves every face of a convex body outwards by its thickness, and lengthens every semi-axis
    /// of an ellipsoid by it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 20))]
    pub shell: Vec<ShellTable>,
    /// Effective diameter of all grains (sphere of equal volume), nm; or use `size`. `"molecular"`
    /// is the limit of vanishing grains: nothing is packed, the pigment is dissolved in the binder.
    #[schemars(example = 250)]
    pub diameter_nm: Option<Diameter>,
    /// Size distribution.
    #[schemars(example = SizeDistribution::diameter_nm(250.0))]
    pub size: Option<SizeDistribution>,
    /// Fraction of the layer's volume, 0–1. Needed unless `layer.microstructure` places the grains.
    #[schemars(transform = limits::VOLUME_FRACTION.mark(), example = 0.3)]
    pub volume_fraction: Option<f64>,
    /// Refractive index; not needed for packings only.
    #[serde(deserialize_with = "index")]
    #[schemars(with = "PigmentIndexForms", example = std::collections::BTreeMap::from_iter(Some(("built_in", "yellow"))))]
    pub index: IndexWritten,
    /// Optic axis of birefringent grains as `[x, y, z]`, of any length above 0, in the frame of the
    /// grain: z is the axis that `orientation` aligns. That of a convex body turns with it, that of
    /// a union of spheres about the union's axis at random; spheres have no frame, and their axes
    /// are drawn as `orientation` says (default: `[0, 0, 1]`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(example = (0.0, 0.0, 1.0))]
    pub optic_axis: Option<[f64; 3]>,
    /// Alignment of the grains' axes.
    #[serde(deserialize_with = "name_or_table")]
    pub orientation: Orientation,
    /// Which grains stick together; by default none.
    pub agglomeration: Option<Agglomeration>,
    /// How whole grains reach the volume fraction.
    pub share: ShareRule,
    /// Share of the layer's volume against depth, instead of `volume_fraction`: rows `[depth,
    /// share]` with depths from 0 at the lit face to 1 at the other, linear in between. Grains keep
    /// away from walls as without it; reports give the shares reached in the thirds of the depth.
    #[schemars(example = ((0.0, 0.2), (1.0, 0.4)))]
    pub profile: Option<Vec<[f64; 2]>>,
}

/// One layer around the core of a grain, of the same thickness all around.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShellTable {
    /// Thickness, nm.
    #[schemars(transform = limits::ABOVE_ZERO.mark(), example = 20)]
    pub thickness_nm: f64,
    /// Refractive index; not needed for packings only.
    #[serde(default, deserialize_with = "index")]
    #[schemars(with = "IndexForms", example = 1.46)]
    pub index: IndexWritten,
}

/// `[packing]`: how the grains are placed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PackingTable {
    /// Packing method.
    pub method: MethodChoice,
    /// Limits of random sequential addition.
    pub sequential: SequentialSettings,
    /// Settings of the relaxation of overlaps.
    pub relaxation: RelaxationSettings,
    /// Monte Carlo moves after the packing; by default none.
    #[schemars(example = EquilibrationSettings { sweeps: 250 })]
    pub equilibration: Option<EquilibrationSettings>,
}

/// The part of the contrast in η² that is kept. The other part is replaced by its mean over the
/// layer, so that the mean medium is the same in all three (P1 conclusion 4 asks which fluctuations
/// make large grains pale).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContrastPart {
    /// The materials are unchanged.
    #[default]
    Full,
    /// Only Re η² varies; Im η² is the same everywhere.
    Real,
    /// Only Im η² varies; Re η² is the same everywhere.
    Imaginary,
}

impl ContrastPart {
    /// True if nothing is replaced.
    pub fn is_full(&self) -> bool {
        *self == ContrastPart::Full
    }

    /// Indices of binder and pigments with the part that is kept; `shares` are the pigments' volume
    /// fractions.
    pub fn of(self, binder: Complex64, shares: &[f64], grains: &[Complex64]) -> (Complex64, Vec<Complex64>) {
        let all: Vec<_> = shares.iter().copied().zip(grains.iter().copied()).collect();
        let mean = molecular_mixture(binder, &all).powi(2);
        let keep = |eta: Complex64| match self {
            ContrastPart::Full => eta,
            ContrastPart::Real => Complex64::new((eta * eta).re, mean.im).sqrt(),
            ContrastPart::Imaginary => Complex64::new(mean.re, (eta * eta).im).sqrt(),
        };
        (keep(binder), grains.iter().copied().map(keep).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_stays_and_one_part_differs() {
        let binder = Complex64::new(1.558, 0.0);
        let pigment = Complex64::new(1.8, 0.2);
        let mean = molecular_mixture(binder, &[(0.3, pigment)]);
        for part in [ContrastPart::Full, ContrastPart::Real, ContrastPart::Imaginary] {
            let (b, p) = part.of(binder, &[0.3], &[pigment]);
            let difference = p[0] * p[0] - b * b;
            assert!((molecular_mixture(b, &[(0.3, p[0])]) - mean).norm() < 1e-14);
            assert_eq!(difference.im.abs() < 1e-14, part == ContrastPart::Real);
            assert_eq!(difference.re.abs() < 1e-14, part == ContrastPart::Imaginary);
        }
    }
}
