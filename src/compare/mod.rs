//! Experiments that compare methods: strategies × grids × discretisations on one case or many, with
//! their page.

pub mod check;
pub mod error;
pub mod experiment;
pub mod external;
pub mod machine;
pub mod page;
mod plots;
pub mod row;
pub mod subject;
