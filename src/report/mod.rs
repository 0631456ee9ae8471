//! What is kept: records, manifest, pages and figures.

pub mod folder;
pub mod manifest;
pub mod packing_record;
pub mod page;
pub mod record;
pub mod safely;
pub mod store;
pub mod tables;

pub use packing_record::PackingRecord;
pub use record::{PointRecord, SolveAccount};
pub use store::Store;
