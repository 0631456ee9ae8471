//! A comparison: strategies × means × grids × discretisations on one case, or on all cases of a
//! matrix, side by side.

mod cases;
mod file;
mod matrix;
mod means;
mod reference;
mod rows;
mod unused;

pub use super::error::CompareError;
pub use file::{ComparisonFile, GoalWritten, Points};
pub use matrix::MatrixTable;

use super::error::kept;
use super::page::Comparison;
use super::row::Row;
use crate::solve::{Coverages, Registry, Solver, Watch};
use cases::Subject;
use means::absorbs;
use reference::sized;
use rows::Bench;

/// What a comparison is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComparisonPlan {
    /// Bodies of the geometry (of the first case).
    pub bodies: usize,
    /// Solves, but for those of searches for a grid and of repetitions.
    pub rows: usize,
}

/// A strategy with the name that people call it by.
type NamedStrategy = (String, Box<dyn Solver>);

impl ComparisonFile {
    /// Rows of the comparison without a solve: the geometry is packed, and everything is checked.
    ///
    /// # Errors
    /// As [`ComparisonFile::run`], but those of solves.
    pub fn plan(&self, registry: &Registry) -> Result<ComparisonPlan, CompareError> {
        self.planned(registry).map_err(|error| error.in_file(&self.origin))
    }

    fn planned(&self, registry: &Registry) -> Result<ComparisonPlan, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subjects = self.subjects()?;
        let mut bodies = None;
        // Cases of one period have one packing.
        for same in subjects.chunk_by(|a, b| a.period_um() == b.period_um()) {
            let case = same[0].case()?;
            if let Some(points) = self.listed() {
                let schemes = self.schemes();
                let grids: Vec<_> =
                    points.iter().map(|points| sized(&case.scene, *points, schemes[0])).collect();
                self.check_reference(&case, &grids)?;
            }
            bodies.get_or_insert(case.scene.bodies.len());
        }
        Ok(ComparisonPlan { bodies: bodies.unwrap_or(0), rows: self.asked(&subjects, &strategies)? })
    }

    /// Rows asked for; faults of every case show on the way.
    fn asked(&self, subjects: &[Subject], strategies: &[NamedStrategy]) -> Result<usize, CompareError> {
        let grids = self.schemes().len() * self.listed().map_or(1, |points| points.len());
        let mut rows = 0;
        for subject in subjects {
            let absorbs = absorbs(&subject.media()?);
            rows += strategies.iter().map(|(_, s)| self.means(&**s, absorbs).len()).sum::<usize>();
        }
        Ok(rows * grids)
    }

    /// Runs every row with the strategies of `registry`; `watch` sees each solve's steps and can
    /// stop the comparison: rows solved by then are kept.
    ///
    /// # Errors
    /// Unknown strategies, layers that cannot be packed, a case without a reference, Ctrl-C before
    /// the first row.
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
        let subjects = self.subjects()?;
        let asked = self.asked(&subjects, &strategies)?;
        let mut rows = Vec::new();
        let mut keep = |row: Row| {
            told(&row);
            rows.push(row);
        };
        let end = subjects.iter().try_for_each(|subject| self.on(subject, &strategies, watch, &mut keep));
        Ok(Comparison {
            title: self.title.clone(),
            file: self.origin.clone(),
            reference: subjects.first().map_or("", Subject::reference).into(),
            accuracy: self.searched(),
            goal: self.goal(),
            strategies: strategies.into_iter().map(|(name, _)| name).collect(),
            registry: registry.names().map(String::from).collect(),
            asked,
            rows: kept(rows, end)?,
        })
    }

    /// Every row of one case.
    fn on(
        &self,
        subject: &Subject,
        strategies: &[NamedStrategy],
        watch: &mut dyn Watch,
        keep: &mut dyn FnMut(Row),
    ) -> Result<(), CompareError> {
        let case = subject.case()?;
        let coverages = Coverages::of(&case.scene);
        let absorbs = absorbs(&case.media);
        let trials = self.trials(&case, &coverages, watch)?;
        let truth = self.truth(subject, &case, &trials, watch)?;
        let bench = Bench { file: self, varied: subject.varied, case: &case, coverages: &coverages, truth };
        for trial in &trials {
            for absorbing in [true, false] {
                for (name, solver) in strategies {
                    let means = self.means(&**solver, absorbs);
                    if let Some(mean) = means.into_iter().find(|mean| mean.absorbing == absorbing) {
                        keep(bench.row((name, &**solver), mean, trial, watch)?);
                    }
                }
            }
        }
        Ok(())
    }
}
