//! The only place that draws: bitmaps, lines, pictures of inks and of packings.

pub mod contact_sheet;
mod curve_plot;
mod error;
pub mod figure;
mod leaf;
pub mod log_plot;
mod marks;
mod packing_pictures;
pub mod picture;
pub mod plots;
mod raster;
mod ticks;

pub use curve_plot::curve_plot;
pub use error::OutputError;
pub use packing_pictures::{cut_picture, perspective_picture, shape_sheet, top_picture};
