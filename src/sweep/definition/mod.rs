//! The language of studies of many variants: a file as written, and what it means.

pub mod axes;
pub mod claims;
pub mod expand;
pub mod field;
pub mod file;
mod file_schema;
pub mod folder;
pub mod load;
mod seal;
mod sound;
