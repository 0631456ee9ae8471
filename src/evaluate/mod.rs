//! From stored solves to numbers with error bars: spectra, distributions, ink on paper, and the manifest of a study.

pub mod manifest;
pub mod seen;
pub mod summary;
mod uncertainty;
