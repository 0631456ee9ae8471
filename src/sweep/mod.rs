//! Studies of many variants: one file, one store, any number of machines.
//!
//! The path of a sweep: [`file`](mod@file) (as written) → [`expand`] (axes, exclusions, overrides →
//! variants) → [`load`] (every variant a checked [`Study`](crate::input::study::Study)) →
//! [`units`](crate::work::units) (what is computed together, shards) → [`run`](crate::work::run) →
//! [`publish`](mod@publish) (table, contact sheets, [`conclusions`], pages).
//! [`plan`](crate::work::plan) estimates the cost beforehand, [`merge`](mod@merge) joins the stores
//! of several machines. The work itself is that of any study ([`work`](crate::work)).
//!
//! Of its folders each uses only those before it:
//!
//! ```text
//! definition ← merge, findings
//! ```
//!
//! # The store
//!
//! All variants share one store of sealed records, identified by the content hash of their inputs
//! (see [`crate::store::database`]). Variants that differ only in their paper share their solves;
//! those that differ in the pigment's spectrum share their packings. Every process writes an SQLite
//! file of its own: if it is killed, only the unfinished solves are lost, and any number of
//! processes of one machine can work in one folder. Machines without a common disk, or with a
//! network disk, compute shards in separate folders. `sweep.csv` is the table for spreadsheets, R
//! and Python.

pub mod definition;
pub mod findings;
pub mod merge;

pub use definition::load::Sweep;
pub use definition::{axes, claims, expand, file, folder, load};
pub use findings::{conclusions, outcome, publish, reported};
