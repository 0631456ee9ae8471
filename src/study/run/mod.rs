//! Carries a study out: a point (one solve), a realisation (one packing), the study, its resolution, work side by side.

pub mod collected;
pub mod crew;
pub mod error;
pub mod grids;
pub mod longer_waves;
pub mod memory;
pub mod point;
pub mod realisation;
pub mod resolve;
pub mod runner;
pub mod tangents;
pub mod watch;
