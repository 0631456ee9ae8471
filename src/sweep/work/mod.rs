//! The computation of a sweep: its expected cost, its distribution, and what is stored.

pub mod alone;
pub mod merge;
pub mod plan;
pub(crate) mod rounds;
pub mod run;
pub mod units;
