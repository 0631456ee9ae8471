//! Mathematics of `inkwave` without physics: vectors and rotations, random draws, estimates with
//! their errors, Fourier planes, dense matrices; and reading of user files, with the allowed ranges
//! of numbers.
//!
//! Small functions of hot loops say `#[inline]`: incremental builds inline no others across crates.

#![warn(unnameable_types)]

pub mod allowed;
pub mod dense;
mod draws;
pub mod estimate;
pub mod exponential;
pub mod files;
pub mod fourier;
pub mod integral;
pub mod interpolate;
pub mod root;
pub mod vector;

pub use draws::{Draws, Sequence, are_weights, weighted};
