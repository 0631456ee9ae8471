//! Stacks of layers as study files describe them: `[[layer]]`.

mod clear;
mod open;
mod placed;

pub use clear::CLAIM as CLEAR;
pub use open::CLAIM as OPEN;
pub use placed::CLAIM as PLACED;
