//! Files of a packing: coordinates, volumes for ParaView, pictures, statistics.

mod coordinates;
mod report;

pub use coordinates::{grains_csv, packing_json, spheres_vtp};
pub use report::{is_of_one_packing, write_report};
