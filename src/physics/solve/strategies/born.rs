//! The Born series about the mean medium: u ← u₀ − A⁻¹V u (P2 (2.5)–(2.7)), and the
//! convergent Born series (Osnabrugge, Leedumrongwatthanakul, Vellekoop, J. Comput. Phys. 322
//! (2016) 113).
//!
//! In plane values, with D the lumped mass: L = Ã + iεD moves absorption into the propagator and V'
//! = V − iεD compensates it, so that (L + V')u = b is exactly the original system for every ε. With
//! γ = (i/ε)·(−V'/D) at every point, u ← u − γ (u − L⁻¹(b − V'u)) contracts if |V| ≤ ε. In a
//! two-phase medium every point would lie on the circle of convergence, so |V| is scaled below it
//! and the step shortened (Vettenburg and Vellekoop 2022).

use super::relaxation::contrasts;
use crate::solve::ledger::ratio_of_terms;
use crate::solve::{Demand, Ledger, Size, Solution, SolveError, Solver};
use crate::wave::ShiftedMean;
use crate::wave::{Field, Problem};
use ndarray::Array2;
use num_complex::Complex64;

/// Most steps between two looks at the residual.
const MOST_STEPS: usize = 10_000;

/// The Born series: adds terms until they are small; fails early if they grow.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Born {
    /// Steps over which the ratio of successive terms is averaged (geometric mean).
    pub window: usize,
}

impl Default for Born {
    fn default() -> Born {
        Born { window: 8 }
    }
}

impl Solver for Born {
    fn name(&self) -> &'static str {
        "born"
    }

    fn check(&self) -> Result<(), SolveError> {
        SolveError::unless_within("born.window", self.window, 1..=MOST_STEPS, "8 is usual")
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        ledger.holds_vectors(3);
        let mut field = start.cloned().unwrap_or_else(|| ledger.background.clone());
        let mut term = Field::zeros(field.dim());
        loop {
            // The residual is the next term of the series, so one application serves both purposes.
            let residual = ledger.measure(&field, &mut term);
            ledger.note(residual)?;
            if ledger.reached() {
                return Ok(ledger.finish(field));
            }
            match ratio_of_terms(&ledger.account.history, self.window) {
                Some(ratio) if ratio >= 1.0 => return Err(ledger.diverged(ratio)),
                ratio => ledger.judge(&advice(ratio))?,
            }
            field += &term;
            ledger.account.steps += 1;
        }
    }

    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        Demand::fixed(size.fields(6.0))
    }
}

fn advice(ratio: Option<f64>) -> String {
    format!("terms shrink by {:.4} per step; use krylov or allow more applications", ratio.unwrap_or(1.0))
}

/// The convergent Born series; the defaults were fastest on packed ink cells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ConvergentBorn {
    /// Largest |V| over ε: above 0, at most 1.
    pub scale: f64,
    /// Fraction of the full step.
    pub step: f64,
    /// Number of steps between evaluations of the residual.
    pub check_every: usize,
}

impl Default for ConvergentBorn {
    fn default() -> ConvergentBorn {
        ConvergentBorn { scale: 0.95, step: 0.85, check_every: 10 }
    }
}

