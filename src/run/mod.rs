//! Carries a study out: a point (one solve), a realisation (one packing), the study, its resolution, work side by side.

pub mod collected;
pub mod crew;
pub mod error;
pub(crate) mod grids;
pub(crate) mod longer_waves;
pub mod memory;
pub mod point;
pub(crate) mod realisation;
pub mod resolve;
pub mod runner;
pub mod watch;
