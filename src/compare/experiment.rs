//! Method comparison: strategies × resolutions × discretisations on one geometry, side by side.

mod file;
mod reference;
mod rows;

pub use super::error::CompareError;
pub use super::layer::PackedLayer;
pub use file::{ComparisonFile, Points};

use super::matrix::{Cell, Matrix};
use super::pages::{Comparison, Row};
use crate::solve::{Coverages, Registry, Watch};
use crate::wave::{Resolution, Scene, Scheme};
use reference::Subject;

/// What a comparison is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Bodies of the geometry (of the matrix's own study).
    pub bodies: usize,
    /// Solves, but for those of the search for a grid.
    pub rows: usize,
}

impl ComparisonFile {
    /// Rows of the comparison, or of its matrix, without a solve: the geometry is packed, and everything is checked.
    ///
    /// # Errors
    /// As [`ComparisonFile::run`], but those of solves.
    pub fn plan(&self, registry: &Registry) -> Result<Plan, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?.len();
        let Subject { case, .. } = self.subject()?;
        let bodies = case.scene.bodies.len();
        let Some(matrix) = &self.matrix else {
            return Ok(Plan { bodies, rows: strategies * self.schemes.len() * self.resolutions.len() });
        };
        matrix.check()?;
        Ok(Plan { bodies, rows: strategies * matrix.pigments.len() * matrix.periods_um.len() })
    }

    /// Runs the matrix, if one is asked for; `watch` sees each solve's steps and can stop it.
    ///
    /// # Errors
    /// Unknown strategies; layers that cannot be packed; cases that the reference strategy cannot solve; Ctrl-C.
    pub fn run_matrix(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        told: impl FnMut(&Cell),
    ) -> Result<Option<Matrix>, CompareError> {
        let Some(matrix) = &self.matrix else { return Ok(None) };
        self.check()?;
        let Some(packed) = self.packed()? else {
            let (found, allowed) = ("a case".into(), "a study, whose period and index vary".into());
            let remedy = "name a study file, or write a whole study as [study]";
            return Err(CompareError::Field { field: "matrix", found, allowed, remedy });
        };
        let strategies = self.strategies(registry)?;
        let cells = matrix.run(&packed, &strategies, watch, told)?;
        let names = strategies.into_iter().map(|(name, _)| name.to_string()).collect();
        let (title, accuracy) = (self.title.clone(), matrix.accuracy);
        Ok(Some(Matrix { title, accuracy, strategies: names, cells }))
    }

    /// Runs every row with the strategies of `registry`; `watch` sees each solve's steps and can stop the comparison.
    pub fn run(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        mut told: impl FnMut(&Row),
    ) -> Result<Comparison, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subject = self.subject()?;
        let (truth, reference) = self.reference(&subject)?;
        let coverages = Coverages::of(&subject.case.scene);
        let mut rows = Vec::new();
        for scheme in &self.schemes {
            for points in &self.resolutions {
                let resolution = resolution(&subject.case.scene, *points, *scheme);
                for (name, solver) in &strategies {
                    let row =
                        self.row((name, &**solver), resolution, &subject.case, &coverages, &truth, watch)?;
                    told(&row);
                    rows.push(row);
                }
            }
        }
        Ok(Comparison { title: self.title.clone(), reference, rows })
    }
}

/// A grid of the list; one point is enough along an axis that nothing depends on.
fn resolution(scene: &Scene, points: Points, scheme: Scheme) -> Resolution {
    let nx = if scene.uniform_in_plane() { 1 } else { points.points };
    let ny = if scene.uniform_in_y() { 1 } else { points.points };
    Resolution { nx, ny, cells: points.cells, scheme }
}
