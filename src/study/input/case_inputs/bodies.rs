//! Bodies and films of a case file: their keys, and what they are in the scene.

use super::CaseInputs;
use crate::ink::{Shape, Solid, Sphere};
use crate::input::limits;
use crate::numerics::files::name_or_table;
use crate::numerics::vector::{Rotation, V3, unit};
use crate::wave::BodyShape;
use schemars::JsonSchema;
use serde::Deserialize;

/// A sphere.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereInput {
    /// Centre (x, y, z), µm.
    pub center: [f64; 3],
    /// Radius, µm.
    #[schemars(transform = limits::ABOVE_ZERO.mark())]
    pub radius: f64,
    /// Index as [re, im].
    pub eta: [f64; 2],
    /// Index of the extraordinary ray as [re, im], of a birefringent sphere: `eta` is then the
    /// ordinary ray's. For Maxwell's equations (`--wave vector`).
    pub eta_extraordinary: Option<[f64; 2]>,
    /// Direction of the optic axis (default: z).
    pub optic_axis: Option<[f64; 3]>,
}

/// A circular cylinder along y.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderInput {
    /// Centre along x, µm.
    pub x: f64,
    /// Centre along z, µm.
    pub z: f64,
    /// Radius, µm.
    #[schemars(transform = limits::ABOVE_ZERO.mark())]
    pub radius: f64,
    /// Index as [re, im].
    pub eta: [f64; 2],
}

/// A convex body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyInput {
    /// An `ellipsoid`, `box`, `disc` or `prism` as in studies, with its lengths in µm. The other
    /// shapes of studies are refused: they consist of spheres, which are given as `spheres`.
    #[serde(deserialize_with = "name_or_table")]
    pub shape: Shape,
    /// Centre (x, y, z), µm.
    pub center: [f64; 3],
    /// Direction of the shape's z axis (default: z).
    pub axis: Option<[f64; 3]>,
    /// Rotation about that axis beforehand, degrees from x towards y.
    #[serde(default)]
    pub turn_deg: f64,
    /// Index as [re, im].
    pub eta: [f64; 2],
    /// Index of the extraordinary ray as [re, im], of a birefringent body: `eta` is then the
    /// ordinary ray's. For Maxwell's equations (`--wave vector`).
    pub eta_extraordinary: Option<[f64; 2]>,
    /// Direction of the optic axis before the body is turned (default: z).
    pub optic_axis: Option<[f64; 3]>,
}

impl BodyInput {
    /// The body in its place; `None` for shapes made of spheres.
    pub fn solid(&self) -> Option<Solid> {
        let turn = Rotation::by([0.0, 0.0, self.turn_deg.to_radians()]);
        let tilt = Rotation::from_z_to(unit(self.axis.unwrap_or([0.0, 0.0, 1.0])));
        Some(Solid { form: self.shape.form()?, center_um: self.center, rotation: turn.then(tilt) })
    }
}

/// A homogeneous film.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerInput {
    /// Thickness, µm.
    #[schemars(transform = limits::NOT_NEGATIVE.mark())]
    pub thickness: f64,
    /// Index as [re, im].
    pub eta: [f64; 2],
    /// Index of the extraordinary ray as [re, im], of a birefringent film, which holds no bodies:
    /// `eta` is then the ordinary ray's. For Maxwell's equations (`--wave vector`).
    pub eta_extraordinary: Option<[f64; 2]>,
    /// Direction of the optic axis (default: z).
    pub optic_axis: Option<[f64; 3]>,
}

/// A film with bars.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SublayerInput {
    /// Thickness, µm.
    #[schemars(transform = limits::NOT_NEGATIVE.mark())]
    pub thickness: f64,
    /// Index between the bars as [re, im].
    pub eta_background: [f64; 2],
    /// Bars across the whole thickness of the film.
    #[serde(default)]
    pub bars: Vec<BarInput>,
}

/// A bar along y.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BarInput {
    /// First edge, µm.
    pub x0: f64,
    /// Second edge, µm.
    pub x1: f64,
    /// Index as [re, im].
    pub eta: [f64; 2],
}

