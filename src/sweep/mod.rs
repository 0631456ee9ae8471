//! Studies of hundreds of variants: one file, one store, any number of machines.
//!
//! The path of a sweep: [`file`](mod@file) (as written) → [`expand`] (axes, exclusions, overrides → variants) → [`load`]
//! (every variant a checked [`Study`](crate::input::study::Study)) → [`units`] (what is computed together, shards) → [`run`](mod@run)
//! → [`publish`](mod@publish) (table, contact sheets, [`conclusions`], pages). [`plan`](mod@plan) says beforehand what it costs,
//! [`merge`](mod@merge) joins the stores of several machines.
//!
//! Three rooms, each of which uses those before it alone: `definition ← work ← findings`. A study alone is a sweep of one
//! variant ([`alone`]).
//!
//! # The store
//! All variants share one store of sealed records, named by the content hash of what they depend on (see
//! [`crate::store::database`]). Variants that differ in their paper alone share their solves; those that differ in the
//! pigment's spectrum share their packings. Every process writes an SQLite file of its own, so a kill at any time loses the
//! solves in flight and nothing else, and any number of processes of one machine may work in one folder. Machines that share
//! no disk, or a network disk, take shards in folders of their own. `sweep.csv` is the table for spreadsheets, R and Python.

pub mod definition;
pub mod findings;
pub mod work;

pub use definition::load::{Sweep, Variant};
pub use definition::{axes, claims, expand, field, file, folder, load};
pub use findings::{aim, composed, conclusions, outcome, publish, reported, sweep_page};
pub use work::{alone, merge, plan, portions, run, units};
