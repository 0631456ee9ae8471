//! The wave equation: scene, grid, contrast field, mean operator, incident wave, discrete problem.
//!
//! Lengths are in µm, angles in degrees, time factor e^{−iωt}; the layer is 0 ≤ z ≤ H and light
//! from the incident side travels towards +z.

mod bloch;
pub(crate) mod contrast;
mod error;
mod far_field;
mod geometry;
pub(crate) mod grid;
pub(crate) mod light;
pub mod maxwell;
pub(crate) mod operator;
mod overlap;
pub(crate) mod physical;
pub(crate) mod scene;
pub(crate) mod system;

pub use bloch::Snapped;
pub use contrast::coverage::{Coverage, Precision, Stop};
pub use error::WaveError;
pub use far_field::{FURTHER, FarField, Order};
pub use geometry::Geometry;
pub use grid::element::Element;
pub(crate) use grid::element::MAX_DEGREE;
pub use grid::{Channel, Field, Grid, Layout, MOST_POINTS, Resolution, Scheme};
pub(crate) use light::Polarisation;
pub use light::{Incidence, Side, Wave};
pub use operator::banded::ShiftedMean;
pub(crate) use operator::cell::decaying_root;
pub use operator::inverse::MeanInverse;
pub use operator::mean::MeanOperator;
pub use operator::problem::{DIRECTIONS, Mean, Medium, Problem};
pub use operator::scattering::{Scatter, Scattering};
pub use operator::setting::{PHASE_LIMIT, Setting};
pub use physical::{TotalErrors, Unphysical};
pub use scene::{Body, BodyShape, HeightField, Material, Media, Scene, Stratum, Uniaxial, mean_of_rays};
pub use system::System;
