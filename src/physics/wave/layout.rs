//! Geometry from which a scene's mean medium and Bloch vector follow, for either wave.

use super::contrast::channel::Channel;
use crate::wave::Grid;

/// Geometry without fields, common to the scalar wave and Maxwell's equations.
#[derive(Clone, Copy)]
pub struct Layout<'a> {
    /// Points and cells.
    pub grid: &'a Grid,
    /// Pairs of materials that share a cell.
    pub channels: &'a [Channel],
    /// Per channel, mean of its indicator over each cell.
    pub fractions: &'a [Vec<f64>],
    /// Axes along which the scene is uniform, so that there is no lattice.
    pub uniform: [bool; 2],
}
