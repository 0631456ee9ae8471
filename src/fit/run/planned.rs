//! What a fit will cost: its solves, and the processor time of a few of them.

use super::{FitError, FitRun, LINEARISATIONS, typical};
use crate::fit::load::FitTask;
use crate::fit::response::Origin;
use crate::fit::start::{Surface, TABLE_CELLS};
use crate::input::study::Study;
use crate::run::tangents::timed;
use num_complex::Complex64;

/// Points of the global search, and evaluations of the table in the descents from its paths, of
/// which a plan times one.
const EVALUATIONS: f64 = 400.0;
/// Solves that a plan times at the nodes of the table, and at a typical index.
const TRIED: [usize; 2] = [12, 6];

/// Solves, each with its derivatives, that a fit takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedSolves {
    /// Of the coarse table.
    pub table: usize,
    /// Of one linearisation on all cells.
    pub linearisation: usize,
    /// Of the predicted layers.
    pub predicted: usize,
}

impl PlannedSolves {
    /// Branches of n that are carried to the end at most.
    pub const BRANCHES: usize = 3;
    /// Linearisations of a fit: at least, and at most where all branches are carried to the end.
    pub const LINEARISATIONS: [usize; 2] = [LINEARISATIONS[0], Self::BRANCHES * LINEARISATIONS[1]];

    /// The solves of a fit.
    pub fn of(task: &FitTask) -> Self {
        let each = |coats: &[Study]| coats.iter().map(Study::solves_each).sum::<usize>();
        let cells = task.coats[0].realisations;
        let measured = each(&task.coats[..task.coats_measured]);
        Self {
            table: measured * Surface::indices(task).len() * TABLE_CELLS.min(cells),
            linearisation: measured * cells,
            predicted: if task.predicted.is_empty() { 0 } else { each(&task.coats) * cells },
        }
    }

    /// Most solves.
    pub fn most(&self) -> usize {
        self.table + Self::LINEARISATIONS[1] * self.linearisation + self.predicted
    }
}

/// Processor seconds of the parts of a fit.
#[derive(Clone, Copy, Debug)]
pub struct FitCosts {
    /// Of the coarse table, with the search on it.
    pub table: f64,
    /// Of one linearisation on all cells.
    pub linearisation: f64,
    /// Of the predicted layers.
    pub predicted: f64,
}

impl FitCosts {
    /// Processor seconds of a fit with a number of linearisations.
    pub fn total(&self, linearisations: usize) -> f64 {
        self.table + linearisations as f64 * self.linearisation + self.predicted
    }
}

impl FitRun<'_> {
    /// Processor seconds of the parts of this fit, from a few solves of every layer, spread over
    /// the nodes of the table, the wavelengths and the directions, and from one evaluation.
    ///
    /// # Errors
    /// As [`crate::run::tangents::Tangents::linearised`]; the films give no spectra.
    pub fn trial(&self) -> Result<FitCosts, FitError> {
        let task = self.task;
        let nodes = Surface::indices(task);
        let typical = typical(task);
        let solves = PlannedSolves::of(task);
        let layers = task.coats.len();
        let mut costs = FitCosts { table: 0.0, linearisation: 0.0, predicted: 0.0 };
        for (number, (coat, tangents)) in task.coats.iter().zip(&self.cells).enumerate() {
            let coat_at = |eta: [f64; 2]| {
                let eta = Complex64::new(eta[0], eta[1]);
                coat.with_index(task.pigment, &vec![eta; coat.wavelengths_nm.len()])
            };
            let spread = TRIED[0].div_ceil(layers).max(4);
            let of_table: Vec<Study> =
                (0..spread).map(|k| coat_at(nodes[k * nodes.len() / spread])).collect();
            let of_fit = vec![coat_at(typical); TRIED[1].div_ceil(layers).max(3)];
            let of_fit = tangents.trial(&of_fit, self.watch)?;
            let cells = coat.realisations as f64;
            let all_cells = cells * (of_fit.geometry + coat.solves_each() as f64 * of_fit.solve);
            if number < task.coats_measured {
                let of_table = tangents.trial(&of_table, self.watch)?;
                let each = (nodes.len() * TABLE_CELLS * coat.solves_each()) as f64;
                costs.table += each * of_table.solve + cells * of_fit.geometry;
                costs.linearisation += cells * coat.solves_each() as f64 * of_fit.solve;
            }
            if solves.predicted > 0 {
                costs.predicted += all_cells;
            }
        }
        let index = vec![typical; task.wavelengths_nm().len()];
        let (seconds, response) =
            timed(|| Origin::Film.response(task, &task.measured, &index, 0.0).map(drop));
        response?;
        costs.table += EVALUATIONS * seconds;
        Ok(costs)
    }
}
