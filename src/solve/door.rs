//! One door to every wave: scene, media, light and grid in, far fields out, scalar or in s, p and unpolarised light.
//!
//! [`Geometry`] holds what does not depend on wavelength and direction, so that it is made once per scene and grid;
//! s and p share it, the contrast's tensor and the mean operator's tables.

use super::solver::{Account, Goal, SolveError, Solver, Watch};
use crate::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorProblem};
use crate::wave::{
    Coverage, FarField, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, WaveError,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use thiserror::Error;

/// Which equation is solved, and for which light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wave {
    /// The scalar wave equation: like s light, without polarisation.
    #[default]
    Scalar,
    /// Maxwell's equations, E perpendicular to the plane of incidence.
    S,
    /// Maxwell's equations, E in the plane of incidence.
    P,
    /// Maxwell's equations, the mean of s and p efficiencies.
    Unpolarised,
}

impl Wave {
    /// Names as they are written in study files.
    pub const NAMES: [&'static str; 4] = ["scalar", "s", "p", "unpolarised"];

    /// The polarisations to be solved; none for the scalar wave.
    pub fn polarisations(self) -> &'static [Polarisation] {
        match self {
            Wave::Scalar => &[],
            Wave::S => &Polarisation::BOTH[..1],
            Wave::P => &Polarisation::BOTH[1..],
            Wave::Unpolarised => &Polarisation::BOTH,
        }
    }

    /// A resolution in the scheme that the wave needs: the vector wave has two Gauss planes a cell.
    pub fn resolution(self, nx: usize, ny: usize, cells: usize, scalar: Scheme) -> Resolution {
        let scheme = if self == Wave::Scalar { scalar } else { Scheme::Quadratic };
        Resolution { nx, ny, cells, scheme }
    }
}

/// A scene on a grid, for one kind of wave.
#[derive(Clone)]
pub enum Geometry {
    /// For the scalar wave.
    Scalar(Arc<Coverage>),
    /// For Maxwell's equations.
    Vector(Arc<NormalMoments>),
}

/// Why there are no far fields.
#[derive(Debug, Error)]
pub enum DoorError {
    /// The scene, the light or the grid is refused.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// A strategy gave up.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// What leaves the layer, for each solve that the wave needs.
#[derive(Clone, Debug)]
pub struct FarFields {
    /// One far field, or those of s and p for unpolarised light.
    pub each: Vec<FarField>,
    /// The solves' accounts, in the same order.
    pub accounts: Vec<Account>,
}

/// What is solved: everything but the geometry.
#[derive(Clone, Copy)]
pub struct Light<'a> {
    /// Equation and polarisation.
    pub wave: Wave,
    /// Indices of all media.
    pub media: &'a Media,
    /// Wavelength and direction.
    pub incidence: &'a Incidence,
    /// Choice of ⟨k²⟩.
    pub mean: Mean,
}

impl Geometry {
    /// The geometry of a scene on a grid with moments of a relative error, see [`Coverage::within`].
    ///
    /// # Errors
    /// Grids and bodies that are refused.
    pub fn new(wave: Wave, scene: &Scene, resolution: Resolution, error: f64) -> Result<Geometry, WaveError> {
        Ok(match wave {
            Wave::Scalar => Geometry::Scalar(Arc::new(Coverage::within(scene, resolution, error)?)),
            _ => Geometry::Vector(Arc::new(NormalMoments::within(scene, resolution, error)?)),
        })
    }

    /// Solves for one wavelength and direction.
    ///
    /// # Errors
    /// [`DoorError`]; [`Light::wave`] must be the kind of wave that the geometry was made for.
    pub fn far_fields(
        &self,
        light: Light,
        solver: &dyn Solver,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<FarFields, DoorError> {
        let mut found = FarFields { each: Vec::new(), accounts: Vec::new() };
        match self {
            Geometry::Scalar(coverage) if light.wave == Wave::Scalar => {
                let problem = Problem::new(coverage, light.media, light.incidence, light.mean)?;
                let solution = solver.solve(&problem, goal, watch)?;
                found.each.push(problem.far_field(&solution.field));
                found.accounts.push(solution.account);
            }
            Geometry::Vector(moments) if light.wave != Wave::Scalar => {
                let averaging = Averaging::Normal;
                let problem =
                    VectorProblem::new(moments, light.media, light.incidence, light.mean, averaging)?;
                for &polarisation in light.wave.polarisations() {
                    let solution = solver.solve(&problem.polarised(polarisation), goal, watch)?;
                    found.each.push(problem.polarised_far_field(&solution.field, polarisation));
                    found.accounts.push(solution.account);
                }
            }
            _ => {
                return Err(DoorError::Wave(WaveError::NotInVectorMode {
                    what: "a geometry made for the other kind of wave",
                    reason: "coverage serves the scalar wave, normal moments Maxwell's equations",
                    remedy: "make the geometry with the wave that is to be solved",
                }));
            }
        }
        Ok(found)
    }
}

impl FarFields {
    /// The mean of efficiencies and totals, as unpolarised light has them. Amplitudes are those of the first far field:
    /// s and p are not coherent, and their mean would mean nothing.
    pub fn mean(&self) -> FarField {
        let mut mean = self.each[0].clone();
        let count = self.each.len() as f64;
        let average = |of: &dyn Fn(&FarField) -> f64| self.each.iter().map(of).sum::<f64>() / count;
        mean.reflectance = average(&|f| f.reflectance);
        mean.transmittance = average(&|f| f.transmittance);
        mean.absorptance = average(&|f| f.absorptance);
        for (i, order) in mean.orders.iter_mut().enumerate() {
            order.reflected_efficiency = average(&|f| f.orders[i].reflected_efficiency);
            order.transmitted_efficiency = average(&|f| f.orders[i].transmitted_efficiency);
        }
        mean
    }
}
