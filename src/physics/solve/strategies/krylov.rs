//! GMRES with restart on (1 + A⁻¹V) u = u₀ (Saad and Schultz 1986), implemented here because no
//! maintained crate offers it for complex matrix-free operators.

mod run;

use super::guided::GuidedModes;
use super::idr::Idr;
use crate::solve::{Demand, Ledger, Size, Solution, SolveError, Solver, flat};
use crate::wave::system::Double;
use crate::wave::{Field, System};
use run::{KrylovRun, RightFactor};

/// Restarted GMRES; memory: the basis (at most `restart` vectors) and 4 vectors of 16 bytes per
/// unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Gmres {
    /// Basis vectors kept before a restart.
    pub restart: usize,
    /// Treatment of the mean slab's guided modes.
    pub guided_modes: GuidedModes,
}

impl Default for Gmres {
    fn default() -> Gmres {
        Gmres { restart: 150, guided_modes: GuidedModes::default() }
    }
}

/// Residuals above which single precision suffices for the basis: its rounding errors are at least
/// ten times smaller, and the decisive residual is always measured in double precision.
pub(super) const SINGLE: f64 = 5e-6;
/// Largest basis in single precision: beyond it, the loss of orthogonality costs more than it
/// saves.
const MOST_SINGLE: usize = 60;
/// Vectors besides the basis: guess, field, residual, incident wave, and work arrays of one step.
const OTHER_VECTORS: f64 = 9.0;
/// Fraction of scarce memory that the guided modes' dense block may use.
const GUIDED_SHARE: f64 = 0.3;
/// Longest basis.
const MOST_RESTART: usize = 100_000;
/// Shortest basis with which restarts still converge.
const LEAST_RESTART: usize = 20;
/// Share of scarce memory for the first basis of the vector wave, which is no shorter than
/// `SHORT_RESTART`: strong scatterers need the rest for the elimination of the lowest harmonics.
/// With all of it in a basis of 110 vectors, 15 % of n = 2.5, 250 nm, 2.4 µm, 620 nm was not solved
/// in 9 processor minutes; with this share it takes 20 s.
const FIRST_SHARE: f64 = 0.4;
const SHORT_RESTART: usize = 40;
/// Fraction of the residual above which a cycle hands over to short recurrences, in the vector wave
/// and for strong scatterers: orthogonalising there costs ten times what an application does
/// (measured on 15 % of n = 2.7, 250 nm, 440 nm, κ = 0: 29 s a polarisation with 535 applications,
/// 3 s with 950).
const SLOW: f64 = 0.1;
/// Upper limit on the growth of a basis that is too short, reached at once: applications with short
/// bases are lost. Beyond it, orthogonalisation costs more than another strategy.
const MOST_GROWTH: usize = 8;

impl Solver for Gmres {
    fn name(&self) -> &'static str {
        "krylov"
    }

    fn check(&self) -> Result<(), SolveError> {
        SolveError::unless_within("krylov.restart", self.restart, 1..=MOST_RESTART, "150 is usual")?;
        let GuidedModes { threshold, damped, .. } = self.guided_modes;
        let fields = [("krylov.guided_modes.threshold", threshold), ("krylov.guided_modes.damped", damped)];
        for (field, value) in fields {
            if value.is_nan() || value < 0.0 {
                return Err(SolveError::setting(field, value, "0 or above", "leave it out"));
            }
        }
        Ok(())
    }

    fn run(&self, ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        Growing { settings: *self, longest: 0 }.run(ledger, start)
    }

    fn demand(&self, size: &Size, bytes: f64) -> Demand {
        let vectors = |settings: &Gmres| size.fields(settings.restart as f64 + OTHER_VECTORS);
        let needs = |settings: &Gmres| vectors(settings) + settings.bytes_of_modes(size);
        let mut settings = *self;
        if needs(self) > bytes {
            settings.guided_modes = self.guided_modes.within(GUIDED_SHARE * bytes);
            if settings.most_vectors(size, bytes) < LEAST_RESTART.min(self.restart) {
                return Demand::fixed(needs(self));
            }
        }
        let most = settings.most_vectors(size, bytes);
        let share = SHORT_RESTART.max((FIRST_SHARE * most as f64) as usize);
        let first = if size.vector { share } else { most };
        settings.restart = self.restart.min(first).min(most);
        let longest = most.min(MOST_GROWTH * self.restart);
        let grows = longest > settings.restart;
        let fitted = Growing { settings, longest: if grows { longest } else { 0 } };
        let solver = (grows || settings != *self).then(|| Box::new(fitted) as Box<dyn Solver>);
        Demand { bytes: needs(&settings), solver }
    }
}

