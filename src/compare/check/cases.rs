//! The cases of the check: small, without symmetry, and lit from directions of the reciprocal
//! lattice, so that programs with periodic boundaries solve them as well.

use super::slips::SlipLight;
use crate::compare::error::CompareError;
use crate::compare::external::judge::{ExpectedOrder, expected};
use crate::compare::external::protocol::WaveKind;
use crate::input::case::Case;
use crate::run::memory;
use crate::solve::accuracy::{Task, suited_scheme};
use crate::solve::{Coverages, Gmres, Goal, Watch};
use crate::wave::contrast::coverage::error_for;
use crate::wave::{Mean, Precision};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Names of the cases.
pub const KNOWN: [&str; 3] = ["film", "grating", "sphere"];

/// Amplitude error of inkwave's own solution, far below [`TOLERANCE`](super::TOLERANCE).
const ACCURACY: f64 = 1e-3;

/// A case with a known answer.
#[derive(Clone, Debug)]
pub struct KnownCase {
    /// Its name.
    pub name: &'static str,
    /// The equation.
    pub wave: WaveKind,
    /// The keys of a case file.
    pub inputs: Value,
}

impl KnownCase {
    /// One of [`KNOWN`], for a wave.
    pub fn new(name: &'static str, wave: WaveKind) -> KnownCase {
        let inputs = match name {
            "film" => film(),
            "grating" => grating(),
            _ => sphere(),
        };
        KnownCase { name, wave, inputs }
    }

    /// The case, checked.
    ///
    /// # Errors
    /// None for the cases as they are.
    pub fn case(&self) -> Result<Case, CompareError> {
        Ok(Case::parse(&self.inputs.to_string(), false)?)
    }

    /// All orders that propagate, as inkwave solves them.
    ///
    /// # Errors
    /// The user stopped it.
    pub fn orders(&self, watch: &mut dyn Watch) -> Result<Vec<ExpectedOrder>, CompareError> {
        let (case, wave) = (self.case()?, self.wave.wave());
        let task = Task {
            coverages: &Coverages::new(wave, &case.scene, Precision::of(error_for(ACCURACY))),
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean { depends_on_z: true, absorbing: true },
            scheme: wave.scheme(suited_scheme(ACCURACY)),
            solver: &Gmres::default(),
            goal: Goal { tolerance: ACCURACY / 50.0, ..Goal::default() },
            memory: memory::usable(),
        };
        Ok(expected(&task.solve_to_accuracy(ACCURACY, watch)?.far_fields))
    }

    /// What slips depend on; the half-spaces of the known cases are real.
    pub(super) fn light(&self) -> SlipLight {
        let number = |key: &str| self.inputs[key].as_f64().unwrap_or_default();
        let (k0, polar, azimuth) = (TAU / number("wavelength"), number("sigma_deg"), number("phi_deg"));
        let ((sin, cos), (y, x)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        let lateral = [sin * x, sin * y];
        let step = [0, 1].map(|axis| self.inputs["L"][axis].as_f64().unwrap_or(1.0)).map(|um| TAU / um / k0);
        SlipLight { kappa: cos, height: k0 * number("H"), exit: number("n_out"), lateral, step }
    }
}

/// Two films, the first absorbing, on glass; kx is one step of a lattice of 1 µm.
fn film() -> Value {
    json!({
        "wavelength": 0.5, "sigma_deg": 30.0, "phi_deg": 0.0, "L": [1.0, 1.0], "H": 0.35, "n_in": 1.0, "n_out": 1.5,
        "layers_from_z0": [{ "thickness": 0.2, "eta": [1.8, 0.1] }, { "thickness": 0.15, "eta": [1.4, 0.0] }],
    })
}

/// Two different bars under a film; kx is one step of the lattice.
fn grating() -> Value {
    let bars = json!([
        { "x0": 0.1, "x1": 0.35, "eta": [1.9, 0.0] },
        { "x0": 0.5, "x1": 0.65, "eta": [1.6, 0.2] },
    ]);
    json!({
        "wavelength": 0.54, "sigma_deg": 0.6_f64.asin().to_degrees(), "phi_deg": 0.0, "L": [0.9, 0.9], "H": 0.4,
        "n_in": 1.0, "n_out": 1.5,
        "sublayers_from_z0": [
            { "thickness": 0.1, "eta_background": [1.5, 0.0], "bars": [] },
            { "thickness": 0.3, "eta_background": [1.3, 0.0], "bars": bars },
        ],
    })
}

/// One absorbing sphere off the centre of a rectangular cell; ky is one step of the lattice.
fn sphere() -> Value {
    json!({
        "wavelength": 0.5, "sigma_deg": 0.625_f64.asin().to_degrees(), "phi_deg": 90.0, "L": [0.6, 0.8], "H": 0.45,
        "n_in": 1.0, "n_out": 1.33, "eta_binder": [1.5, 0.0],
        "spheres": [{ "center": [0.2, 0.5, 0.22], "radius": 0.15, "eta": [1.9, 0.1] }],
    })
}
