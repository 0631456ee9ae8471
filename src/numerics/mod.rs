//! Mathematics without physics: vectors and rotations, random draws, estimates with their errors, Fourier planes.

pub mod draws;
pub mod estimate;
pub mod fourier;
pub mod sequence;
pub mod vector;

pub use draws::Draws;
pub use estimate::Estimate;
pub use vector::Rotation;
