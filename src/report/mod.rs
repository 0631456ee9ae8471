//! What is kept: records, manifest, pages and figures.
