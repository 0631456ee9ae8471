//! Placement of grains.
//!
//! A [`request`] is turned into bodies (`plan`), which [`pack`](mod@pack) places by random
//! sequential addition (`hard_bodies`) or relaxation of overlaps (`relaxation`) and, if requested,
//! equilibrates (`hard_bodies`). Their places in the `cell`, and the search for `neighbours`, are
//! those of one `arrangement`, which all methods move bodies by. The check in `overlap` shares no
//! code with them; only a result that passes it becomes a [`placed::Packing`].

mod arrangement;
pub(crate) mod cell;
mod cut;
mod demand;
mod fluctuation;
pub mod grain;
mod hard_bodies;
mod neighbours;
pub mod overlap;
pub mod pack;
pub mod placed;
mod plan;
mod relaxation;
pub mod request;
mod settle;
mod shell;
pub mod sizes;
