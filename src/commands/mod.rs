//! The commands, one file each.

#[macro_use]
pub mod say;

mod again;
pub mod compare;
pub mod completions;
mod composed;
pub mod design;
pub mod diagnostics;
pub mod export;
pub mod fit;
mod live;
pub mod materials;
pub mod memory;
pub mod merge;
pub mod pack;
pub mod progress;
pub mod run;
pub mod schema;
pub mod solve;
mod solve_gradient;
mod solve_light;
mod solve_report;
mod solve_study;
pub mod stop;
pub mod sweep;
pub mod work;
