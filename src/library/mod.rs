//! Libraries of plates: gathered from folders of finished studies, and the page that composes them.

pub mod gather;
pub mod page;
