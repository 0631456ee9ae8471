//! The ways to solve the discrete problem (A + V) u = b, all behind one trait and one yardstick.
//!
//! The yardstick is the relative residual ‖u₀ − (1 + A⁻¹V) u‖ / ‖u₀‖ with u₀ = A⁻¹b, the wave in the mean medium.

pub mod accuracy;
pub mod bicgstab;
pub mod born;
pub mod convergent_born;
pub mod coverages;
pub mod direct;
pub mod guided;
pub mod krylov;
mod least_squares;
mod ledger;
pub mod relaxation;
mod resolution;
pub mod solver;
mod system;
pub mod vectors;

pub use bicgstab::Bicgstab;
pub use born::Born;
pub use convergent_born::ConvergentBorn;
pub use coverages::Coverages;
pub use direct::Direct;
pub use guided::GuidedModes;
pub use krylov::Gmres;
pub use relaxation::Relaxation;
pub use solver::{Account, Goal, Silent, Solution, SolveError, Solver, SolverChoice, Step, Watch};
pub use system::System;
