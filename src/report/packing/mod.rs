//! Files of a packing: coordinates, volumes for ParaView, pictures, statistics.

mod coordinates;
mod report;
mod vtk;

pub use coordinates::{grains_csv, packing_json};
pub use report::{is_of_one_packing, write_report};
pub use vtk::spheres_vtp;
