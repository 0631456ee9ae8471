//! The short form of a packed layer, from before comparisons read studies.

use super::subject::Packed;
use crate::input::fault::Fault;
use crate::input::read::read;
use crate::input::tree::Node;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;
use std::path::Path;

/// Equal spheres in a binder, between vacuum half-spaces: an older form of `study`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PackedLayer {
    /// Lateral period, µm.
    pub period_um: f64,
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Diameter of the spheres, nm.
    pub diameter_nm: f64,
    /// Their volume over the layer's.
    pub volume_fraction: f64,
    /// Index of the spheres as [re, im].
    pub pigment: [f64; 2],
    /// Index of the binder as [re, im].
    pub binder: [f64; 2],
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Polar angle from the normal, degrees.
    #[serde(default)]
    pub polar_deg: f64,
    /// Azimuth from the x axis, degrees.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Seed of the packing.
    #[serde(default)]
    pub seed: u64,
}

impl PackedLayer {
    /// The same as a study in the comparison `origin`.
    pub(super) fn packed(&self, origin: &Path) -> Result<Packed, Vec<Fault>> {
        let index = |[n, k]: [f64; 2]| json!({ "n": n, "k": k });
        let study = json!({
            "layer": {
                "cell": "fixed",
                "period_um": self.period_um,
                "thickness_um": self.thickness_um,
                "binder": { "index": index(self.binder) },
            },
            "pigment": [{
                "diameter_nm": self.diameter_nm,
                "volume_fraction": self.volume_fraction,
                "index": index(self.pigment),
            }],
            "light": { "wavelengths_nm": [1e3 * self.wavelength_um] },
            "angles": { "polar_deg": [self.polar_deg], "azimuth_deg": self.azimuth_deg },
            "run": { "seed": self.seed, "realisations": 1 },
        });
        // Every JSON value is a node.
        let node = Node::deserialize(study).unwrap_or(Node::Null);
        Ok(Packed::of(read(node)?, origin))
    }
}
