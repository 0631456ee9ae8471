//! What is kept: records, manifest, pages and figures.
//!
//! [`store`] keeps one small [`record`] for each finished solve; [`folder`] is the place for everything a run
//! writes, [`safely`] the way it is written; [`manifest`] is `results.json`, [`tables`] the CSV files and [`page`]
//! the report.

pub mod folder;
pub mod manifest;
pub mod packing_record;
pub mod page;
pub mod record;
pub mod safely;
pub mod store;
pub mod sweep_page;
pub mod tables;

pub use packing_record::PackingRecord;
pub use record::{PointRecord, SolveAccount};
pub use store::Store;

pub mod comparison;
