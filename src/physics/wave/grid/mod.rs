//! The grid: points in the plane, cells in z, and the interpolation within a cell.

mod cells;
pub mod element;

pub(crate) use cells::share_cells;
pub use cells::{Grid, MOST_POINTS, Resolution, Scheme};
