//! What is there: materials, grain shapes, packings and their statistics (no grid, no wave).

pub mod spectra;
