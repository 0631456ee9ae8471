//! What was asked: the study file, checked, and the run that carries it out.

pub mod case;
mod case_checks;
pub mod check;
pub mod checked;
pub mod crew;
pub mod fault;
pub mod file;
pub mod forms;
pub mod identity;
pub mod load;
pub mod locate;
pub mod optics;
pub mod publish;
pub mod resolve;
pub mod runner;
pub mod seen;
pub mod sheet;
pub mod summary;
pub mod watch;
