//! Materials: refractive indices n + iκ against wavelength, and mixtures.

pub mod columns;
pub mod dispersion;
pub mod kramers_kronig;
pub mod mixing;
pub mod named;
pub mod spectra;
pub mod synthetic;
pub mod text_table;
pub mod usable;
