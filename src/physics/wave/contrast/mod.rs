//! The contrast V = k² − ⟨k²⟩ by geometry alone: which part of each plane's neighbourhood each material covers.
//!
//! [`coverage`] gathers it from the cuts of bodies with planes ([`section`]), the transform of their edges ([`nufft`]), the
//! void of a relief and the harmonics beyond the grid ([`folding`]).

pub(crate) mod cell;
pub mod channel;
pub mod coverage;
pub mod folding;
pub mod nufft;
mod relief;
pub mod section;
