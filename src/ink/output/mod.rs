//! What a packing leaves on disk: coordinates, volumes for ParaView, pictures, statistics.

mod coordinates;
mod error;
mod files;
mod pictures;
mod plots;
mod raster;
mod report;
mod vtk;

pub use coordinates::{grains_csv, packing_json, read_packing_json};
pub use error::OutputError;
pub use files::write_whole;
pub use pictures::{cut_picture, perspective_picture, shape_sheet, top_picture};
pub use plots::curve_plot;
pub use report::write_report;
pub use vtk::spheres_vtp;
