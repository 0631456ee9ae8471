//! What the claims, the tests and the benches share, and the claims themselves.
//!
//! [`claims`] are judged by `cargo test --test claims` and by `scripts/nightly`. [`referee`] and the functions `measure`
//! of [`claims::energy`] and [`claims::agreement`] take strategies from a registry, so that those of other crates join.
//! [`formulas`] share no code with the program; [`support`] reads the reference cases of `data/`.

pub mod cells;
pub mod claim;
pub mod claims;
pub mod ensemble;
pub mod fixtures;
pub mod formulas;
pub mod measured;
pub mod referee;
pub mod stacks;
pub mod studies;
pub mod support;
pub mod tiny;
pub mod vector;
