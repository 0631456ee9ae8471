//! From the solves of an ensemble to spectra, means over the hemisphere and curves over the angle, with their errors.
//!
//! Every realisation has its own cell, azimuth, directions and wavelengths, drawn evenly by a [`sequence`]; so each alone is an
//! unbiased sample of everything, and the jackknife over realisations holds chance, cell, angles and wavelengths at once. What
//! is fitted ([`regression`], over [`wavelengths`]) is the *difference to the coherent [`film`]*, which carries the layer's fringes.

pub mod film;
pub mod films;
pub mod ink;
pub mod layer;
pub mod on_paper;
pub mod regression;
pub mod samples;
pub mod sequence;
pub mod wavelengths;
