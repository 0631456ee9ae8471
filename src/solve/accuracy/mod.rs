//! From a wanted accuracy to a grid, and from solves on two grids to an error estimate.

pub mod coverages;
mod difference;
pub mod discretisation;
pub mod grid_error;
mod resolution;
mod search;

pub use difference::largest_difference;
pub use resolution::smooth_size;
pub use search::*;
