//! The definition of a sweep: its file, and the variants it describes.

pub mod axes;
pub mod claims;
pub mod expand;
pub mod file;
pub mod folder;
pub mod load;
