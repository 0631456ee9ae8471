//! The keys of a case file.

mod bodies;

pub use bodies::{BarInput, BodyInput, CylinderInput, LayerInput, SphereInput, SublayerInput};
pub(super) use bodies::{CrystalInput, NamedBody};

use super::fault::{Fault, Faults};
use super::forms::Pair;
use super::limits;
use crate::numerics::allowed::shown;
use crate::wave::Side;
use schemars::{JsonSchema, Schema};
use serde::Deserialize;
use serde_json::json;
use thiserror::Error;

/// A geometry with its media and light; lengths in µm, angles in degrees.
///
/// `n_in` is the index of the half-space z < 0, the incident side, `n_out` that of z > H, each a
/// number or [re, im].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = one_wavelength)]
pub struct CaseInputs {
    /// Vacuum wavelength, µm: from 0.1 to 20. `wavelength_um` takes any, `wavelength_nm` one from
    /// 100 to 20000 nm.
    #[schemars(transform = limits::LIGHT_UM.mark(), example = 0.55)]
    pub wavelength: Option<f64>,
    /// Vacuum wavelength, µm, of any size; instead of `wavelength`.
    #[schemars(transform = limits::ABOVE_ZERO.mark())]
    pub wavelength_um: Option<f64>,
    /// Vacuum wavelength, nm; instead of `wavelength`.
    #[schemars(transform = limits::LIGHT_NM.mark())]
    pub wavelength_nm: Option<f64>,
    /// Polar angle from the normal, degrees.
    #[serde(default)]
    #[schemars(transform = limits::POLAR_DEG.mark())]
    pub sigma_deg: f64,
    /// Azimuth from the x axis, degrees.
    #[serde(default)]
    pub phi_deg: f64,
    /// Period along x, µm, and along y unless `Ly` is given; or both as a pair. Not needed for
    /// films.
    #[serde(rename = "L")]
    pub period: Option<Pair>,
    /// Period along y, µm (default: that along x).
    #[serde(rename = "Ly")]
    pub period_y: Option<f64>,
    /// Thickness, µm (default: sum of the layers).
    #[serde(rename = "H")]
    #[schemars(transform = limits::ABOVE_ZERO.mark(), example = 1.0)]
    pub thickness: Option<f64>,
    /// Index of the half-space z < 0 (default: 1).
    pub n_in: Option<IndexInput>,
    /// Index of the half-space z > H (default: 1).
    pub n_out: Option<IndexInput>,
    /// Index of the incident side as [re, im], instead of `n_in`; called `eta_below` in published
    /// reference cases.
    #[serde(alias = "eta_below")]
    pub eta_in: Option<[f64; 2]>,
    /// Index of the exit side as [re, im], instead of `n_out`; called `eta_above` in published
    /// reference cases.
    #[serde(alias = "eta_above")]
    pub eta_out: Option<[f64; 2]>,
    /// Index of the binder as [re, im].
    pub eta_binder: Option<[f64; 2]>,
    /// Side of incidence: `incident` is z < 0.
    #[serde(default)]
    pub from: Side,
    /// Directions that are solved together, instead of a single one, on one grid: each is a table
    /// with `sigma_deg`, `phi_deg` and `from`; what it leaves out is that of the case.
    #[schemars(length(min = 1, max = MOST_DIRECTIONS))]
    pub directions: Option<Vec<DirectionInput>>,
    /// Spheres in the binder or in films; one wholly inside another sphere or body displaces its
    /// material, which makes layers and hollow grains.
    pub spheres: Option<Vec<SphereInput>>,
    /// Cylinders along y in the binder or in films.
    pub cylinders: Option<Vec<CylinderInput>>,
    /// Convex bodies in the binder or in films or inside each other: ellipsoids, boxes, discs and
    /// prisms.
    pub bodies: Option<Vec<BodyInput>>,
    /// Homogeneous films, starting at z = 0; instead of a binder. Spheres, cylinders and bodies may
    /// lie in them and across their faces.
    pub layers_from_z0: Option<Vec<LayerInput>>,
    /// Films with bars along y, starting at z = 0; instead of a binder.
    pub sublayers_from_z0: Option<Vec<SublayerInput>>,
    #[serde(default)]
    #[allow(dead_code, reason = "free text of reference files")]
    note: Option<String>,
}

/// Most directions of a case: more than the orders of any cell that fits into memory.
pub(super) const MOST_DIRECTIONS: usize = 4096;

/// A direction of the light; what is left out is that of the case.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionInput {
    /// Polar angle from the normal, degrees.
    #[schemars(transform = limits::POLAR_DEG.mark())]
    pub sigma_deg: Option<f64>,
    /// Azimuth from the x axis, degrees.
    pub phi_deg: Option<f64>,
    /// Side of incidence.
    pub from: Option<Side>,
}

