//! Strategies to solve the discrete problem (A + V) u = b, with a common trait and a common
//! residual.
//!
//! The residual is the relative one, ‖u₀ − (1 + A⁻¹V) u‖ / ‖u₀‖ with u₀ = A⁻¹b, the wave in the
//! mean medium. [`accuracy`] searches the grid for a requested error and estimates the error of the
//! result.

mod account;
pub mod accuracy;
mod basis;
pub mod demand;
pub mod gradient;
mod ledger;
mod registry;
mod solver;
mod strategies;
pub mod vectors;

pub use account::{Account, Goal, GridTrial, Silent, Solution, SolveError, Step, Watch};
pub use accuracy::task::Coverages;
pub use ledger::{Ledger, flat};
pub use registry::{Entry, Registry, SolverChoice};
pub use solver::{Demand, Size, Solver};
pub use strategies::{Bicgstab, Born, ConvergentBorn, Direct, Gmres, GuidedModes, Idr, Relaxation};
