//! Strategies × contrast × absorption × size of the cell: what a wanted accuracy costs, who fails where, and why.
//!
//! For each pigment and period the grid comes from the search for the wanted accuracy with the reference strategy;
//! then every strategy solves the same discrete problem on that grid to the same residual.

use super::error::{CompareError, applications, kept};
use super::subject::Packed;
use crate::input::case::Case;
use crate::input::limits;
use crate::numerics::allowed::Allowed;
use crate::run::memory;
use crate::solve::accuracy::{Estimated, Task, largest_difference};
use crate::solve::{Account, Coverages, Gmres, Goal, SolveError, Solver, Watch};
use crate::wave::{Mean, Scheme};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Instant;

/// The axes around the comparison's study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixTable {
    /// Indices [n, κ] of the first pigment, one case each.
    #[schemars(length(min = 1), example = [[1.4, 0.1]])]
    pub pigments: Vec<[f64; 2]>,
    /// Periods of the square cell, µm.
    #[schemars(length(min = 1), example = [1.6])]
    pub periods_um: Vec<f64>,
    /// Wanted largest error of any amplitude; residuals go to a hundredth of it.
    #[serde(default = "hundredth")]
    #[schemars(transform = crate::input::limits::ACCURACY.mark())]
    pub accuracy: f64,
    /// Most operator applications before a strategy counts as failed.
    #[serde(default = "thousand")]
    pub max_applications: usize,
}

fn hundredth() -> f64 {
    1e-2
}

fn thousand() -> usize {
    1000
}

/// One strategy on one case.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Real part of the pigment's index.
    pub n: f64,
    /// Imaginary part of the pigment's index.
    pub kappa: f64,
    /// Period of the cell, µm.
    pub period_um: f64,
    /// Name of the strategy.
    pub strategy: String,
    /// Points along x (and y) and cells along z.
    pub points: usize,
    /// Cells along z.
    pub cells: usize,
    /// Complex unknowns.
    pub unknowns: usize,
    /// Estimated error of the grid (from the search), largest amplitude.
    pub error_estimate: f64,
    /// Largest difference of any amplitude to the reference strategy's; none where the strategy failed.
    pub difference: Option<f64>,
    /// Relative residual reached.
    pub residual: f64,
    /// Operator applications.
    pub operator_applications: usize,
    /// Wall-clock seconds of the solve.
    pub seconds: f64,
    /// "converged", or why not.
    pub outcome: String,
}

impl Cell {
    /// True where the wanted residual was reached.
    pub fn converged(&self) -> bool {
        self.difference.is_some()
    }
}

/// A finished matrix of solves.
pub struct Matrix {
    /// Heading.
    pub title: String,
    /// The comparison's file.
    pub file: PathBuf,
    /// Wanted accuracy.
    pub accuracy: f64,
    /// Operator applications after which a strategy starts no further step.
    pub max_applications: usize,
    /// Strategies in their order.
    pub strategies: Vec<String>,
    /// All names of the registry, by whose order each strategy has its colour.
    pub registry: Vec<String>,
    /// Solves asked for; fewer are there where it was stopped.
    pub asked: usize,
    /// Case by case, strategy by strategy.
    pub cells: Vec<Cell>,
}

impl MatrixTable {
    /// Refuses empty axes, and entries that no study could have.
    ///
    /// # Errors
    /// The field, what was found and what is allowed.
    pub fn check(&self) -> Result<(), CompareError> {
        let axes = [("pigments", self.pigments.is_empty()), ("periods_um", self.periods_um.is_empty())];
        if let Some((axis, _)) = axes.into_iter().find(|(_, empty)| *empty) {
            let (field, allowed) = (format!("matrix.{axis}"), "at least one entry".into());
            let remedy = "give pigments = [[1.4, 0.1]], periods_um = [1.6]";
            return Err(CompareError::Field { field, found: "empty".into(), allowed, remedy });
        }
        let wrong = self.numbers().into_iter().find(|(_, value, allowed)| !allowed.holds(*value));
        if let Some((field, value, allowed)) = wrong {
            let remedy = "pigments are pairs [n, κ], periods some µm, an accuracy of 1e-2 is usual";
            return Err(CompareError::number(&field, value, allowed, remedy));
        }
        applications("matrix.max_applications", self.max_applications)
    }

    /// Every number with its place and what is allowed there.
    fn numbers(&self) -> Vec<(String, f64, Allowed)> {
        let mut all = vec![("matrix.accuracy".to_string(), self.accuracy, limits::ACCURACY)];
        for (k, [n, kappa]) in self.pigments.iter().enumerate() {
            all.push((format!("matrix.pigments[{k}][0]"), *n, limits::INDEX));
            all.push((format!("matrix.pigments[{k}][1]"), *kappa, limits::ABSORPTION));
        }
        let period = |(k, um): (usize, &f64)| (format!("matrix.periods_um[{k}]"), *um, limits::PERIOD_UM);
        all.extend(self.periods_um.iter().enumerate().map(period));
        all
    }