/// Requires one of the keys of the wavelength.
fn one_wavelength(schema: &mut Schema) {
    let one = |key: &str| json!({ "required": [key] });
    schema.insert("oneOf".into(), WAVELENGTHS.map(one).to_vec().into());
}

/// The keys of the wavelength, of which a case has one.
pub(super) const WAVELENGTHS: [&str; 3] = ["wavelength", "wavelength_um", "wavelength_nm"];

/// A refractive index: a number, or [re, im].
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "an index: a number or [re, im]")]
pub enum IndexInput {
    /// Index of a transparent medium.
    Real(f64),
    /// Real and imaginary part; a positive imaginary part absorbs.
    Complex([f64; 2]),
}

impl IndexInput {
    /// The index as [re, im].
    pub fn parts(self) -> [f64; 2] {
        match self {
            IndexInput::Real(n) => [n, 0.0],
            IndexInput::Complex(parts) => parts,
        }
    }
}

impl CaseInputs {
    /// Vacuum wavelength, µm; `None` if no key gives it.
    pub fn vacuum_wavelength_um(&self) -> Option<f64> {
        self.wavelength.or(self.wavelength_um).or(self.wavelength_nm.map(|nm| 1e-3 * nm))
    }

    /// Lengths with their names in the file, µm: periods, thicknesses and radii.
    fn lengths_um(&self) -> Vec<(String, f64)> {
        let mut all = Vec::new();
        match self.period {
            Some(Pair::Both(x)) => all.push(("L".to_owned(), x)),
            Some(Pair::Each([x, y])) => all.extend([("L[0]".to_owned(), x), ("L[1]".to_owned(), y)]),
            None => {}
        }
        all.extend(self.period_y.map(|y| ("Ly".to_owned(), y)));
        all.extend(self.thickness.map(|h| ("H".to_owned(), h)));
        let films = self.layers_from_z0.iter().flatten().enumerate();
        all.extend(films.map(|(i, film)| (format!("layers_from_z0[{i}].thickness"), film.thickness)));
        let films = self.sublayers_from_z0.iter().flatten().enumerate();
        all.extend(films.map(|(i, film)| (format!("sublayers_from_z0[{i}].thickness"), film.thickness)));
        let spheres = self.spheres.iter().flatten().enumerate();
        all.extend(spheres.map(|(i, sphere)| (format!("spheres[{i}].radius"), sphere.radius)));
        let cylinders = self.cylinders.iter().flatten().enumerate();
        all.extend(cylinders.map(|(i, cylinder)| (format!("cylinders[{i}].radius"), cylinder.radius)));
        all
    }

    /// What may be a mistake in a unit: the first length of an unusual size, and how many there
    /// are.
    pub(super) fn remarks(&self) -> Vec<String> {
        let mut unusual = self.lengths_um();
        unusual.retain(|&(_, um)| um != 0.0 && !limits::USUAL_LENGTH_UM.holds(um));
        let Some((name, um)) = unusual.first() else { return Vec::new() };
        let others = match unusual.len() {
            1 => String::new(),
            n => format!(" ({} more lengths are of such a size)", n - 1),
        };
        let remedy = if *um > 1.0 {
            format!("if it is in nm, write {}", shown(1e-3 * um))
        } else {
            "if it is in m, multiply it by 1e6".to_owned()
        };
        vec![format!("{name} is {} µm{others}: lengths are in µm; {remedy}", shown(*um))]
    }

    /// Periods along x and y. `Ly` beside a pair is refused by the checks; films, which do not
    /// depend on the period, default to 1 µm.
    pub fn period_um(&self) -> [f64; 2] {
        match self.period.unwrap_or(Pair::Both(1.0)) {
            Pair::Both(x) => [x, self.period_y.unwrap_or(x)],
            Pair::Each(pair) => pair,
        }
    }
}

/// Why a case cannot be solved.
#[derive(Debug, Error)]
pub enum CaseError {
    /// The file cannot be read.
    #[error("cannot read {path}: {cause}; check the path and its permissions")]
    Read {
        /// The file.
        path: String,
        /// The system's error message.
        cause: std::io::Error,
    },
    /// The file is not a valid case.
    #[error("{path} is not a case: {reason}")]
    Refused {
        /// The file.
        path: String,
        /// All that is wrong, with remedies.
        reason: String,
    },
    /// The case cannot be discretised.
    #[error(transparent)]
    Wave(#[from] crate::wave::WaveError),
}

impl CaseError {
    /// A text that does not come from a file.
    pub(super) fn refused(reason: String) -> Self {
        Self::Refused { path: "the text".into(), reason }
    }
}

impl From<Fault> for CaseError {
    fn from(fault: Fault) -> Self {
        Faults(vec![fault]).into()
    }
}

impl From<Faults> for CaseError {
    fn from(faults: Faults) -> Self {
        Self::refused(faults.to_string())
    }
}
