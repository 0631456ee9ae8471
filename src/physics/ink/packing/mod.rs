//! Placement of grains.
//!
//! A [`request`] is turned into bodies (`plan`), which [`pack`](mod@pack) places by random
//! sequential addition (`sequential`) or relaxation of overlaps (`relaxation`) and, if requested,
//! equilibrates (`monte_carlo`). The check in `overlap` shares no code with them; only a result
//! that passes it becomes a [`placed::Packing`].

mod bodies;
pub(crate) mod buckets;
pub(crate) mod cell;
mod cut;
mod fewer;
mod fluctuation;
pub mod grain;
mod loads;
mod monte_carlo;
mod neighbours;
mod overlap;
pub mod pack;
pub mod placed;
mod plan;
mod relaxation;
pub mod request;
mod sequential;
mod settle;
mod shell;
pub mod sizes;
mod strain;
pub mod voxels;
pub mod watch;
