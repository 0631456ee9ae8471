//! The language of all input files: JSON Schemas, generated from the types that read them, from which editors complete and
//! underline, and a commented file with every key.

mod document;
mod tidy;

pub use document::Document;
