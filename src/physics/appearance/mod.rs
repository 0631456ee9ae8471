//! Appearance: bidirectional distribution functions, the paper behind the layer, colour, and the
//! data of the picture.
//!
//! The path: [`FarField`](crate::wave::FarField)s of several realisations → [`bdf::Bdf`] (means
//! with standard errors) and the fits of `inkwave::evaluate` → [`paper`] (a Lambertian substrate
//! behind the layer, with multiple reflections) → [`colour::Colour`] and the
//! [`picture::InkPicture`] of P1 Fig. 6.
//!
//! [`film`] is the layer with its contents averaged within every plane, solved exactly: what such
//! fits take their differences from.
//!
//! Off this path, [`finite_area`] spreads the orders of one far field into the lobes of an
//! illuminated square (P2 section 4.1).
//!
//! The scalar wave model is exact for s-polarised light on plane layers. All appearance derived
//! from it is that of s-polarised light and approximates unpolarised light (P1 section 1).

pub mod bare_paper;
pub mod bdf;
mod bdf_binned;
mod bdf_orders;
mod cie;
pub mod colour;
pub mod composed;
pub mod film;
pub mod finite_area;
pub mod fluorescence;
pub mod halftone;
pub mod kubelka_munk;
mod lab;
pub mod paper;
pub mod paper_series;
pub mod picture;
pub mod tristimulus;
pub mod viewing;
pub mod weighted;
