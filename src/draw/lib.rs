//! All drawing: charts, bitmaps, pictures of inks and of packings; and what pages and tables are
//! made of: their style, their cells, their seals. Reports, exports and comparisons draw on it.

#![warn(missing_docs)]

pub mod cell;
pub mod chart;
pub mod contact_sheet;
mod curve;
pub mod figure;
mod leaf;
mod packing_pictures;
pub mod page;
pub mod picture;
mod raster;
pub mod seal;
mod ticks;

pub use figure::{DrawResult, OutputError};
pub use packing_pictures::{cut_picture, perspective_picture, shape_sheet, top_picture};

// The folders of the physics and of studies, under the names they have in `inkwave`.
use inkwave_study::{appearance, evaluate, ink, numerics, store};
