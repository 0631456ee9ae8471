//! Geometry from which a scene's mean medium and Bloch vector follow, for either wave.

use super::contrast::channel::Channel;
use crate::wave::{Grid, Scene};

/// Geometry without fields, common to the scalar wave and Maxwell's equations.
pub struct Layout {
    /// Points and cells.
    pub grid: Grid,
    /// Pairs of materials that share a cell.
    pub channels: Vec<Channel>,
    /// Per channel, mean of its indicator over each cell.
    pub fractions: Vec<Vec<f64>>,
    /// Axes along which the scene is uniform, so that one point suffices.
    pub uniform: [bool; 2],
}

impl Layout {
    /// The layout of a scene whose channels have the given mean in each cell, if they are in it.
    pub(super) fn new(
        scene: &Scene,
        grid: Grid,
        channels: Vec<Channel>,
        mean: impl Fn(usize, usize) -> Option<f64>,
    ) -> Layout {
        let of_channel = |c| (0..grid.cells()).map(|cell| mean(cell, c).unwrap_or(0.0)).collect();
        let fractions = (0..channels.len()).map(of_channel).collect();
        Layout { grid, channels, fractions, uniform: [scene.uniform_in_plane(), scene.uniform_in_y()] }
    }
}
