//! The wave equation: scene, grid, contrast field, mean operator, incident wave, discrete problem.
//!
//! Lengths are in µm, angles in degrees, time factor e^{−iωt}; the layer is 0 ≤ z ≤ H and light
//! from the incident side travels towards +z.

pub mod bloch;
pub mod contrast;
pub mod error;
pub mod far_field;
pub mod geometry;
pub mod grid;
pub mod light;
pub mod maxwell;
pub mod operator;
mod overlap;
pub mod physical;
pub mod scene;
pub mod system;

pub use bloch::Snapped;
pub use contrast::coverage::{Coverage, Precision};
pub use error::WaveError;
pub use far_field::{FURTHER, FarField, Order};
pub use geometry::Geometry;
pub(crate) use grid::element::{Element, MAX_DEGREE};
pub use grid::{Channel, Field, Grid, Layout, Resolution, Scheme};
pub use light::{Incidence, Polarisation, Side, Wave};
pub(crate) use operator::cell::decaying_root;
pub use operator::problem::{DIRECTIONS, Mean, Medium, Problem};
pub use operator::{scattering::Scatter, setting::Setting};
pub use physical::{TotalErrors, Unphysical};
pub use scene::{Ball, Body, BodyShape, HeightField, Material, Media, Scene, Stratum};
pub use system::System;
