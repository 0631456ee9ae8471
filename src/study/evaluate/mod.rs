//! From stored solves to numbers with error bars: spectra, means over the hemisphere, curves over the angle, distributions, ink on
//! paper, and the manifest of a study.
//!
//! Every realisation has its own cell, azimuth, directions and wavelengths, drawn evenly ([`crate::input::variation`]); so each alone is
//! an unbiased sample of everything, and the jackknife over realisations holds chance, cell, angles and wavelengths at once. What
//! is fitted ([`regression`], over [`wavelengths`]) is the *difference to the coherent [`film`]*, which carries the layer's fringes.

pub mod composed;
mod curves;
pub mod directional;
pub mod film;
pub mod films;
pub mod gate;
pub mod ink;
pub mod ink_maker;
pub mod layer;
pub mod manifest;
pub mod on_paper;
pub mod regression;
pub mod samples;
pub mod seen;
pub mod summary;
pub mod survivors;
mod uncertainty;
pub mod wavelengths;
