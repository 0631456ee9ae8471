//! The language of all input files, generated from the types that read them: JSON Schemas, from which editors complete
//! and underline, and an annotated file with every key.

mod annotated;
mod document;
mod tidy;
mod words;

pub use annotated::annotated;
pub use document::Document;