/// GMRES with the memory available to solves that stall.
struct Growing {
    settings: Gmres,
    /// Largest basis to which a stalled solve may grow; 0 if it may not.
    longest: usize,
}

impl Solver for Growing {
    fn name(&self) -> &'static str {
        self.settings.name()
    }

    fn demand(&self, size: &Size, bytes: f64) -> Demand {
        self.settings.demand(size, bytes)
    }

    fn run(&self, mut ledger: Ledger, start: Option<&Field>) -> Result<Solution, SolveError> {
        let problem = ledger.problem;
        if !problem.has_contrast() {
            ledger.note(0.0)?;
            let field = ledger.background.clone();
            return Ok(ledger.finish(field));
        }
        let [field, work] = ledger.from_zero(start)?;
        let correction = problem.split().and_then(|p| self.settings.guided_modes.correction(p));
        let correction = correction.map(RightFactor::Guided);
        let single = if ledger.goal.tolerance >= SINGLE { problem.single() } else { None };
        let restart = self.settings.restart.max(1);
        let first_cycle = true;
        let mut run = KrylovRun { ledger, field, work, correction, single, restart, first_cycle };
        let bytes = self.bytes_of_elimination(problem, size_of_val(flat(&run.field)));
        while !run.ledger.reached() {
            let before = run.ledger.account.residual;
            let steps = run.ledger.account.steps;
            match run.single {
                Some(operator) => run.cycle(operator, run.steps(run.restart.min(MOST_SINGLE), bytes))?,
                None => run.cycle(&Double(problem), run.steps(run.restart, bytes))?,
            }
            let after = run.ledger.measure(&run.field, &mut run.work);
            let room = self.longest >= 2 * Idr::default().shadow_space;
            if room && after > SLOW * before && run.is_strong() && !run.is_coarse() {
                run.solve_strong(bytes)?;
                continue;
            }
            if run.ledger.reached() {
                break;
            }
            let steps = run.ledger.account.steps - steps;
            if run.ledger.exhausted() || !run.eliminate_more(before, steps, bytes) {
                run.adapt(self, before).or_else(|failure| run.last_resort(failure))?;
            }
        }
        Ok(run.ledger.finish(run.field))
    }
}

impl Gmres {
    /// Number of basis vectors that fit into `bytes` besides everything else.
    fn most_vectors(&self, size: &Size, bytes: f64) -> usize {
        let vectors = (bytes - self.bytes_of_modes(size)) / size.fields(1.0) - OTHER_VECTORS;
        vectors.max(0.0) as usize
    }

    /// Largest memory of the guided modes in bytes, for solves of any difficulty.
    fn bytes_of_modes(&self, size: &Size) -> f64 {
        self.guided_modes.most_bytes(size).max(self.guided_modes.of_hard_solves().most_bytes(size))
    }
}

impl Growing {
    /// Memory for an elimination, bytes, given that of a vector: all that the basis may grow into.
    /// In the vector wave the basis has its own.
    fn bytes_of_elimination(&self, problem: &dyn System, vector: usize) -> f64 {
        let basis = if problem.vector().is_some() { self.settings.restart } else { 0 };
        (vector * self.longest.saturating_sub(basis)) as f64
    }

    /// Remedy for a solve that stalls with `restart` basis vectors.
    fn advice(&self, restart: usize) -> String {
        let more = 2 * restart;
        let by_hand = format!("raise restart: strategy = {{ krylov = {{ restart = {more} }} }}");
        let remedy = match self.longest {
            0 => by_hand,
            most if most < MOST_GROWTH * self.settings.restart => {
                format!(
                    "allow more memory (--memory-gb) or fewer solves at a time (--jobs): the basis may not grow beyond {most}"
                )
            }
            _ => format!("take strategy = \"bicgstab\", a finer grid, or {by_hand}"),
        };
        format!("a basis of {restart} vectors is too short for this problem; {remedy}")
    }
}

#[cfg(test)]
#[path = "krylov_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "krylov_hard_tests.rs"]
mod hard_tests;
