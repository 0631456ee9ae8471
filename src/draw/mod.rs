//! All drawing: charts, bitmaps, and pictures of inks and of packings.

pub mod chart;
pub mod contact_sheet;
mod curve;
pub mod figure;
mod leaf;
mod packing_pictures;
pub mod picture;
mod raster;
mod ticks;

pub use figure::{DrawResult, OutputError};
pub use packing_pictures::{cut_picture, perspective_picture, shape_sheet, top_picture};
