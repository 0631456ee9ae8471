//! The discrete problem (A + V) u = b: the mean operator A, exact in every harmonic, and the contrast V on the planes.

pub mod banded;
pub mod mean;
pub mod problem;
pub mod scattering;
mod transfer;

pub use problem::Problem;
