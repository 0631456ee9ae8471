//! From a requested accuracy to a grid, and from solves on two grids to an error estimate.

mod companions;
pub mod coverages;
mod difference;
mod error;
pub mod grid_error;
mod resolution;
mod search;
mod task;

pub use companions::error_estimate;
pub use difference::{largest_difference, largest_of_all};
pub use error::AccuracyError;
pub use resolution::raised;
pub use resolution::smooth_size;
pub use search::suited_scheme;
pub use task::{Estimated, Solved, Task};
