//! The computation of a study: a point (one solve), a realisation (one packing), the choice of the
//! grid, parallel execution. `sweep` distributes the realisations.

pub mod collected;
pub mod crew;
pub mod longer_waves;
pub mod memory;
pub mod point;
pub mod realisation;
pub mod resolve;
pub mod tangents;
pub mod watch;

pub use collected::{Collected, Failure, MovedSolves, Realisation, Refused, RunSettings, Stores};
pub use watch::RunError;
