//! The results of a sweep: outcomes, conclusions, tables, contact sheets and pages.

mod between;
pub mod conclusions;
mod continuous;
mod curves;
mod explore;
mod kept;
mod media;
pub mod outcome;
mod page;
pub mod publish;
pub mod reported;
mod sheets;
