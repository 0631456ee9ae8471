//! What things are made of: refractive indices n + iκ against wavelength, and mixtures.

pub mod spectra;
