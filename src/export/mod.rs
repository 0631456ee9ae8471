//! Files that other people's tools open, made from what is stored.
//!
//! [`stored`] reads a finished study back; [`run`](mod@run) makes the files asked for:
//! [`mitsuba`] a measured material for the renderer with scenes and [`samples`] to check it by · [`cxf`] and [`cgats`] the
//! [`print`](mod@print)'s spectra with Lab for colour programs · [`npz`] far fields for NumPy · [`voxels`] and
//! [`near_field`] as [`vti`] for ParaView · [`provenance`] a research crate and a data package ·
//! [`viewer`] a packing in the browser. Each writer takes plain
//! numbers and gives bytes; `scripts/check-exports` opens every file with the program it is meant for.

pub mod cgats;
pub mod cxf;
pub mod error;
pub mod mitsuba;
pub mod near_field;
pub mod npz;
pub mod print;
pub mod provenance;
pub mod run;
pub mod samples;
pub mod stored;
pub mod tensor;
pub mod viewer;
pub mod voxels;
pub mod vti;
