//! Pairs of materials that meet in a cell.

use crate::wave::Material;

/// A pair of materials: that of a body inside a background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Index into [`crate::wave::Media::backgrounds`].
    pub background: usize,
    /// Material of the bodies.
    pub material: Material,
}
