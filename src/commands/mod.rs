//! The commands, a file for each or for several of one subject.

#[macro_use]
pub mod terminal;

pub mod compare;
pub mod diagnostics;
pub mod export;
pub mod inverse;
pub mod library;
pub mod merge;
pub mod pack;
pub mod progress;
pub mod reference;
pub mod run;
pub mod solve;
mod solve_options;
mod solve_report;
pub mod sweep;
pub mod work;
