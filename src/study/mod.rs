//! What was asked: the study file, checked, and the run that carries it out.
//!
//! The path of a study: [`file`](mod@file) (as written) → [`check`](mod@check) → [`checked`] (with its content hash, [`identity`]) →
//! [`runner`] (packings, grid, solves side by side, every finished solve in the store at once) → [`seen`] (spectra,
//! distributions, ink on paper) → [`publish`](mod@publish) (`results.json`, tables, picture, page).

pub mod case;
mod case_checks;
pub mod check;
pub mod checked;
pub mod compare;
pub mod crew;
pub mod fault;
pub mod file;
pub mod forms;
pub mod grid_error;
pub mod identity;
pub mod load;
pub mod locate;
pub mod optics;
pub mod publish;
pub(crate) mod realisation;
pub mod resolve;
pub mod runner;
pub mod seen;
pub mod sheet;
pub mod summary;
pub mod sweep;
mod uncertainty;
pub mod variation;
pub mod watch;
