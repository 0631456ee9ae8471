//! One door to every wave: scene, media, light and grid in, far fields out, scalar or in s, p and unpolarised light.
//!
//! [`Geometry`] holds what does not depend on wavelength and direction, so that it is made once per scene and grid;
//! s and p share it, and in a [`WaveProblem`] the contrast's tensor and the mean operator's tables.

use super::solver::{Account, Goal, SolveError, Solver, Watch};
use crate::wave::contrast::coverage::{NEVER, Stop};
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

    /// True for Maxwell's equations.
    pub fn is_vector(self) -> bool {
        self != Wave::Scalar
    }

    /// The light that paper gives back: it depolarises.
    pub fn returned(self) -> Wave {
        if self.is_vector() { Wave::Unpolarised } else { Wave::Scalar }
    }

    /// The scheme that the wave needs: the vector wave has two Gauss planes a cell.
    pub fn scheme(self, scalar: Scheme) -> Scheme {
        if self.is_vector() { Scheme::Quadratic } else { scalar }
    }

    /// The name as it is written in study files.
    pub fn name(self) -> &'static str {
        match self {
            Wave::Scalar => "scalar",
            Wave::S => "s",
            Wave::P => "p",
            Wave::Unpolarised => "unpolarised",
        }
    }

    /// What it is, in a few words for reports.
    pub fn in_words(self) -> &'static str {
        match self {
            Wave::Scalar => "scalar wave equation",
            Wave::S => "Maxwell's equations, s-polarised light",
            Wave::P => "Maxwell's equations, p-polarised light",
            Wave::Unpolarised => "Maxwell's equations, unpolarised light",
        }
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

/// The discrete problem of one wavelength and direction.
pub enum WaveProblem {
    /// Of the scalar wave.
    Scalar(Box<Problem>),
    /// Of Maxwell's equations: s and p share it.
    Vector(Box<VectorProblem>),
}

/// Why there is no far field.
#[derive(Debug, Error)]
pub enum DoorError {
    /// The scene, the light or the grid is refused.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// A strategy gave up.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl Geometry {
    /// The geometry of a scene on a grid with moments of a relative error, see [`Coverage::within`].
    ///
    /// # Errors
    /// Grids and bodies that are refused.
    pub fn new(wave: Wave, scene: &Scene, resolution: Resolution, error: f64) -> Result<Geometry, WaveError> {
        Geometry::new_unless(wave, scene, (resolution, error), NEVER)
    }

    /// The same until it is stopped.
    ///
    /// # Errors
    /// [`WaveError::Stopped`]; grids and bodies that are refused.
    pub fn new_unless(
        wave: Wave,
        scene: &Scene,
        (resolution, error): (Resolution, f64),
        stop: Stop,
    ) -> Result<Geometry, WaveError> {
        Ok(match wave {
            Wave::Scalar => Geometry::Scalar(Coverage::within_unless(scene, resolution, error, stop)?.into()),
            _ => Geometry::Vector(NormalMoments::within_unless(scene, resolution, error, stop)?.into()),
        })
    }

    /// The problem for one wavelength and direction.
    ///
    /// # Errors
    /// Media and lights that are refused.
    pub fn problem(&self, media: &Media, light: &Incidence, mean: Mean) -> Result<WaveProblem, WaveError> {
        Ok(match self {
            Geometry::Scalar(coverage) => {
                WaveProblem::Scalar(Box::new(Problem::new(coverage, media, light, mean)?))
            }
            Geometry::Vector(moments) => {
                let problem = VectorProblem::new(moments, media, light, mean, Averaging::Normal)?;
                WaveProblem::Vector(Box::new(problem))
            }
        })
    }
}

impl WaveProblem {
    /// Solves for light of one polarisation, or for the scalar wave.
    ///
    /// # Errors
    /// [`DoorError`]: the strategy gives up, or the polarisation does not fit the kind of wave.
    pub fn far_field(
        &self,
        polarisation: Option<Polarisation>,
        solver: &dyn Solver,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<(FarField, Account), DoorError> {
        match (self, polarisation) {
            (WaveProblem::Scalar(problem), None) => {
                let solution = solver.solve(&**problem, goal, watch)?;
                Ok((problem.far_field(&solution.field), solution.account))
            }
            (WaveProblem::Vector(problem), Some(polarisation)) => {
                let solution = solver.solve(&problem.polarised(polarisation), goal, watch)?;
                Ok((problem.polarised_far_field(&solution.field, polarisation), solution.account))
            }
            _ => Err(DoorError::Wave(WaveError::NotInVectorMode {
                what: "a polarisation of the scalar wave, or none of the vector wave",
                reason: "the scalar wave has no polarisation, Maxwell's equations need one",
                remedy: "make the geometry with the wave that is to be solved",
            })),
        }
    }
}
