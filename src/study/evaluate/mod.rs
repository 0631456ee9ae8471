//! From stored solves to numbers with errors: spectra, hemispherical means, curves against angle,
//! distributions, ink on paper, and the results of a study.
//!
//! Every realisation has its own cell, azimuth, directions and wavelengths, drawn uniformly
//! ([`crate::input::variation`]). Each one is therefore an unbiased sample of everything, and the
//! jackknife over realisations covers randomness, cell, angles and wavelengths together. The fitted
//! quantity ([`regression`], over [`wavelengths`]) is the *difference from the coherent film*
//! ([`films`]), which contains the layer's interference fringes.
//!
//! - [`seen`] evaluates the complete realisations: [`layer`] without paper, [`ink`] on its paper by
//!   the formulas of [`on_paper`], [`prints`] in dots and on brightened paper
//! - [`composed`] does the same for layers composed of slabs
//! - error bars: `uncertainty` adds the scatter of the realisations, the grid ([`levels`]) and the
//!   solver's residual
//! - [`gate`] withholds numbers that cannot be right
//! - [`summary`] and [`composed::summary`] fill the [`manifest`], from which everything published
//!   is read; [`evaluated`] calls the one that a study needs

pub mod coherent;
pub mod composed;
pub mod directional;
pub mod evaluated;
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
