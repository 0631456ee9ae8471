//! The commands: arguments in, library calls, errors told well.

pub mod diagnostics;
pub mod run;
