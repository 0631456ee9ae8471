//! What is seen: bidirectional distribution functions, the paper behind, colour, and the picture's numbers.
//!
//! The path: [`FarField`](crate::wave::FarField)s of several realisations → [`bdf::Bdf`] (means with standard
//! errors) and [`paper::LayerOptics`] → [`paper::LayerOnPaper`] (a Lambertian substrate behind, light going back and
//! forth) → [`ink_on_paper::InkOnPaper`] (all wavelengths, errors over realisations) → [`colour::Colour`] and the
//! [`picture::InkPicture`] of P1 Fig. 6. [`angles::AngleRule`] says which angles to solve for.
//!
//! The wave model is scalar: it is exact for light polarised along the layer (s) on plane layers, and all
//! appearance derived from it is that of s-polarised light; unpolarised light is approximated by it (P1 section 1).

pub mod angles;
mod baseline;
pub mod bdf;
mod bdf_table;
pub mod colour;
pub mod directional;
pub mod ink_on_paper;
pub mod kubelka_munk;
mod layer_optics;
pub mod paper;
pub mod picture;
pub mod slab;
mod substrate;
pub mod tristimulus;