impl Solver for ConvergentBorn {
    fn name(&self) -> &'static str {
        "convergent_born"
    }

    fn check(&self) -> Result<(), SolveError> {
        for (field, value) in [("convergent_born.scale", self.scale), ("convergent_born.step", self.step)] {
            if !(value > 0.0 && value <= 1.0) {
                return Err(SolveError::setting(field, value, "above 0, at most 1", "try 0.9"));
            }
        }
        let every = "convergent_born.check_every";
        SolveError::unless_within(every, self.check_every, 1..=MOST_STEPS, "10 is usual")
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        let problem = ledger.split()?;
        let mut scratch = Field::zeros(problem.shape());
        let mut field = ledger.first_field(start, &mut scratch)?;
        if ledger.reached() {
            return Ok(ledger.finish(field));
        }
        let mut series = BornSeries::new(problem, self, &field);
        ledger.account.bytes = series.bytes();
        loop {
            for _ in 0..self.check_every {
                series.step();
                ledger.account.steps += 1;
                ledger.account.operator_applications += 1;
            }
            field = series.unknowns();
            let residual = ledger.measure(&field, &mut scratch);
            ledger.note(residual)?;
            if ledger.reached() {
                return Ok(ledger.finish(field));
            }
            ledger.judge(
                "it converges slowly without absorption: use strategy = \"krylov\" or allow more applications",
            )?;
        }
    }

    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        // Five fields of the series, three of the ledger, and the banded factors with their work
        // arrays.
        Demand::fixed(size.fields(8.0 + 2.0 * (size.resolution.scheme.degree() as f64 + 1.0)))
    }
}

/// The iteration at the points of all planes.
struct BornSeries<'a> {
    problem: &'a Problem,
    shifted: ShiftedMean,
    /// V'/D and step · γ at the points.
    contrast: Array2<Complex64>,
    gamma: Array2<Complex64>,
    /// Row of the illuminated face, and b/D at its points.
    source: (usize, Vec<Complex64>),
    u: Array2<Complex64>,
    /// Work array within a step: the right-hand side b/D − V'/D u, then G applied to it.
    points: Array2<Complex64>,
    /// Harmonics of `points` on every plane.
    harmonics: Field,
}

impl<'a> BornSeries<'a> {
    fn new(problem: &'a Problem, settings: &ConvergentBorn, field: &Field) -> BornSeries<'a> {
        let plain = contrasts(problem);
        let largest = plain.iter().map(|v| v.norm()).fold(1e-300, f64::max);
        let shift = Complex64::new(0.0, largest / settings.scale);
        let contrast = plain.mapv(|v| v - shift);
        // γ = (i/ε)(−V'/D) in the sign convention of this operator: 1 where V vanishes.
        let gamma = contrast.mapv(|v| -settings.step * v / shift);
        let shifted = ShiftedMean::new(problem, shift, 1.0.into());
        let (row, b) = problem.source_at_points();
        let source = (row, b.iter().map(|b| b / shifted.mass[row]).collect());
        let mut u = Array2::zeros(contrast.dim());
        problem.planes_to_points(&problem.mean.to_planes(field), &mut u);
        let points = u.clone();
        let harmonics = Field::zeros(problem.shape());
        BornSeries { problem, shifted, contrast, gamma, source, u, points, harmonics }
    }

    fn bytes(&self) -> usize {
        (4 * self.u.len() + self.harmonics.len()) * size_of::<Complex64>() + self.shifted.bytes()
    }

    /// One step u ← u − γ (u − G (b − V'u)), with G the inverse of the shifted mean operator.
    fn step(&mut self) {
        let product = ndarray::Zip::from(&mut self.points).and(&self.u).and(&self.contrast);
        product.par_for_each(|l, &u, &v| *l = -v * u); // −(V'/D) u
        let (row, source) = &self.source;
        // + b/D, which vanishes except on the illuminated face
        self.points.row_mut(*row).iter_mut().zip(source).for_each(|(l, b)| *l += b);
        self.shifted.solve_points(self.problem, &self.points, &mut self.harmonics); // G D ·
        self.problem.planes_to_points(&self.harmonics, &mut self.points);
        let update = ndarray::Zip::from(&mut self.u).and(&self.points).and(&self.gamma);
        update.par_for_each(|u, &next, &g| *u -= g * (*u - next)); // u − γ (u − next)
    }

    fn unknowns(&self) -> Field {
        let mut planes = Field::zeros(self.problem.shape());
        self.problem.points_to_planes(&self.u, &mut planes);
        self.problem.mean.to_unknowns(&mut planes);
        planes
    }
}
