//! Strategies × contrast × absorption × size of the cell: what a wanted accuracy costs, who fails where, and why.
//!
//! For each pigment and period the grid comes from the search for the wanted accuracy with the reference strategy;
//! then every strategy solves the same discrete problem on that grid to the same residual.

use super::error::{CompareError, kept};
use super::subject::Packed;
use crate::input::case::Case;
use crate::run::memory;
use crate::solve::accuracy::{Estimated, Task, largest_difference};
use crate::solve::{Account, Coverages, Gmres, Goal, SolveError, Solver, Watch};
use crate::wave::{Mean, Scheme};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
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
    /// Wanted accuracy.
    pub accuracy: f64,
    /// Strategies in their order.
    pub strategies: Vec<String>,
    /// Solves asked for; fewer are there where it was stopped.
    pub asked: usize,
    /// Case by case, strategy by strategy.
    pub cells: Vec<Cell>,
}

impl MatrixTable {
    /// Refuses empty axes and accuracies that the search refuses.
    ///
    /// # Errors
    /// The field, what was found and what is allowed.
    pub fn check(&self) -> Result<(), CompareError> {
        let wrong = [
            ("matrix.pigments", self.pigments.is_empty()),
            ("matrix.periods_um", self.periods_um.is_empty()),
            ("matrix.accuracy", !(1e-6..=0.3).contains(&self.accuracy)),
        ];
        let Some((field, _)) = wrong.into_iter().find(|(_, wrong)| *wrong) else { return Ok(()) };
        let allowed = "at least one entry; an accuracy from 1e-6 to 0.3".to_string();
        let remedy = "give pigments = [[1.4, 0.1]], periods_um = [1.6]";
        Err(CompareError::Field { field, found: "empty or out of range".into(), allowed, remedy })
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
        let with = |&period_um| self.pigments.iter().map(move |&pigment| (period_um, pigment));
        let end = self.periods_um.iter().flat_map(with).try_for_each(|(period_um, pigment)| {
            let case = packed.varied(period_um, pigment)?.case()?;
            let reference = self.reference(&case, watch)?;
            strategies.iter().try_for_each(|(name, solver)| {
                let strategy = (name.as_ref(), &**solver);
                let cell = self.cell(strategy, pigment, period_um, &reference, watch)?;
                told(&cell);
                cells.push(cell);
                Ok(())
            })
        });
        kept(cells, end)
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
        let problem = &reference.problem;
        let clock = Instant::now();
        let solved = solver.solve(problem, self.goal(), watch);
        let seconds = clock.elapsed().as_secs_f64();
        let (account, difference, outcome) = match solved {
            Ok(solution) => {
                let far = problem.far_field(&solution.field);
                let difference = largest_difference(&reference.far_field, &far);
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
        let resolution = problem.coverage.grid.resolution;
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
