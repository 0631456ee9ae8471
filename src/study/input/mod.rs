//! Input files: parsing and checking, with all errors reported at once.
//!
//! The path of a study: [`file`](mod@file) (as written) → [`check`](mod@check) → [`study::Study`]
//! (with its content hash). A [`case`] is one explicit geometry.

pub mod base;
pub mod case;
mod case_checks;
pub mod case_inputs;
pub mod check;
mod drawn;
pub mod fault;
pub mod field;
pub mod file;
pub mod forms;
pub mod limits;
pub mod load;
pub mod locate;
pub mod measured;
mod misfit;
pub mod positions;
pub mod read;
pub mod study;
pub mod tree;
pub mod variation;
pub mod voxels;
pub mod wave_kind;

pub use fault::{Allowed, Fault, Faults, as_written, keys_in_words};
pub use file::StudyFile;
pub use measured::MeasuredSpectrum;
pub use study::Study;
pub use variation::{CellRule, LightRule};
