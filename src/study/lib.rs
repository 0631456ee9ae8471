//! Studies of `inkwave`: what is asked, what is kept, the work, and numbers with error bars. The crate `inkwave` re-exports every
//! folder and is the tour.

#![warn(missing_docs)]

pub mod evaluate;
pub mod input;
pub mod run;
pub mod store;

// The physics under the names it has in `inkwave`.
pub use inkwave_physics::{appearance, ink, material, numerics, solve, wave};
