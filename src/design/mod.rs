//! From a target colour to recipes: response surfaces of spectra over the fields of a study, and
//! runs that verify what they answer.
//!
//! [`file`](mod@file) (as written) → [`recipe`] (a point of the box → a checked study) →
//! [`surface`](mod@surface) (spectra less the coherent film as polynomials) → [`run`](mod@run)
//! (design, search, verifying runs) → [`publish`](mod@publish). Weighted numbers that are wanted beside
//! a colour, or without one, are in [`wish`](mod@wish).

pub mod file;
pub mod publish;
pub mod recipe;
pub mod run;
pub mod surface;
pub mod wish;
