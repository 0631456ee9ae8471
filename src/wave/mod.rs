//! The wave equation: scene, grid, contrast field, mean operator, incident wave, discrete problem.
//!
//! Lengths are in µm, angles in degrees, time factor e^{−iωt}; the layer is 0 ≤ z ≤ H and light from above
//! travels towards +z.

pub mod banded;
pub mod bloch;
pub mod coverage;
pub mod element;
pub mod error;
pub mod far_field;
pub mod folding;
pub mod fourier;
pub mod grid;
pub mod incidence;
pub mod mean;
pub mod nufft;
pub mod packed;
pub mod problem;
mod relief;
pub mod scene;
pub mod section;

pub use coverage::Coverage;
pub use error::WaveError;
pub use far_field::{FarField, Order};
pub use grid::{Grid, Resolution, Scheme};
pub use incidence::{Incidence, Side};
pub use problem::{Field, Mean, Problem};
pub use scene::{Ball, Body, HeightField, Media, Scene, Shape, Stratum};
