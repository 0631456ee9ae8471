//! All drawing: charts, bitmaps, and pictures of inks and of packings.

pub mod chart;
pub mod contact_sheet;
mod curve;
mod error;
pub mod figure;
mod frame;
mod leaf;
mod marks;
mod packing_pictures;
pub mod picture;
mod raster;
mod ticks;

pub use error::OutputError;
pub use packing_pictures::{cut_picture, perspective_picture, shape_sheet, top_picture};
