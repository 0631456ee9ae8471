//! From a requested accuracy to a grid, and from solves on two grids to an error estimate.

mod companions;
mod error;
pub mod grid_error;
mod search;
mod several;
pub(super) mod task;

pub use companions::{error_estimate, largest_difference, largest_of_all};
pub use error::AccuracyError;
pub use search::{raised, smooth_size, suited_scheme};
pub use several::{SharedGrid, compared_directions};
pub use task::{Estimated, Solved, Task};
