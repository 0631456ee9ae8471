//! What was asked: the study file, checked, and the run that carries it out.

pub mod fault;
pub mod file;
pub mod identity;
pub mod locate;
