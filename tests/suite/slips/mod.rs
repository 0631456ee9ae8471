//! Slips that people make in study files, and what they must be told.

mod blank;
mod ink;
mod light;
mod number;
mod stack;

pub use blank::{BLANK, BLANK_IN_STACKS};
pub use ink::{INK, K};
pub use light::LIGHT;
pub use number::NUMBER;
pub use stack::{OF_STACKS, STACK};

/// A slip in the tiny study: what is replaced by what, and what the message must say.
pub struct Slip {
    pub from: &'static str,
    pub to: &'static str,
    /// Field, value found, allowed range, remedy.
    pub says: [&'static str; 4],
}

const fn slip(from: &'static str, to: &'static str, says: [&'static str; 4]) -> Slip {
    Slip { from, to, says }
}
