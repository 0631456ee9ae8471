//! The grid: points in the plane, cells in z, and the discretisation along z.
//!
//! A [`Layout`] is what a scene's mean medium and Bloch vector follow from.

pub mod element;

use super::{Material, Scene, WaveError};
use element::Element;
use ndarray::Array2;
use num_complex::Complex64;

/// Unknowns: rows are planes (nodes, with bubbles between them), columns harmonics.
pub type Field = Array2<Complex64>;

/// The discretisation in z (all share the exact boundary conditions of P2 (3.4)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Scheme {
    /// Exact difference scheme, contrast at the nodes with tent moments.
    Tents,
    /// Exact difference scheme with quadratic moments at nodes and midpoints.
    Quadratic,
    /// Exact difference scheme with cubic moments at Gauss–Lobatto points.
    #[default]
    Cubic,
    /// Exact difference scheme with quartic moments at Gauss–Lobatto points.
    Quartic,
    /// Second differences as in P2 section 3, with tent moments.
    SecondDifference,
}

impl Scheme {
    /// Number of planes added per cell.
    pub fn degree(self) -> usize {
        match self {
            Scheme::Tents | Scheme::SecondDifference => 1,
            Scheme::Quadratic => 2,
            Scheme::Cubic => 3,
            Scheme::Quartic => 4,
        }
    }
}

/// Resolution of a scene: points along x and y, cells along z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Resolution {
    /// Points along x, at least 1.
    pub nx: usize,
    /// Points along y, at least 1.
    pub ny: usize,
    /// Cells along z, at least 1.
    pub cells: usize,
    /// Discretisation along z.
    #[cfg_attr(feature = "serde", serde(default))]
    pub scheme: Scheme,
}

impl Resolution {
    /// Number of planes with unknowns: nodes, and inner points of the scheme.
    pub fn planes(&self) -> usize {
        self.scheme.degree() * self.cells + 1
    }
}

/// The cells in z: node heights and the stratum each cell lies in.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Requested points and cells.
    pub resolution: Resolution,
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Heights of the nodes from 0 to H, one more than cells.
    pub nodes_um: Vec<f64>,
    /// Background medium of each cell.
    pub background: Vec<usize>,
    /// Interpolation within a cell.
    pub element: Element,
}

impl Grid {
    /// Distributes the cells over the strata by thickness, so that interfaces coincide with nodes.
    ///
    /// Errors: zero points or cells; fewer cells than strata.
    pub fn new(scene: &Scene, resolution: Resolution) -> Result<Grid, WaveError> {
        check_counts(&resolution)?;
        let shares = share_cells(scene, resolution.cells)?;
        let mut nodes_um = vec![0.0];
        let mut background = Vec::new();
        let mut start = 0.0;
        for (stratum, cells) in scene.strata.iter().zip(shares) {
            let step = stratum.thickness_um / cells as f64;
            nodes_um.extend((1..=cells).map(|j| start + step * j as f64));
            background.extend(std::iter::repeat_n(stratum.background, cells));
            start += stratum.thickness_um;
        }
        let period_um = scene.period_um;
        let element = Element::new(resolution.scheme.degree());
        Ok(Grid { resolution, period_um, nodes_um, background, element })
    }

    /// Height of a cell, µm.
    pub fn height_um(&self, cell: usize) -> f64 {
        self.nodes_um[cell + 1] - self.nodes_um[cell]
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.background.len()
    }

    /// Number of planes with unknowns.
    pub fn planes(&self) -> usize {
        self.resolution.planes()
    }

    /// Number of points of a plane.
    pub fn points(&self) -> usize {
        self.resolution.nx * self.resolution.ny
    }

    /// Planes of a cell, including both nodes.
    pub fn planes_of_cell(&self, cell: usize) -> std::ops::RangeInclusive<usize> {
        let degree = self.element.degree;
        degree * cell..=degree * (cell + 1)
    }
}

/// Largest number of points along an axis, and of cells.
pub const MOST_POINTS: usize = 100_000;

fn check_counts(resolution: &Resolution) -> Result<(), WaveError> {
    let counts = [("nx", resolution.nx), ("ny", resolution.ny), ("nz (cells)", resolution.cells)];
    let wrong = counts.into_iter().find(|&(_, count)| count == 0 || count > MOST_POINTS);
    let Some((field, count)) = wrong else { return Ok(()) };
    Err(WaveError::range(field, count as f64, "1 … 100000", "choose another resolution"))
}

/// Distribution of the cells by largest remainders, with at least one cell per stratum.
///
/// # Errors
/// Fewer cells than strata.
pub(crate) fn share_cells(scene: &Scene, cells: usize) -> Result<Vec<usize>, WaveError> {
    if cells < scene.strata.len() {
        let allowed = "at least one cell for each stratum";
        return Err(WaveError::range("nz (cells)", cells as f64, allowed, "raise nz"));
    }
    let height = scene.thickness_um();
    let ideal: Vec<f64> = scene.strata.iter().map(|s| s.thickness_um / height * cells as f64).collect();
    let mut shares: Vec<usize> = ideal.iter().map(|x| (x.floor() as usize).max(1)).collect();
    // Add or remove single cells where the share is furthest from the ideal one.
    while shares.iter().sum::<usize>() != cells {
        let short = shares.iter().sum::<usize>() < cells;
        let need = |i: &usize| ideal[*i] / shares[*i] as f64;
        let best = (0..shares.len()).filter(|&i| short || shares[i] > 1).max_by(|a, b| {
            let order = need(a).total_cmp(&need(b));
            if short { order } else { order.reverse() }
        });
        let i = best.expect("cells ≥ strata leaves a stratum to change");
        shares[i] = if short { shares[i] + 1 } else { shares[i] - 1 };
    }
    Ok(shares)
}

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

/// A pair of materials: that of a body inside a background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Index into [`crate::wave::Media::backgrounds`].
    pub background: usize,
    /// Material of the bodies.
    pub material: Material,
}
