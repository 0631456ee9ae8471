//! The discrete problem (A + V) u = b: the mean operator A, exact in every harmonic, and the
//! contrast V on the planes.

pub mod banded;
pub mod cell;
pub mod inverse;
pub mod mean;
pub mod problem;
pub mod scattering;
pub mod setting;
pub(in crate::wave) mod sharing;
