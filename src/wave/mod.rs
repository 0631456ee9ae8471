//! The wave equation: scene, grid, contrast field, mean operator, incident wave, discrete problem.

pub mod far_field;
pub mod incidence;

pub use far_field::{FarField, Order};
pub use incidence::{Incidence, Side};
