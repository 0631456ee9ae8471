//! The physics of `inkwave`, in the order of the light: mathematics, indices, grains and packings,
//! the wave equation, its solution, and appearance. The crate `inkwave` re-exports every module and
//! gives the tour.

#![warn(missing_docs)]

pub mod appearance;
pub mod ink;
pub mod material;
pub mod solve;
pub mod wave;

pub use inkwave_numerics as numerics;
