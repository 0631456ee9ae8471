//! A comparison: strategies × means × grids × discretisations on one case, or on all cases of a
//! matrix, side by side.

mod cases;
mod file;
mod reference;
mod rows;

pub use super::error::{CompareError, CompareResult};
pub use file::{ComparedCase, ComparisonFile, GoalWritten, MatrixTable, Points};

use super::error::kept;
use super::external::CaseAsked;
use super::external::judge::expected;
use super::external::protocol::ProgramDescription;
use super::machine::Machine;
use super::page::Comparison;
use super::row::Row;
use crate::solve::{Registry, Solver, Watch};
use cases::Subject;
use reference::{coverages, sized};
use rows::{Bench, absorbs};

/// Size of a comparison before it is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComparisonPlan {
    /// Bodies of the geometry (of the first case).
    pub bodies: usize,
    /// Number of solves, without those of grid searches and repetitions.
    pub rows: usize,
}

/// A strategy with its name.
pub(super) struct NamedStrategy {
    pub name: String,
    pub solver: Box<dyn Solver>,
}

/// What is compared on every case.
struct Entrants<'a> {
    strategies: &'a [NamedStrategy],
    /// What each program of the file says of itself.
    programs: &'a [Option<ProgramDescription>],
}

impl ComparisonFile {
    /// Plans the comparison without solving: packs the geometry and checks everything.
    ///
    /// # Errors
    /// As [`ComparisonFile::run`], except those of solves.
    pub fn plan(&self, registry: &Registry) -> CompareResult<ComparisonPlan> {
        self.planned(registry).map_err(|error| error.in_file(&self.origin))
    }

    fn planned(&self, registry: &Registry) -> CompareResult<ComparisonPlan> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subjects = self.subjects()?;
        let mut bodies = None;
        // Cases of one period have one packing.
        for same in subjects.chunk_by(Subject::is_packed_like) {
            let case = same[0].case()?;
            let wave = same[0].wave;
            if let Some(points) = self.listed() {
                let schemes = self.schemes(wave);
                let grids: Vec<_> = points.iter().map(|p| sized(&case.scene, *p, schemes[0])).collect();
                self.check_reference(wave, &case, &grids)?;
            }
            bodies.get_or_insert(case.scene.bodies.len());
        }
        Ok(ComparisonPlan { bodies: bodies.unwrap_or(0), rows: self.asked(&subjects, &strategies)? })
    }

    /// Number of rows; errors of every case are found on the way.
    fn asked(&self, subjects: &[Subject], strategies: &[NamedStrategy]) -> CompareResult<usize> {
        let mut rows = 0;
        for subject in subjects {
            let absorbs = absorbs(&subject.media()?);
            let schemes = self.schemes(subject.wave).len();
            let means =
                strategies.iter().map(|strategy| self.means(&*strategy.solver, absorbs).len()).sum::<usize>();
            rows += means * self.listed().map_or(1, |points| points.len()) * schemes;
        }
        Ok(rows + subjects.len() * self.external.iter().map(|program| program.knobs().len()).sum::<usize>())
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
    ) -> CompareResult<Comparison> {
        self.compared(registry, watch, told).map_err(|error| error.in_file(&self.origin))
    }

    fn compared(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        mut told: impl FnMut(&Row),
    ) -> CompareResult<Comparison> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subjects = self.subjects()?;
        let asked = self.asked(&subjects, &strategies)?;
        let described = self.external.iter().map(|program| program.described(self.folder(), watch));
        let programs = described.collect::<Result<Vec<_>, _>>()?;
        let mut rows = Vec::new();
        let mut keep = |row: Row| {
            told(&row);
            rows.push(row);
        };
        let entrants = Entrants { strategies: &strategies, programs: &programs };
        let end =
            subjects.iter().try_for_each(|subject| self.compare_on(subject, &entrants, watch, &mut keep));
        Ok(Comparison {
            title: self.title.clone(),
            file: self.origin.clone(),
            reference: reference_of(&subjects).into(),
            cases: subjects.iter().filter_map(Subject::shown).collect(),
            accuracy: self.searched(),
            goal: self.goal(),
            strategies: strategies.into_iter().map(|strategy| strategy.name).collect(),
            externals: self.external.iter().map(|program| program.name.clone()).collect(),
            programs: programs.into_iter().map(Option::unwrap_or_default).collect(),
            registry: registry.names().map(String::from).collect(),
            machine: Machine::here(),
            asked,
            rows: kept(rows, end)?,
        })
    }

    /// Computes every row of one case.
    fn compare_on(
        &self,
        subject: &Subject,
        entrants: &Entrants,
        watch: &mut dyn Watch,
        keep: &mut dyn FnMut(Row),
    ) -> CompareResult {
        let case = subject.case()?;
        let coverages = coverages(subject.wave, &case);
        let trials = self.trials(subject, &case, &coverages, watch)?;
        let truth = self.truth(subject, &case, &trials, watch)?;
        let bench = Bench { file: self, varied: subject.varied, case: &case, coverages: &coverages, truth };
        let mut keep = |row: Row| keep(Row { named: subject.named.clone(), ..row });
        for trial in &trials {
            for absorbing in [true, false] {
                for strategy in entrants.strategies {
                    let means = self.means(&*strategy.solver, absorbs(&case.media));
                    if let Some(mean) = means.into_iter().find(|mean| mean.absorbing == absorbing) {
                        keep(bench.row(strategy, mean, trial, watch)?);
                    }
                }
            }
        }
        let question = CaseAsked {
            varied: subject.varied,
            inputs: &subject.inputs(&case),
            case: &case,
            wave: subject.wave,
            expected: &expected(&bench.truth),
            folder: self.folder(),
        };
        for (program, described) in self.external.iter().zip(entrants.programs) {
            for knob in program.knobs() {
                keep(program.row(&question, knob, described.as_ref(), watch)?);
            }
        }
        Ok(())
    }
}

/// Reference of the errors, in words; several cases have their own.
fn reference_of(subjects: &[Subject]) -> &'static str {
    match subjects {
        [first, ..] if first.named.is_none() => first.reference(),
        _ => "the reference of each case",
    }
}
