//! The referee: every strategy against the dense solve of the same discrete system, and the hypotheses behind them.

mod operators;
mod scattering;
mod strategies;

use inkwave_validation::tiny;
