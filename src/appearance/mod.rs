//! What is seen: bidirectional distribution functions, the paper below, colour and pictures.
//!
//! The path: [`FarField`](crate::wave::FarField)s of several realisations → BDFs (means with standard errors) →
//! [`paper`] (the layer on a Lambertian substrate) → [`colour`] (spectrum to Lab and sRGB) →
//! picture of P1 Fig. 6.
//!
//! The wave model is scalar: it is exact for light polarised along the layer (s) on plane layers, and all
//! appearance derived from it is that of s-polarised light; unpolarised light is approximated by it (P1 section 1).

pub mod angles;
pub mod colour;
pub mod estimate;
pub mod paper;
pub mod slab;
pub mod tristimulus;
