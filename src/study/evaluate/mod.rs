//! From stored solves to numbers with errors: spectra, hemispherical means, curves against angle,
//! distributions, ink on paper, and the results of a study.
//!
//! Every realisation has its own cell, azimuth, directions and wavelengths, drawn uniformly
//! ([`crate::input::variation`]). Each one is therefore an unbiased sample of everything, and the
//! jackknife over realisations covers randomness, cell, angles and wavelengths together. The fitted
//! quantity ([`regression`], over [`wavelengths`]) is the *difference from the coherent [`film`]*,
//! which contains the layer's interference fringes.

pub mod coherent;
pub mod composed;
pub mod directional;
pub mod evaluated;
pub mod film;
pub mod films;
pub mod gate;
pub mod ink;
pub mod ink_maker;
pub mod layer;
pub mod levels;
pub mod manifest;
pub mod numbers;
pub mod on_paper;
pub mod printed;
pub mod prints;
pub mod published;
pub mod quantities;
pub mod regression;
pub mod samples;
pub mod seen;
pub mod summary;
pub mod summed;
pub mod survivors;
mod uncertainty;
pub mod wavelengths;
