//! Experiments that compare methods: strategies × grids × discretisations, with their page.

pub mod error;
pub mod experiment;
pub mod matrix;
mod matrix_page;
pub mod pages;
pub mod subject;
