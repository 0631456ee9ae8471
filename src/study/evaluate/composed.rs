//! A composed layer: from the solves of its slabs to numbers with error bars.
//!
//! Every published number is a function of the ensemble-mean flux matrices of a few portions. Its
//! standard error is the jackknife over the realisations of each portion, added in squares; the
//! difference between slabs of h and of h/2, the model's own error; and what the grid's error of R
//! does.

pub mod composition;
mod errors;
mod gate;
pub mod layer;
pub mod level;
pub mod library;
pub mod numbers;
mod optics;
mod prints;
pub mod stacked;
pub mod summary;
pub mod view;
