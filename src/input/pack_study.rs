//! The part of a study file that describes the layer: `[layer]`, `[[pigment]]`, seed, realisations.

use crate::ink::error::PackError;
use crate::ink::grains::agglomeration::Agglomeration;
use crate::ink::grains::orientation::Orientation;
use crate::ink::grains::shape::Shape;
use crate::ink::grains::size::SizeDistribution;
use crate::ink::packing::request::{
    EquilibrationSettings, MethodChoice, PackingRequest, PigmentGrains, RelaxationSettings,
    SequentialSettings, ShareRule,
};
use crate::ink::relief::ReliefRequest;
use serde::Deserialize;
use toml::Value;

/// A study file as `inkwave pack` reads it. Sections for the later stages may be present and are left alone.
///
/// ```
/// let text = r#"
/// seed = 7
/// [layer]
/// period_um = [4.0, 4.0]
/// thickness_um = 1.0
/// [[pigment]]
/// name = "yellow"
/// shape = "cylinder"
/// size = { kind = "constant", value_nm = 200.0 }
/// volume_fraction = 0.2
/// orientation = "in_plane"
/// "#;
/// let study: super::PackStudy = toml::from_str(text)?;
/// assert_eq!(study.request(3).stream, 3);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackStudy {
    /// Title, for people.
    #[serde(default)]
    pub title: Option<String>,
    /// Seed of all random draws.
    #[serde(default = "one")]
    pub seed: u64,
    /// Independent packings: streams 0, 1, … of the seed.
    #[serde(default = "one")]
    pub realisations: u64,
    /// `[layer]`
    pub layer: LayerTable,
    /// `[[pigment]]`
    #[serde(default)]
    pub pigment: Vec<PigmentTable>,
    #[serde(default, rename = "light")]
    _light: Option<Value>,
    #[serde(default, rename = "binder")]
    _binder: Option<Value>,
    #[serde(default, rename = "grid")]
    _grid: Option<Value>,
    #[serde(default, rename = "solver")]
    _solver: Option<Value>,
    #[serde(default, rename = "paper")]
    _paper: Option<Value>,
    #[serde(default, rename = "appearance")]
    _appearance: Option<Value>,
    #[serde(default, rename = "sweep")]
    _sweep: Option<Value>,
}

fn one() -> u64 {
    1
}

fn yes() -> bool {
    true
}

/// `[layer]`: the cell and the way to fill it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerTable {
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Hard walls, or periodic across the layer too.
    #[serde(default = "yes")]
    pub walls: bool,
    /// How to pack.
    #[serde(default)]
    pub method: MethodChoice,
    /// Limits of random sequential addition.
    #[serde(default)]
    pub sequential: SequentialSettings,
    /// Settings of the relaxation of overlaps.
    #[serde(default)]
    pub relaxation: RelaxationSettings,
    /// Monte Carlo after the packing, if asked.
    #[serde(default)]
    pub equilibration: Option<EquilibrationSettings>,
    /// The binder's surface, if grains stand out of it.
    #[serde(default)]
    pub relief: Option<ReliefRequest>,
}

/// `[[pigment]]`: grains of one kind; `name` and the optical keys serve the other stages.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PigmentTable {
    /// Name, for people.
    #[serde(default)]
    pub name: Option<String>,
    /// Shape of the grains.
    #[serde(default)]
    pub shape: Shape,
    /// Distribution of their sizes.
    pub size: SizeDistribution,
    /// Their volume over the layer's.
    pub volume_fraction: f64,
    /// Alignment of their axes.
    #[serde(default)]
    pub orientation: Orientation,
    /// Which of them stick together, if any.
    #[serde(default)]
    pub agglomeration: Option<Agglomeration>,
    /// How whole grains meet the volume fraction.
    #[serde(default)]
    pub share: ShareRule,
    #[serde(default, rename = "material")]
    _material: Option<Value>,
}

impl PigmentTable {
    fn grains(&self) -> PigmentGrains {
        PigmentGrains {
            shape: self.shape.clone(),
            size: self.size.clone(),
            volume_fraction: self.volume_fraction,
            orientation: self.orientation,
            agglomeration: self.agglomeration.clone(),
            share: self.share,
        }
    }
}

impl PackStudy {
    /// The request of one realisation.
    pub fn request(&self, stream: u64) -> PackingRequest {
        let layer = &self.layer;
        PackingRequest {
            period_um: layer.period_um,
            thickness_um: layer.thickness_um,
            pigments: self.pigment.iter().map(PigmentTable::grains).collect(),
            method: layer.method,
            walls: layer.walls,
            seed: self.seed,
            stream,
            sequential: layer.sequential,
            relaxation: layer.relaxation,
            equilibration: layer.equilibration,
            relief: layer.relief,
        }
    }

    /// Names (given or numbered) and shapes of the pigments.
    pub fn pigments(&self) -> Vec<(String, Shape)> {
        let name = |k: usize, p: &PigmentTable| p.name.clone().unwrap_or_else(|| format!("pigment {k}"));
        self.pigment.iter().enumerate().map(|(k, p)| (name(k, p), p.shape.clone())).collect()
    }

    /// Checks what [`crate::ink::packing::pack`] would refuse, before any work.
    pub fn check(&self) -> Result<(), PackError> {
        if self.realisations == 0 || self.realisations > 100_000 {
            let advice = "set at least one";
            return Err(PackError::input("realisations", self.realisations, "1 to 100000", advice));
        }
        if self.pigment.is_empty() {
            return Err(PackError::input("pigment", "none", "at least one [[pigment]] table", "add one"));
        }
        self.request(0).check()
    }
}
