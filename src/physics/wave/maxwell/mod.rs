//! Maxwell's equations on the same scenes, grids and strategies: the vector wave in s and p
//! polarisation.
//!
//! Unknowns are two moments per cell of each component of E, the mean medium is exact per harmonic
//! as a TE and a TM problem, and the contrast is a symmetric tensor built from the grains' normals
//! ([`Averaging`]) and the optic axes of birefringent ones: with plain averaging the error is
//! proportional to the spacing, with the tensor to its third power. Homogeneous layers are exact.
//! Not supported: rough surfaces, and metals (Re η² < 0) as grains or around them.

mod absorption;
mod cell;
mod contrast;
mod crystal;
mod kernels;
mod mean;
mod moments;
mod power;
mod problem;
mod scattering;
mod solid_sources;
mod sources;
mod symmetric;

pub use crate::wave::light::Polarisation;
pub use contrast::Averaging;
pub use moments::{ChannelFields, NormalMoments};
pub(crate) use problem::coarse;
pub use problem::{Polarised, VectorProblem};
