//! Descriptions of all input files: JSON Schemas, generated from the types that read them, for
//! completion and checks in editors, and a commented file with every key of each.

mod document;
mod tidy;

pub use document::Document;
