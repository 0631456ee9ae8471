//! Predicts what a printer-ink or paint layer looks like before it exists.
//!
//! The folders follow the path of the light, and dependencies run one way only:
//! `ink ← wave ← solve ← appearance ← report ← study`.

pub mod appearance;
pub mod evaluate;
pub mod ink;
pub mod report;
pub mod solve;
pub mod study;
pub mod wave;
