//! What is kept: one record for each finished solve, packing and grid, named by the content hash of what it depends on.
//!
//! A [`database`] keeps sealed records ([`seal`]) in one SQLite file for each worker ([`rows`], [`slot`]); [`store`] is the typed
//! door to it, [`mod@record`] and [`packing_record`] are what goes through. Damage counts as absence and is told ([`damage`]).
//! Workers of one folder share their tasks through a [`queue`]. [`folder`] is the place for everything a run writes, known
//! by its [`marker`], its processes by their `presence`; [`safely`] is the way it is written, [`identity`] the content hash, [`build`](mod@build) the program's own name.

mod aside;
pub mod build;
pub mod damage;
pub mod database;
pub mod folder;
pub mod identity;
pub mod marker;
pub mod packing_record;
pub mod partial;
mod presence;
pub mod queue;
pub mod record;
pub mod rows;
pub mod safely;
pub mod seal;
pub mod slot;
#[allow(clippy::module_inception)]
pub mod store;

pub use build::set_build;
pub use packing_record::PackingRecord;
pub use record::{PointRecord, SolveAccount};
pub use store::{Record, Store, same};
