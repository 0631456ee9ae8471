//! What is kept: records, manifest, pages and figures.

pub mod figures;
pub mod folder;
pub mod page;
pub mod record;
pub mod safely;
pub mod store;

pub use record::{PointRecord, SolveAccount};
pub use store::Store;
