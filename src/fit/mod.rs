//! From measured drawdowns to a pigment's index n(λ) + iκ(λ), with errors.
//!
//! The path of a fit: [`file`](mod@file) (as written) → [`load`] (checked studies and spectra) →
//! [`response`] (reflectances and their derivatives, from tangents on common packings) → [`start`]
//! (global search on a coarse table of differences from the coherent film) → [`run`](mod@run)
//! (Gauss–Newton with a [`prior`] whose strength the evidence chooses) → [`publish`]. Opaque coats,
//! whose base is composed of slabs, take the way of [`composed`] in place of the middle three.

pub mod composed;
mod data;
pub mod face;
pub mod file;
pub mod law;
pub mod load;
pub mod prior;
pub mod publish;
pub mod response;
pub mod run;
pub mod start;
