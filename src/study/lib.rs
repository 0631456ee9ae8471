//! Studies of `inkwave`: input files, storage, computation, and numbers with error bars. The crate
//! `inkwave` re-exports every folder and documents the whole.

#![warn(missing_docs)]

pub mod evaluate;
pub mod input;
pub mod run;
pub mod store;
pub mod work;

// The folders of the physics, under the names they have in `inkwave`.
pub use inkwave_physics::{appearance, ink, material, numerics, solve, wave};
