//! Reports: pages, tables, reports of packings, and the folder of published files.

pub mod columns;
mod numbers;
pub mod packing;
pub mod page;
pub mod publish;
pub(crate) mod scalar_error;
pub mod sheet;
pub mod tables;
