//! The work on a sweep: what it costs, who does what, and what the store has of it.

pub mod alone;
pub mod merge;
pub mod plan;
pub mod portions;
mod rounds;
pub mod run;
pub(crate) mod stored;
pub mod units;
