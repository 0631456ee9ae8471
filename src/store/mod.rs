//! What is kept: one record for each finished solve, packing and grid, named by the content hash of what it depends on.
//!
//! [`store`] keeps small [`record`]s; [`folder`] is the place for everything a run writes, [`safely`] the way it is
//! written, [`identity`] the hash.

pub mod folder;
pub mod identity;
pub mod packing_record;
pub mod record;
pub mod safely;
#[allow(clippy::module_inception)]
pub mod store;

pub use packing_record::PackingRecord;
pub use record::{PointRecord, SolveAccount};
pub use store::Store;
