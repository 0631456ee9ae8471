//! What a scene's mean medium and Bloch vector are made from, whichever wave is solved on it.

use super::contrast::channel::Channel;
use crate::wave::Grid;

/// Geometry without fields: the same for the scalar wave and for Maxwell's equations.
#[derive(Clone, Copy)]
pub struct Layout<'a> {
    /// Points and cells.
    pub grid: &'a Grid,
    /// Pairs of materials that share a cell.
    pub channels: &'a [Channel],
    /// Per channel, mean of its indicator over each cell.
    pub fractions: &'a [Vec<f64>],
    /// Along which axes nothing changes, so that there is no lattice.
    pub uniform: [bool; 2],
}
