//! What was asked: the study file, checked, and the run that carries it out.
pub mod case;