/// A body of a case with its name in the file.
pub(in crate::input) struct NamedBody {
    pub name: String,
    pub shape: BodyShape,
    /// Index; of a crystal the ordinary ray's.
    pub eta: [f64; 2],
    pub crystal: Option<CrystalInput>,
}

/// What a crystal has besides its ordinary index.
pub(in crate::input) struct CrystalInput {
    pub eta_extraordinary: [f64; 2],
    /// In the case's coordinates.
    pub optic_axis: V3,
}

fn crystal(eta: Option<[f64; 2]>, axis: Option<V3>, rotation: Rotation) -> Option<CrystalInput> {
    let optic_axis = rotation.turn(axis.unwrap_or([0.0, 0.0, 1.0]));
    eta.map(|eta_extraordinary| CrystalInput { eta_extraordinary, optic_axis })
}

impl CaseInputs {
    /// All bodies in the order of the scene, with their names in the file and their indices; films
    /// of zero thickness have none.
    pub(in crate::input) fn bodies(&self) -> Vec<NamedBody> {
        let mut all = Vec::new();
        for (i, s) in self.spheres.iter().flatten().enumerate() {
            let ball = Sphere { center_um: s.center, radius_um: s.radius };
            let shape = BodyShape::Balls(vec![ball]);
            let crystal = crystal(s.eta_extraordinary, s.optic_axis, Rotation::IDENTITY);
            all.push(NamedBody { name: format!("spheres[{i}]"), shape, eta: s.eta, crystal });
        }
        for (i, c) in self.cylinders.iter().flatten().enumerate() {
            let shape = BodyShape::CylinderY { x_um: c.x, z_um: c.z, radius_um: c.radius };
            all.push(NamedBody { name: format!("cylinders[{i}]"), shape, eta: c.eta, crystal: None });
        }
        for (i, b) in self.bodies.iter().flatten().enumerate() {
            all.extend(b.solid().map(|solid| NamedBody {
                name: format!("bodies[{i}]"),
                crystal: crystal(b.eta_extraordinary, b.optic_axis, solid.rotation),
                shape: BodyShape::Solid(solid),
                eta: b.eta,
            }));
        }
        let mut bottom = 0.0;
        for (i, layer) in self.sublayers_from_z0.iter().flatten().enumerate() {
            let z_um = [bottom, bottom + layer.thickness];
            for (j, bar) in layer.bars.iter().enumerate().filter(|_| layer.thickness != 0.0) {
                let name = format!("sublayers_from_z0[{i}].bars[{j}]");
                let shape = BodyShape::BarY { x_um: [bar.x0, bar.x1], z_um };
                all.push(NamedBody { name, shape, eta: bar.eta, crystal: None });
            }
            bottom = z_um[1];
        }
        all
    }

    /// Films of crystals as bodies that fill them.
    pub(in crate::input) fn birefringent_films(&self) -> Vec<NamedBody> {
        let mut all = Vec::new();
        let mut bottom = 0.0;
        for (i, film) in self.layers_from_z0.iter().flatten().enumerate() {
            let z_um = [bottom, bottom + film.thickness];
            bottom = z_um[1];
            let crystal = crystal(film.eta_extraordinary, film.optic_axis, Rotation::IDENTITY);
            if crystal.is_some() && film.thickness != 0.0 {
                let name = format!("layers_from_z0[{i}]");
                all.push(NamedBody { name, shape: BodyShape::Sheet { z_um }, eta: film.eta, crystal });
            }
        }
        all
    }

    /// What crystals have, with the names of their fields: the extraordinary index and the axis.
    pub(in crate::input) fn crystals(&self) -> Vec<(String, Option<[f64; 2]>, Option<[f64; 3]>)> {
        let mut all = Vec::new();
        let spheres = self.spheres.iter().flatten().enumerate();
        all.extend(spheres.map(|(i, s)| (format!("spheres[{i}]"), s.eta_extraordinary, s.optic_axis)));
        let bodies = self.bodies.iter().flatten().enumerate();
        all.extend(bodies.map(|(i, b)| (format!("bodies[{i}]"), b.eta_extraordinary, b.optic_axis)));
        let films = self.layers_from_z0.iter().flatten().enumerate();
        all.extend(films.map(|(i, f)| (format!("layers_from_z0[{i}]"), f.eta_extraordinary, f.optic_axis)));
        all
    }
}
