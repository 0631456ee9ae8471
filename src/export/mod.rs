//! Files for other programs, made from stored results.
//!
//! [`stored`] reads a finished study back; [`run`](mod@run) makes the files requested, [`composed`]
//! does both for a composed layer. Each writer
//! takes plain numbers and returns bytes; `scripts/check-exports` opens every file with the program
//! it is meant for.
//!
//! - [`mitsuba`]: a measured material for the renderer, with scenes and [`samples`] to check it
//! - [`cxf`], [`cgats`]: the spectra of the [`print`](mod@print) with Lab for colour programs
//! - [`npz`]: far fields for NumPy; [`operator`]: a discrete problem with its solution
//! - [`voxels`], [`near_field`]: volumes for ParaView, as [`vti`]
//! - [`provenance`]: a research crate and a data package
//! - [`viewer`]: a packing in the browser

pub mod cgats;
pub mod composed;
pub mod cxf;
pub mod error;
pub mod mitsuba;
pub mod near_field;
pub mod npz;
pub mod operator;
pub mod positions;
pub mod print;
pub mod provenance;
pub mod run;
pub mod samples;
pub mod stored;
pub mod tensor;
pub mod viewer;
pub mod voxels;
pub mod vti;
