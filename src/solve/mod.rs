//! The ways to solve the discrete problem (A + V) u = b, all behind one trait and one yardstick.
//!
//! The yardstick is the relative residual ‖u₀ − (1 + A⁻¹V) u‖ / ‖u₀‖ with u₀ = A⁻¹b, the wave in the mean medium.

pub mod accuracy;
pub mod born;
pub mod krylov;
pub mod solver;
pub mod vectors;

pub use born::Born;
pub use krylov::Gmres;
pub use solver::{Account, Goal, Silent, Solution, SolveError, Solver, SolverChoice, Step, Watch};
