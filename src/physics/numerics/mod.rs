//! Mathematics without physics: vectors and rotations, random draws, estimates with their errors, Fourier planes; and reading
//! of what people hand in, with the ranges allowed there.

pub mod allowed;
pub mod draws;
pub mod estimate;
pub mod files;
pub mod fourier;
pub mod linked;
pub mod periodic;
pub mod sequence;
pub mod vector;
pub mod written;

pub use draws::Draws;
pub use estimate::Estimate;
pub use vector::Rotation;
