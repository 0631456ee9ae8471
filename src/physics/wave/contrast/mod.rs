//! The contrast V = k² − ⟨k²⟩ by geometry alone: the coverage of every plane's neighbourhood by
//! each material.
//!
//! [`coverage`] combines the cuts of bodies with planes ([`section`]), the transform of their edges
//! ([`nufft`]), the space beyond a relief and the harmonics beyond the grid ([`folding`]).

pub mod coverage;
pub mod folding;
pub mod nufft;
mod relief;
pub mod section;
mod solid;
