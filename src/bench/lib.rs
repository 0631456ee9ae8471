//! The laboratory: experiments that compare methods, strategies × grids × discretisations on one
//! case or many, beside [programs](external) of others; their page; and the [conformity
//! test](mod@check) of a program.
//!
//! It is a crate of its own, and a leaf: the command `inkwave compare` and the schema of its files
//! use it, nothing else does, so that no result can come to depend on how it is compared.

#![warn(missing_docs)]

pub mod check;
pub mod error;
pub mod experiment;
pub mod external;
pub mod machine;
pub mod page;
mod plots;
pub mod row;
pub mod subject;

// The folders of drawing, studies and physics, under the names they have in `inkwave`.
use inkwave_draw as draw;
use inkwave_study::{ink, input, numerics, run, solve, store, wave};
