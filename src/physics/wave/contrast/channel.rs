//! Which materials meet in a cell.

use crate::wave::Material;

/// One pair of materials: a body's inside a background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Index into [`crate::wave::Media::backgrounds`].
    pub background: usize,
    /// What the bodies consist of.
    pub material: Material,
}
