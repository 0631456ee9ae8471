//! Predicts what a printer-ink or paint layer looks like before it exists.
//!
//! The folders follow the path of the light, and dependencies run one way only:
//! `numerics ← material ← ink ← wave ← solve ← appearance ← store ← input ← run ← evaluate ← draw ← report ← compare, sweep ← export`.

pub mod appearance;
pub mod compare;
pub mod draw;
pub mod evaluate;
pub mod export;
pub mod ink;
pub mod input;
pub mod material;
pub mod numerics;
pub mod report;
pub mod run;
pub mod solve;
pub mod store;
pub mod sweep;
pub mod wave;
