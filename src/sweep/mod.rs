//! Studies of hundreds of variants: one file, one store, any number of machines.
//!
//! The path of a sweep: [`file`](mod@file) (as written) → [`expand`] (axes, exclusions, overrides → variants) → [`load`]
//! (every variant a checked [`Study`](crate::input::study::Study)) → [`units`] (what is computed together, shards) → [`run`](mod@run)
//! → [`publish`](mod@publish) (table, contact sheets, [`conclusions`], pages). [`plan`](mod@plan) says beforehand what it costs,
//! [`merge`](mod@merge) joins the stores of several machines.
//!
//! # The store
//! All variants share one store of small JSON files, named by the content hash of what they depend on: `points/`,
//! `packings/`, `grids/`, `failures/` (see [`crate::store::store`]). Variants that differ in their paper alone share their solves;
//! those that differ in the pigment's spectrum share their packings. Files were chosen over a database: each is
//! flushed and renamed into place, so a kill at any time loses the solves in flight and nothing else; any number
//! of processes may write at once, also on network file systems, where SQLite's write-ahead log is not safe;
//! merging is copying. `sweep.csv` is the table for spreadsheets, R and Python.

pub mod axes;
pub mod conclusions;
mod curves;
pub mod expand;
pub mod field;
pub mod file;
pub mod folder;
pub mod load;
pub mod merge;
pub mod outcome;
mod page;
pub mod plan;
pub mod publish;
pub mod run;
mod sheets;
pub mod sweep_page;
pub mod units;

pub use load::{Sweep, Variant};
