//! Method comparison: strategies × resolutions × discretisations on one geometry, side by side.

mod file;
mod reference;
mod rows;
mod unused;

pub use super::error::CompareError;
pub use file::{ComparisonFile, Points};

use super::error::kept;
use super::matrix::{Cell, Matrix, MatrixTable};
use super::pages::{Comparison, Row};
use super::subject::Packed;
use crate::solve::{Coverages, Registry, Watch};
use crate::wave::{Resolution, Scene, Scheme};

/// What a comparison is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComparisonPlan {
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
    pub fn plan(&self, registry: &Registry) -> Result<ComparisonPlan, CompareError> {
        self.planned(registry).map_err(|error| error.in_file(&self.origin))
    }

    fn planned(&self, registry: &Registry) -> Result<ComparisonPlan, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?.len();
        let subject = self.subject()?;
        let bodies = subject.case.scene.bodies.len();
        let Some(matrix) = &self.matrix else {
            self.check_reference(&subject)?;
            return Ok(ComparisonPlan {
                bodies,
                rows: strategies * self.schemes.len() * self.resolutions.len(),
            });
        };
        matrix.check_cases(&self.varying()?)?;
        Ok(ComparisonPlan { bodies, rows: strategies * matrix.pigments.len() * matrix.periods_um.len() })
    }

    /// The study that a matrix varies.
    fn varying(&self) -> Result<Packed, CompareError> {
        let (found, allowed) = ("a case".into(), "a study, whose period and index vary".into());
        let remedy = "name a study file, or write a whole study as [study]";
        self.packed()?.ok_or(CompareError::Field { field: "matrix".into(), found, allowed, remedy })
    }

    /// Runs the matrix, if one is asked for; `watch` sees each solve's steps and can stop it: what is solved by then is kept.
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
        let run = self.solved(matrix, registry, watch, told);
        run.map(Some).map_err(|error| error.in_file(&self.origin))
    }

    fn solved(
        &self,
        matrix: &MatrixTable,
        registry: &Registry,
        watch: &mut dyn Watch,
        told: impl FnMut(&Cell),
    ) -> Result<Matrix, CompareError> {
        self.check()?;
        let packed = self.varying()?;
        let strategies = self.strategies(registry)?;
        let cells = matrix.run(&packed, &strategies, watch, told)?;
        let asked = matrix.pigments.len() * matrix.periods_um.len() * strategies.len();
        let names = strategies.into_iter().map(|(name, _)| name.to_string()).collect();
        Ok(Matrix {
            title: self.title.clone(),
            file: self.origin.clone(),
            accuracy: matrix.accuracy,
            max_applications: matrix.max_applications,
            strategies: names,
            registry: names_of(registry),
            asked,
            cells,
        })
    }

    /// Runs every row with the strategies of `registry`; `watch` sees each solve's steps and can stop the comparison: rows solved
    /// by then are kept.
    ///
    /// # Errors
    /// Unknown strategies, a geometry without a reference, Ctrl-C before the first row.
    pub fn run(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        told: impl FnMut(&Row),
    ) -> Result<Comparison, CompareError> {
        self.compared(registry, watch, told).map_err(|error| error.in_file(&self.origin))
    }

    fn compared(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        mut told: impl FnMut(&Row),
    ) -> Result<Comparison, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subject = self.subject()?;
        let (truth, reference) = self.reference(&subject, watch)?;
        let case = &subject.case;
        let coverages = Coverages::of(&case.scene);
        let on = |scheme| self.resolutions.iter().map(move |points| resolution(&case.scene, *points, scheme));
        let grids = self.schemes.iter().flat_map(|&scheme| on(scheme));
        let tasks: Vec<_> = grids.flat_map(|grid| strategies.iter().map(move |s| (grid, s))).collect();
        let mut rows = Vec::new();
        let mut keep = |row: Row| {
            told(&row);
            rows.push(row);
        };
        let end = tasks.iter().try_for_each(|(grid, (name, solver))| {
            self.row((name, &**solver), *grid, case, &coverages, &truth, watch).map(&mut keep)
        });
        let (rows, asked) = (kept(rows, end)?, tasks.len());
        Ok(Comparison { title: self.title.clone(), reference, registry: names_of(registry), asked, rows })
    }
}

fn names_of(registry: &Registry) -> Vec<String> {
    registry.names().map(String::from).collect()
}

/// A grid of the list; one point is enough along an axis that nothing depends on.
fn resolution(scene: &Scene, points: Points, scheme: Scheme) -> Resolution {
    let nx = if scene.uniform_in_plane() { 1 } else { points.points };
    let ny = if scene.uniform_in_y() { 1 } else { points.points };
    Resolution { nx, ny, cells: points.cells, scheme }
}
