//! The commands, one file each.

pub mod compare;
pub mod diagnostics;
pub mod pack;
pub mod progress;
pub mod run;
pub mod solve;
pub mod stop;
