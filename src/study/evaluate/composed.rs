//! A composed layer: from the solves of its slabs to numbers with error bars.
//!
//! Every published number is a function of the ensemble-mean flux matrices of a few portions. Its
//! standard error is the jackknife over the realisations of each portion, added in squares; the
//! difference between slabs of h and of h/2, the model's own error; and what the grid's error of R
//! does.
//!
//! - [`level`] averages the portions' fluxes, [`stacked`] joins those of a stack of layers
//! - [`layer`] composes a layer of them; [`spectral`] reads its numbers at one wavelength,
//!   `medium` and [`distribution`] those of its medium and of its directions
//! - [`numbers`] gathers what a study asks for, `errors` adds the bars, `between` what fringes
//!   do between the wavelengths, `gate` withholds what cannot be right, and [`summary`] fills the
//!   manifest
//! - [`library`] keeps plates for a later [`composition`]
//! - [`view`] is the layer from every direction

mod between;
pub mod composition;
pub mod distribution;
mod errors;
mod gate;
pub mod layer;
pub mod level;
pub mod library;
mod medium;
pub mod numbers;
mod optics;
mod prints;
pub mod spectral;
pub mod stacked;
pub mod summary;
pub mod view;
