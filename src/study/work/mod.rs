//! The work on studies: what is computed together, in which order, by which process, and its
//! expected cost.
//!
//! A single study ([`alone`]) is worked off as a list of one [variant](variant::Variant), a sweep
//! as a list of many. Studies with the same packings are solved together, in [`units`]; the threads
//! and processes of a folder take units in turn ([`run`](mod@run)), in [`rounds`] until a study's
//! error bar is small enough. [`plan`](mod@plan) estimates the cost beforehand. Whether a bar is
//! small enough takes an evaluation, so that this folder comes after [`evaluate`](crate::evaluate).

pub mod alone;
pub mod plan;
pub mod rounds;
pub mod run;
pub mod units;
pub mod variant;
