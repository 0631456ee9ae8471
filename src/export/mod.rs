//! Files for other programs, made from stored results.
//!
//! [`folder`] reads a [`finished`] study back, [`stored`] as a layer solved as a whole or
//! [`composed`] of slabs; [`exporter`] makes the files requested of either. Each writer takes
//! what it draws (numbers, a packing) and returns bytes; `scripts/check-exports` opens every file
//! with the program it is meant for.
//!
//! - [`mitsuba`]: a measured material for the renderer, with scenes and [`samples`] to check it
//! - [`spectra`]: the spectra of the [`print`](mod@print) with Lab for colour programs
//! - [`npz`]: far fields for NumPy, and a discrete problem with its solution
//! - [`voxels`], [`near_field`]: volumes for ParaView
//! - [`provenance`]: a research crate and a data package
//! - [`grains`]: positions of a packing, and a view of it in the browser

pub mod composed;
pub mod exporter;
pub mod finished;
pub mod folder;
pub mod grains;
pub mod mitsuba;
pub mod near_field;
pub mod npz;
pub mod print;
pub mod provenance;
pub mod request;
pub mod samples;
pub mod spectra;
pub mod stored;
pub mod voxels;
