//! Studies of many variants: one file, one store, any number of machines.
//!
//! The path of a sweep: [`file`](mod@file) (as written) → [`expand`] (axes, exclusions, overrides →
//! variants) → [`load`] (every variant a checked [`Study`](crate::input::study::Study)) → [`units`]
//! (what is computed together, shards) → [`run`](mod@run) → [`publish`](mod@publish) (table,
//! contact sheets, [`conclusions`], pages). [`plan`](mod@plan) estimates the cost beforehand,
//! [`merge`](mod@merge) joins the stores of several machines. A single study is a sweep of one
//! variant ([`alone`]).
//!
//! Of its three folders each uses only those before it:
//!
//! ```text
//! definition ← work ← findings
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
pub mod work;

pub use definition::load::{Sweep, Variant};
pub use definition::{axes, claims, expand, field, file, folder, load};
pub use findings::{composed, conclusions, outcome, publish, reported};
pub use work::{alone, merge, plan, run, units};
