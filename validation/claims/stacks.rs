//! Stacks of layers as study files describe them: `[[layer]]`.

mod clear;
mod placed;

pub use clear::CLAIM as CLEAR;
pub use placed::CLAIM as PLACED;
