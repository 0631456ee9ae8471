//! The commands: arguments in, library calls, errors told well.

pub mod diagnostics;
pub mod progress;
pub mod run;
pub mod stop;
