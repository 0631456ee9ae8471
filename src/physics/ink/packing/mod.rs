//! Placement of grains.
//!
//! A [`PackingRequest`](crate::ink::PackingRequest) is turned into bodies (`plan`), which
//! [`pack`](crate::ink::pack()) places by random sequential addition (`hard_bodies`) or relaxation
//! of overlaps (`relaxation`) and, if requested, equilibrates (`hard_bodies`). Their places in the
//! `cell`, and the search for `neighbours`, are those of one `arrangement`, which all methods move
//! bodies by. The check in `overlap` shares no code with them; only a result that passes it becomes
//! a [`Packing`](crate::ink::Packing).

mod arrangement;
pub(crate) mod cell;
mod cut;
mod demand;
mod depth;
mod fluctuation;
mod gradient;
pub(crate) mod grain;
mod hard_bodies;
mod neighbours;
mod optic;
pub mod overlap;
pub(crate) mod pack;
pub(crate) mod placed;
mod plan;
mod relaxation;
pub(crate) mod request;
mod settle;
mod shell;
pub mod sizes;
mod stack;
