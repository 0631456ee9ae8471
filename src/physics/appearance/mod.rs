//! What is seen: bidirectional distribution functions, the paper behind, colour, and the picture's numbers.
//!
//! The path: [`FarField`](crate::wave::FarField)s of several realisations → [`bdf::Bdf`] (means with standard
//! errors) and the fits of `inkwave::evaluate` → [`paper`] (a Lambertian substrate behind the layer, light going back and
//! forth) → [`colour::Colour`] and the [`picture::InkPicture`] of P1 Fig. 6.
//!
//! Beside the path, [`finite_area`] spreads one far field's orders into the lobes of a lit square (P2 section 4.1).
//!
//! The wave model is scalar: it is exact for light polarised along the layer (s) on plane layers, and all
//! appearance derived from it is that of s-polarised light; unpolarised light is approximated by it (P1 section 1).

pub mod bdf;
mod bdf_binned;
mod bdf_orders;
pub mod colour;
pub mod error;
pub mod finite_area;
pub mod kubelka_munk;
pub mod paper;
pub mod picture;
mod substrate;
pub mod tristimulus;
pub mod viewing;
