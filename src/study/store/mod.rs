//! Storage: one record per finished solve, packing and grid, identified by the content hash of its
//! inputs.
//!
//! A [`database`] keeps sealed records ([`seal`]) in one SQLite file per worker ([`rows`],
//! [`slot`]); [`store`] is the typed interface to it, [`mod@record`] and [`packing_record`] define
//! the records. Damaged records count as absent and are reported. The workers of a
//! folder share tasks through a [`queue`]. [`folder`] holds everything a run writes: it is
//! identified by its [`marker`], and [`safely`] writes files atomically. [`identity`] defines the
//! content hash and the name of the program.

mod aside;
pub mod database;
pub mod folder;
pub mod identity;
pub mod marker;
pub mod packing_record;
pub mod queue;
pub mod record;
pub mod rows;
pub mod safely;
pub mod seal;
pub mod slot;
#[allow(clippy::module_inception)]
pub mod store;

pub use database::Database;
pub use folder::OutputFolder;
pub use identity::{Key, METHOD_VERSION, set_build};
pub use packing_record::PackingRecord;
pub use record::{FailureRecord, PointRecord, SolveAccount};
pub use seal::Damage;
pub use store::{Record, Store, same};