    /// Checks every case without a solve; layers differ by their period, so each of these is packed once.
    ///
    /// # Errors
    /// As [`MatrixTable::run`], but those of solves.
    pub(super) fn check_cases(&self, packed: &Packed) -> Result<(), CompareError> {
        self.check()?;
        for &period_um in &self.periods_um {
            packed.varied(period_um, self.pigments[0])?.case()?;
            let others = self.pigments[1..].iter();
            others
                .map(|&pigment| packed.varied(period_um, pigment)?.study())
                .collect::<Result<Vec<_>, _>>()?;
        }
        Ok(())
    }

    /// Solves every case with every strategy; `told` sees each finished one.
    ///
    /// # Errors
    /// Layers that cannot be packed, cases that the reference strategy cannot solve, Ctrl-C.
    pub(super) fn run(
        &self,
        packed: &Packed,
        strategies: &[(impl AsRef<str>, Box<dyn Solver>)],
        watch: &mut dyn Watch,
        mut told: impl FnMut(&Cell),
    ) -> Result<Vec<Cell>, CompareError> {
        self.check()?;
        let mut cells = Vec::new();
        let mut keep = |cell: Cell| {
            told(&cell);
            cells.push(cell);
        };
        let with = |&period_um| self.pigments.iter().map(move |&pigment| (period_um, pigment));
        let mut cases = self.periods_um.iter().flat_map(with);
        let end = cases.try_for_each(|varied| self.run_case(packed, strategies, varied, watch, &mut keep));
        kept(cells, end)
    }

    /// Solves the case of one period and pigment with every strategy; `keep` takes each finished one.
    fn run_case(
        &self,
        packed: &Packed,
        strategies: &[(impl AsRef<str>, Box<dyn Solver>)],
        (period_um, pigment): (f64, [f64; 2]),
        watch: &mut dyn Watch,
        keep: &mut dyn FnMut(Cell),
    ) -> Result<(), CompareError> {
        let case = packed.varied(period_um, pigment)?.case()?;
        let reference = self.reference(&case, watch)?;
        for (name, solver) in strategies {
            let strategy = (name.as_ref(), &**solver);
            keep(self.cell(strategy, pigment, period_um, &reference, watch)?);
        }
        Ok(())
    }

    fn goal(&self) -> Goal {
        Goal { tolerance: 1e-2 * self.accuracy, max_applications: self.max_applications }
    }

    /// The grid of the wanted accuracy and the reference strategy's far field on it.
    fn reference(&self, case: &Case, watch: &mut dyn Watch) -> Result<Estimated, CompareError> {
        let task = Task {
            coverages: &Coverages::of(&case.scene),
            media: &case.media,
            incidence: &case.incidence,
            // A real mean: relaxation blows up with a complex one, and all strategies share one problem.
            mean: Mean { absorbing: false, ..Mean::default() },
            scheme: Scheme::Cubic,
            solver: &Gmres::default(),
            goal: Goal { tolerance: 1e-2 * self.accuracy, ..Goal::default() },
            memory: memory::usable(),
        };
        Ok(task.solve_to_accuracy(self.accuracy, watch)?)
    }

    fn cell(
        &self,
        (name, solver): (&str, &dyn Solver),
        [n, kappa]: [f64; 2],
        period_um: f64,
        reference: &Estimated,
        watch: &mut dyn Watch,
    ) -> Result<Cell, CompareError> {
        let problem = reference.system();
        let clock = Instant::now();
        let solved = solver.solve(problem, self.goal(), watch);
        let seconds = clock.elapsed().as_secs_f64();
        let (account, difference, outcome) = match solved {
            Ok(solution) => {
                let far = problem.far_field(&solution.field);
                let difference = largest_difference(reference.far_field(), &far);
                (solution.account, Some(difference), "converged".to_string())
            }
            Err(cancelled @ SolveError::Cancelled { .. }) => return Err(cancelled.into()),
            Err(error) => {
                let account = error.account().cloned();
                (
                    account.unwrap_or_else(|| Account { residual: 1.0, ..Account::default() }),
                    None,
                    error.to_string(),
                )
            }
        };
        let resolution = problem.grid().resolution;
        Ok(Cell {
            n,
            kappa,
            period_um,
            strategy: name.to_string(),
            points: resolution.nx,
            cells: resolution.cells,
            unknowns: problem.unknowns(),
            error_estimate: reference.error_estimate,
            difference,
            residual: account.residual,
            operator_applications: account.operator_applications,
            seconds,
            outcome,
        })
    }
}
